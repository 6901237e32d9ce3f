/* number.h: float32 as bits, and limits without division, library or NaN that gets through. */

#ifndef NUMBER_H
#define NUMBER_H

#include <stdint.h>

#include "linkage.h"

LINKAGE_BEGIN

#define NUMBER_NAN 0x7FC00000u  /* bits of a quiet NaN */
#define NUMBER_LARGEST 3.0e38f

static inline uint32_t number_bits(float x)
{
    union { float number; uint32_t word; } both;

    both.number = x;
    return both.word;
}

static inline float number_of(uint32_t word)
{
    union { float number; uint32_t word; } both;

    both.word = word;
    return both.number;
}

/* 1 if x is neither infinite nor NaN. */
static inline uint32_t number_finite(float x)
{
    return (uint32_t)((number_bits(x) & 0x7F800000u) != 0x7F800000u);
}

static inline float number_size(float x)
{
    return number_of(number_bits(x) & 0x7FFFFFFFu);
}

/* x limited to low .. high; NaN gives low. */
static inline float number_limited(float x, float low, float high)
{
    const float raised = (x >= low) ? x : low;

    return (raised <= high) ? raised : high;
}

LINKAGE_END

#endif
