/* fuzz.h: invariants of the firmware, tried by random cases. */

#ifndef FUZZ_H
#define FUZZ_H

#include <stdint.h>

#define FUZZ_RANGE       0x01u  /* the voltage left low_V .. high_V, or is no number */
#define FUZZ_RATE        0x02u  /* the voltage moved by more than step_V in a sample */
#define FUZZ_APART       0x04u  /* model and stage apart by more than follow_um and the trim, and no fault told in time */
#define FUZZ_PARAMETERS  0x08u  /* the parameters to start with have changed by themselves */
#define FUZZ_REFUSED     0x10u  /* the voltage moved although the settings were refused */

/* One case; returns the invariant that broke, or 0. tracked: samples in TRACK are added. */
uint32_t fuzz_case(uint64_t seed, uint32_t *tracked);

/* `count` cases from `first` on: counts per invariant are added to broken; returns the first seed that broke one, else the largest. */
uint64_t fuzz_cases(uint64_t first, uint64_t count, uint32_t broken[6], uint32_t *tracked);

#endif
