/* siphash.h: SipHash-2-4 (Aumasson and Bernstein, 2012), a message authentication code of 64 bits with a key of 128 bits.
 *
 * Test: the authors' 64 vectors, tests/firmware/test_siphash.py. In words of 32 bits, without a library's 64-bit shifts. */

#ifndef SIPHASH_H
#define SIPHASH_H

#include <stdint.h>

#include "linkage.h"

LINKAGE_BEGIN

/* The tag of `count` bytes: tag[0] the low word, tag[1] the high one; key[0] holds the key's first four bytes, the first of them
 * in its low bits. */
void hysgen_siphash(const uint32_t key[4], const uint8_t *bytes, uint32_t count, uint32_t tag[2]);

LINKAGE_END

#endif
