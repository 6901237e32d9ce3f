/* everything_selftest.h: is this everything.c, on this machine, what it was verified to be? */

#ifndef EVERYTHING_SELFTEST_H
#define EVERYTHING_SELFTEST_H

#include <stdint.h>

/* Runs every function over fixed inputs and compares results, status words and counters with those of the reference,
 * bit for bit. Returns the number of mismatches: 0 if all is well. Needs no library. */
uint32_t everything_selftest(void);

#endif
