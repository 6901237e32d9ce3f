/* image.h: a model's parameters as bytes that can be sent to running firmware.
 *
 * Words of 32 bits, little-endian on the wire and in the store, whatever the processor:
 *
 *      0      magic "HYSI"
 *      1      version of this format
 *      2      bytes of the whole image
 *      3 .. 6 digest of all that the numbers must fit: ranges, partition, shapes of terms and input blocks
 *      7, 8   rules, weights
 *      9, 10  device: image_owner_t.device, the low word first
 *     11      build: MODEL_BUILD of the firmware that it is for, or 0 for any with this structure
 *     12      counter: larger than the largest seen, by IMAGE_STRIDE at most
 *     13 ..   slope[], offset[], gain[] of the rules, weight[] of the terms, half the integral of the feedback: float32 (bank.h)
 *      then   the words of settings_t; all 0: those that the firmware was built with
 *      then   CRC-32 of all bytes before
 *      last   two words: SipHash-2-4 of all bytes before, with the owner's key, the low word first
 *
 * An image is whole (size, CRC), authentic (MAC), right (magic, version, digest, rules, weights, device, build), of numbers (finite,
 * no denormals, settings that may run), and certified: gain, slope and the terms' loop stay within the limits that the model's own commit keeps. Otherwise
 * it is refused and nothing changes. */

#ifndef IMAGE_H
#define IMAGE_H

#include <stdint.h>

#include "bank.h"
#include "linkage.h"
#include "model.h"
#include "settings.h"

LINKAGE_BEGIN

#define IMAGE_MAGIC    0x49535948u
#define IMAGE_VERSION  4u
#define IMAGE_DEVICE   9u
#define IMAGE_BUILD    11u
#define IMAGE_COUNTER  12u
#define IMAGE_HEADER   13u
#define IMAGE_NUMBERS  BANK_WORDS
#define IMAGE_SETTINGS (IMAGE_HEADER + IMAGE_NUMBERS)
#define IMAGE_CRC      (IMAGE_SETTINGS + SETTINGS_WORDS)
#define IMAGE_MAC      (IMAGE_CRC + 1u)
#define IMAGE_WORDS    (IMAGE_MAC + 2u)
#define IMAGE_BYTES    (4u * IMAGE_WORDS)

/* Answers: why an image is refused. */
#define IMAGE_GOOD         0u
#define IMAGE_INCOMPLETE   1u  /* bytes are missing, or there are too many */
#define IMAGE_UNKNOWN      2u  /* not an image, or of another version */
#define IMAGE_DAMAGED      3u  /* the CRC does not fit the bytes */
#define IMAGE_FOREIGN      4u  /* numbers of another structure, range or partition */
#define IMAGE_NO_NUMBER    5u  /* a parameter is not finite, denormal or absurdly large */
#define IMAGE_NOT_STORED   7u  /* the board has no memory that survives power off */
#define IMAGE_UNCERTIFIED  6u  /* 6 + the answer of the model's commit, which is 2 to 5 */
#define IMAGE_FORGED       13u /* the MAC does not fit the bytes and the owner's key */
#define IMAGE_STRANGE      14u /* for another device */
#define IMAGE_OTHER_BUILD  15u /* for another build of the firmware */
#define IMAGE_KEYLESS      17u /* the owner's key is all zeros, which is no secret: no image is taken */
#define IMAGE_RISKY        18u /* hysgen_settings_check refuses its settings, or its feedback has more gain than the build's leaves room for */
#define IMAGE_REPLAYED     16u /* its counter is not larger than the largest seen, or by more than IMAGE_STRIDE */

/* Most that a counter rises at once: no image can use the counters up. */
#define IMAGE_STRIDE       65536u

/* Whose images are taken. One const instance per device, in memory that the link cannot read. */
typedef struct {
    uint32_t key[4];     /* of the MAC; all zeros: none, and no image is taken */
    uint32_t device[2];  /* stage and electronics, as in the image */
} image_owner_t;

/* Everything that one image's certification needs besides the image; 10 to 40 KiB, so it is the caller's. */
typedef struct {
    model_t model;
    model_learner_t learner;
    settings_t settings;
    bank_t offered;
} image_bench_t;

/* 1 if the owner has a key. */
uint32_t hysgen_image_keyed(const image_owner_t *owner);

/* Whole, authentic, right and of numbers? */
uint32_t hysgen_image_check(const uint8_t *bytes, uint32_t count, const image_owner_t *owner);

/* The certificates of an image that hysgen_image_check found good, and the check of its settings. If they hold, its numbers are in *bank. */
uint32_t hysgen_image_certify(const uint8_t *bytes, image_bench_t *bench, bank_t *bank);

/* Check word of the image's numbers: hysgen_bank_check of the parameters that they become. */
uint32_t hysgen_image_numbers(const uint8_t *bytes);

/* The image's settings, or those that the firmware was built with where it has none. */
void hysgen_image_settings(const uint8_t *bytes, const settings_t *built_in, settings_t *settings);

/* Word i of the image. */
uint32_t hysgen_image_word(const uint8_t *bytes, uint32_t i);

LINKAGE_END

#endif
