/** @file
 * extended_selftest.h: is this extended.c, on this machine, what it was verified to be? */

#ifndef EXTENDED_SELFTEST_H
#define EXTENDED_SELFTEST_H

#include <stdint.h>

/** Runs every function over fixed inputs and compares results, status words and counters with those of the reference,
 * bit for bit. Needs no library.
 * @return the number of mismatches: 0 if all is well */
#ifdef __cplusplus
extern "C"
#endif
uint32_t extended_selftest(void);

#endif
