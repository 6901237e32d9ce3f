/* bytes.h: words of 32 bits as bytes, the low byte first, whatever the processor's own order. */

#ifndef BYTES_H
#define BYTES_H

#include <stdint.h>

#include "linkage.h"

LINKAGE_BEGIN

static inline uint32_t bytes_word(const uint8_t *at)
{
    return (uint32_t)at[0] | ((uint32_t)at[1] << 8) | ((uint32_t)at[2] << 16) | ((uint32_t)at[3] << 24);
}

static inline void bytes_put(uint8_t *at, uint32_t word)
{
    at[0] = (uint8_t)(word & 0xFFu);
    at[1] = (uint8_t)((word >> 8) & 0xFFu);
    at[2] = (uint8_t)((word >> 16) & 0xFFu);
    at[3] = (uint8_t)((word >> 24) & 0xFFu);
}

/* A check word with one more word in it. Whatever single word of a list changes, its check word does. */
static inline uint32_t bytes_check(uint32_t check, uint32_t word)
{
    const uint32_t sum = check + word;

    return (sum << 5) - sum;  /* times 31, which is odd */
}

LINKAGE_END

#endif
