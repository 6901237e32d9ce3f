/* Arithmetic of each operation: hysgen.checking.symbolic.semantics in C. Names are op_<mnemonic>; operands in printed order. */
#ifndef OPERATIONS_H
#define OPERATIONS_H

#include <float.h>
#include <math.h>
#include <stdint.h>

#include "state.h"

#if FLT_EVAL_METHOD != 0
#error "the host computes float in a wider format: the engine's bits would differ; use SSE or another host"
#endif

enum {
    FAULT_MISALIGNED = 1,
    FAULT_OUTSIDE,
    FAULT_READ_ONLY,
    FAULT_REGISTER_CLASH,
    FAULT_PORT_CLASH,
    FAULT_BRANCH_CLASH,
    FAULT_NAN_TO_INTEGER,
    FAULT_NO_PACKET,
    FAULT_REFUSED,
    FAULT_CYCLE_LIMIT,
    FAULT_MODE,
    FAULT_RESET
};

/* Ends the run; the first fault is kept. */
void stop(c674x_t *m, uint32_t fault, uint32_t detail);

/* ---- single precision without denormals ---- */

float read_single(c674x_t *m, uint32_t image);
uint32_t write_single(c674x_t *m, float value);
uint32_t to_integer(c674x_t *m, double value);

#define op_addsp(m, a, b) write_single(m, read_single(m, a) + read_single(m, b))
#define op_subsp(m, a, b) write_single(m, read_single(m, a) - read_single(m, b))
#define op_mpysp(m, a, b) write_single(m, read_single(m, a) * read_single(m, b))
#define op_abssp(m, a) write_single(m, fabsf(read_single(m, a)))
#define op_cmpeqsp(m, a, b) ((uint32_t)(read_single(m, a) == read_single(m, b)))
#define op_cmpgtsp(m, a, b) ((uint32_t)(read_single(m, a) > read_single(m, b)))
#define op_cmpltsp(m, a, b) ((uint32_t)(read_single(m, a) < read_single(m, b)))
#define op_intsp(m, a) write_single(m, (float)(int32_t)(a))
#define op_intspu(m, a) write_single(m, (float)(uint32_t)(a))
#define op_spint(m, a) to_integer(m, rint((double)read_single(m, a)))
#define op_sptrunc(m, a) to_integer(m, trunc((double)read_single(m, a)))

/* ---- integers ---- */

static inline uint32_t shifted_left(uint32_t a, uint32_t b) { return (b & 63) > 31 ? 0 : a << (b & 63); }
static inline uint32_t shifted_right(uint32_t a, uint32_t b) { return (b & 63) > 31 ? 0 : a >> (b & 63); }
static inline uint32_t shifted_right_signed(uint32_t a, uint32_t b)
{
    uint32_t sign = a >> 31 ? 0xFFFFFFFFu : 0;
    return (b & 63) > 31 ? sign : (b & 63) == 0 ? a : a >> (b & 63) | sign << (32 - (b & 63));
}
static inline uint32_t rotated(uint32_t a, uint32_t b) { return (b & 31) == 0 ? a : a << (b & 31) | a >> (32 - (b & 31)); }
static inline uint32_t field(uint32_t first, uint32_t last)
{
    return first > last ? 0 : (0xFFFFFFFFu >> (31 - last)) & (0xFFFFFFFFu << first);
}
uint32_t leftmost(uint32_t bit, uint32_t a);
static inline int32_t low(uint32_t a) { return (int16_t)(a & 0xFFFF); }
static inline int32_t high(uint32_t a) { return (int16_t)(a >> 16); }
static inline uint32_t low_u(uint32_t a) { return a & 0xFFFF; }
static inline uint32_t high_u(uint32_t a) { return a >> 16; }

#define op_add(a, b) ((a) + (b))
#define op_sub(a, b) ((a) - (b))
#define op_and(a, b) ((a) & (b))
#define op_or(a, b) ((a) | (b))
#define op_xor(a, b) ((a) ^ (b))
#define op_andn(a, b) ((a) & ~(b))
#define op_abs(a) ((a) == 0x80000000u ? 0x7FFFFFFFu : (a) >> 31 ? 0u - (a) : (a))
#define op_addab(a, b) ((a) + (b))
#define op_addah(a, b) ((a) + 2u * (b))
#define op_addaw(a, b) ((a) + 4u * (b))
#define op_addad(a, b) ((a) + 8u * (b))
#define op_subab(a, b) ((a) - (b))
#define op_subah(a, b) ((a) - 2u * (b))
#define op_subaw(a, b) ((a) - 4u * (b))
#define op_shl(a, b) shifted_left(a, b)
#define op_shr(a, b) shifted_right_signed(a, b)
#define op_shru(a, b) shifted_right(a, b)
#define op_rotl(a, b) rotated(a, b)
#define op_ext(a, left, right) shifted_right_signed(shifted_left(a, left), right)
#define op_extu(a, left, right) shifted_right(shifted_left(a, left), right)
#define op_set(a, first, last) ((a) | field(first, last))
#define op_clr(a, first, last) ((a) & ~field(first, last))
#define op_cmpeq(a, b) ((uint32_t)((a) == (b)))
#define op_cmpgt(a, b) ((uint32_t)((int32_t)(a) > (int32_t)(b)))
#define op_cmplt(a, b) ((uint32_t)((int32_t)(a) < (int32_t)(b)))
#define op_cmpgtu(a, b) ((uint32_t)((a) > (b)))
#define op_cmpltu(a, b) ((uint32_t)((a) < (b)))
#define op_lmbd(bit, a) leftmost(bit, a)
#define op_mvk(a) (a)
#define op_mvkh(a, d) (((a) & 0xFFFF0000u) | low_u(d))
#define op_addk(a, d) ((a) + (d))
#define op_mpy(a, b) ((uint32_t)(low(a) * low(b)))
#define op_mpyu(a, b) (low_u(a) * low_u(b))
#define op_mpysu(a, b) ((uint32_t)low(a) * low_u(b))
#define op_mpyus(a, b) (low_u(a) * (uint32_t)low(b))
#define op_mpyh(a, b) ((uint32_t)(high(a) * high(b)))
#define op_mpyhu(a, b) (high_u(a) * high_u(b))
#define op_mpyhl(a, b) ((uint32_t)(high(a) * low(b)))
#define op_mpylh(a, b) ((uint32_t)(low(a) * high(b)))
#define op_mpyhlu(a, b) (high_u(a) * low_u(b))
#define op_mpylhu(a, b) (low_u(a) * high_u(b))
#define op_mpy32(a, b) ((a) * (b))

#endif
