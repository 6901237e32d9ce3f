#include "image.h"

#include <stddef.h>

#include "bytes.h"
#include "crc32.h"
#include "number.h"
#include "siphash.h"

/* Largest number that a parameter can be: products of a few of them stay finite. */
#define IMAGE_LARGEST 1.0e6f

/* Calls of the model's commit: one snapshot, the check points, no trial of what learnt from no sample, writing, switching. */
#define IMAGE_MOST_CALLS (MODEL_COMMIT_POINTS + 4u)

/* Integral of the feedback against that of the build: half of the 6 dB that `hysgen loop` leaves it. */
#define IMAGE_LOOP 1.4f

static const uint32_t image_digest[4] = MODEL_DIGEST;

uint32_t hysgen_image_word(const uint8_t *bytes, uint32_t i)
{
    return bytes_word(&bytes[4u * i]);
}

static float image_number(const uint8_t *bytes, uint32_t i)
{
    return number_of(hysgen_image_word(bytes, IMAGE_HEADER + i));
}

/* 1 if x is 0 or a normal number of a size that a parameter can have. */
static uint32_t image_plausible(float x)
{
    const uint32_t size = number_bits(x) & 0x7FFFFFFFu;

    return (uint32_t)(size == 0u) | ((uint32_t)(size >= 0x00800000u) & (uint32_t)(size <= number_bits(IMAGE_LARGEST)));
}

uint32_t hysgen_image_numbers(const uint8_t *bytes)
{
    uint32_t check = 1u;

    for (uint32_t i = 0u; i < IMAGE_NUMBERS; ++i) {
        check = bytes_check(check, hysgen_image_word(bytes, IMAGE_HEADER + i));
    }
    return check;
}

/* 1 if the image has settings of its own. */
static uint32_t image_has_settings(const uint8_t *bytes)
{
    uint32_t any = 0u;

    for (uint32_t i = 0u; i < SETTINGS_WORDS; ++i) {
        any |= hysgen_image_word(bytes, IMAGE_SETTINGS + i);
    }
    return (uint32_t)(any != 0u);
}

void hysgen_image_settings(const uint8_t *bytes, const settings_t *built_in, settings_t *settings)
{
    const uint32_t own = image_has_settings(bytes);

    for (uint32_t i = 0u; i < SETTINGS_WORDS; ++i) {
        hysgen_settings_put(
            settings, i, (own != 0u) ? hysgen_image_word(bytes, IMAGE_SETTINGS + i) : hysgen_settings_word(built_in, i));
    }
}

uint32_t hysgen_image_keyed(const image_owner_t *owner)
{
    return (uint32_t)((owner->key[0] | owner->key[1] | owner->key[2] | owner->key[3]) != 0u);
}

/* 1 if the image bears the MAC of its bytes. Compared as a whole, so that the time does not tell where a guess is wrong. */
static uint32_t image_authentic(const uint8_t *bytes, const image_owner_t *owner)
{
    uint32_t tag[2];

    hysgen_siphash(owner->key, bytes, 4u * IMAGE_MAC, tag);
    return (uint32_t)(((tag[0] ^ hysgen_image_word(bytes, IMAGE_MAC)) | (tag[1] ^ hysgen_image_word(bytes, IMAGE_MAC + 1u))) == 0u);
}

/* 1 if the numbers are those of this model's structure. */
static uint32_t image_fits(const uint8_t *bytes)
{
    uint32_t same = (uint32_t)(hysgen_image_word(bytes, 2u) == IMAGE_BYTES);

    for (uint32_t i = 0u; i < 4u; ++i) {
        same &= (uint32_t)(hysgen_image_word(bytes, 3u + i) == image_digest[i]);
    }
    return same & (uint32_t)(hysgen_image_word(bytes, 7u) == MODEL_RULES) & (uint32_t)(hysgen_image_word(bytes, 8u) == MODEL_WEIGHTS);
}

static uint32_t image_of_numbers(const uint8_t *bytes)
{
    uint32_t plausible = 1u;

    for (uint32_t i = 0u; i < IMAGE_NUMBERS; ++i) {
        plausible &= image_plausible(image_number(bytes, i));
    }
    return plausible;
}

/* [S9] */
uint32_t hysgen_image_check(const uint8_t *bytes, uint32_t count, const image_owner_t *owner)
{
    uint32_t answer = IMAGE_GOOD;

    if (count != IMAGE_BYTES) {
        answer = IMAGE_INCOMPLETE;
    } else if ((hysgen_image_word(bytes, 0u) != IMAGE_MAGIC) || (hysgen_image_word(bytes, 1u) != IMAGE_VERSION)) {
        answer = IMAGE_UNKNOWN;
    } else if (hysgen_image_word(bytes, IMAGE_CRC) != hysgen_crc32(bytes, 4u * IMAGE_CRC)) {
        answer = IMAGE_DAMAGED;
    } else if (hysgen_image_keyed(owner) == 0u) {
        answer = IMAGE_KEYLESS;
    } else if (image_authentic(bytes, owner) == 0u) {
        answer = IMAGE_FORGED;
    } else if (image_fits(bytes) == 0u) {
        answer = IMAGE_FOREIGN;
    } else if ((hysgen_image_word(bytes, IMAGE_DEVICE) != owner->device[0])
               || (hysgen_image_word(bytes, IMAGE_DEVICE + 1u) != owner->device[1])) {
        answer = IMAGE_STRANGE;
    } else if ((hysgen_image_word(bytes, IMAGE_BUILD) != 0u) && (hysgen_image_word(bytes, IMAGE_BUILD) != MODEL_BUILD)) {
        answer = IMAGE_OTHER_BUILD;
    } else if (image_of_numbers(bytes) == 0u) {
        answer = IMAGE_NO_NUMBER;
    } else {
        /* Good so far: certification comes next. */
    }
    return answer;
}

/* The generated commit certifies the image: its numbers become the learnt bank of a separate learner, of the age that commit
 * requires, and are committed to a separate model, never to the one that drives the stage. */
uint32_t hysgen_image_certify(const uint8_t *bytes, image_bench_t *bench, bank_t *bank)
{
    bank_t *offered = &bench->offered;
    uint32_t answer = MODEL_BUSY;

    hysgen_image_settings(bytes, &bench->settings, &bench->settings);
    if ((image_has_settings(bytes) != 0u) && (hysgen_settings_check(&bench->settings) != NULL)) {
        return IMAGE_RISKY;
    }
    for (uint32_t i = 0u; i < IMAGE_NUMBERS; ++i) {
        hysgen_bank_put(offered, i, hysgen_image_word(bytes, IMAGE_HEADER + i));
    }
    if ((offered->half < 0.0f) || (offered->half > IMAGE_LOOP * MODEL_LOOP_HALF)) {
        return IMAGE_RISKY;
    }
    model_init(&bench->model, MODEL_Y_MIN_UM, MODEL_U_MIN_V);
    hysgen_bank_drive(&bench->model, offered);
    model_learn_init(&bench->learner, &bench->model);
    bench->learner.age = MODEL_COMMIT_MATURE;
    for (uint32_t i = 0u; (i < IMAGE_MOST_CALLS) & (answer == MODEL_BUSY); ++i) {
        answer = (uint32_t)model_commit(&bench->model, &bench->learner);
    }
    if (answer != MODEL_COMMITTED) {
        return IMAGE_UNCERTIFIED + answer;
    }
    hysgen_bank_take(bank, &bench->model);
    return IMAGE_GOOD;
}
