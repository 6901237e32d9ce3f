/* fuzz.h: invariants of the firmware, tried by random cases. */

#ifndef FUZZ_H
#define FUZZ_H

#include <stdint.h>

/* Broken invariants, as bits. */
#define FUZZ_RANGE       0x01u  /* the voltage left low_V .. high_V, or is not finite */
#define FUZZ_RATE        0x02u  /* the voltage changed by more than step_V in a sample */
#define FUZZ_APART       0x04u  /* TRACK, sound sensor: model and stage differ by more than follow_um, without a fault in time */
#define FUZZ_PARAMETERS  0x08u  /* parameters of the next start are neither built in nor of a certified image nor committed */
#define FUZZ_REFUSED     0x10u  /* the voltage is not the safe one although the settings were refused */
#define FUZZ_STORE       0x20u  /* a reset lost the parameters of an image that was acknowledged */
#define FUZZ_PANIC       0x40u  /* hysgen_firmware_panic changed the voltage, or left the amplifier on */
#define FUZZ_CORRECTION  0x80u  /* offset or correction beyond their limits while the inverse drives */
#define FUZZ_STUCK       0x100u /* the input moved by WATCHDOG_STUCK_V while the reading repeated itself, and no fault was told */
#define FUZZ_STATUS      0x200u /* a bit of the status word disappeared without CLEAR */
#define FUZZ_ARMED       0x400u /* the amplifier is on without a START since it was off, or behind a reset under power without CLEAR */
#define FUZZ_DRIFT       0x800u /* TRACK, a sensor that drifts: it is wrong by more than follow_um, without a fault in time */
#define FUZZ_INVARIANTS  12u

#define FUZZ_IMAGES      4u     /* images 0 to FUZZ_GOOD - 1 are certified, the others are refused */
#define FUZZ_GOOD        3u

#define FUZZ_FEATURES    4096u  /* state before and after x bit of the status word; answers of images and commits */

/* Images of the cases, FUZZ_IMAGES x IMAGE_BYTES bytes; once, before the first case. */
void fuzz_give(const uint8_t *images);

/* Bytes of an image. */
uint32_t fuzz_image_bytes(void);

/* One case of `interrupts` interrupts; returns the invariants that broke. features: FUZZ_FEATURES flags, set where reached. tracked:
 * interrupts in TRACK are added. */
uint32_t fuzz_case(uint64_t seed, uint32_t interrupts, uint8_t *features, uint64_t *tracked);

/* `count` cases from `first` on. broken: counts per invariant are added. features: as above; a seed that reaches one for the first
 * time is written to `finders`, at most `room`, and counted in *found. Returns the first seed that broke an invariant, else the
 * largest number. */
uint64_t fuzz_cases(uint64_t first, uint64_t count, uint32_t interrupts, uint32_t broken[FUZZ_INVARIANTS], uint64_t *tracked,
                    uint8_t *features, uint64_t *finders, uint32_t room, uint32_t *found);

/* Interrupts that came inside hysgen_firmware_idle since the library was opened, and different instructions that they came before. */
uint64_t fuzz_preemptions(void);
uint32_t fuzz_places(void);

#endif
