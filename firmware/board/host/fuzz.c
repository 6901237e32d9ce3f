/* fuzz.c: cases of random settings, faults, references, requests, bytes on the line and preemption; invariants at every sample.
 *
 * The stage is the model itself, so whatever is wrong is the firmware's. One case is one seed: it repeats to the bit. */

#include <string.h>

#include "firmware.h"
#include "fuzz.h"
#include "number.h"

#define FUZZ_SAMPLES 3000u

typedef struct {
    uint64_t random;
    model_t stage;
    board_t board;
    firmware_t firmware;
    settings_t settings;
    image_owner_t owner;
    float reference_um[1];
    uint8_t line[64];
    uint32_t apart;        /* samples in a row in which model and stage are apart and no fault is told */
    uint32_t interrupts;
} fuzz_t;

static uint32_t fuzz_word(fuzz_t *self)
{
    self->random ^= self->random << 13;
    self->random ^= self->random >> 7;
    self->random ^= self->random << 17;
    return (uint32_t)(self->random >> 16);
}

static uint32_t fuzz_below(fuzz_t *self, uint32_t limit)
{
    return fuzz_word(self) % limit;
}

/* Uniform in low .. high. */
static float fuzz_float(fuzz_t *self, float low, float high)
{
    return low + (high - low) * (float)(fuzz_word(self) & 0xFFFFFFu) / 16777215.0f;
}

/* A number of any kind: bits, infinities, NaN, denormals, or one near the stage's range. */
static float fuzz_any(fuzz_t *self)
{
    static const uint32_t special[] = { 0x7FC00000u, 0xFF800000u, 0x7F800000u, 0x00000001u, 0x80000000u, 0x7F7FFFFFu, 0xFF7FFFFFu };
    const uint32_t kind = fuzz_below(self, 3u);

    if (kind == 0u) {
        return number_of(fuzz_word(self));
    }
    if (kind == 1u) {
        return number_of(special[fuzz_below(self, 7u)]);
    }
    return fuzz_float(self, MODEL_Y_MIN_UM - 2.0f, MODEL_Y_MAX_UM + 2.0f);
}

/* As the interrupt: the stage holds u_V for a period. */
static double fuzz_stage(void *plant, double u_V)
{
    fuzz_t *self = plant;

    return (double)model_simulate(&self->stage, (float)u_V) + 1.0e-4 * (double)fuzz_float(self, -1.0f, 1.0f);
}

static void fuzz_preempt(void *with)
{
    fuzz_t *self = with;

    if (fuzz_below(self, 2u) != 0u) {
        self->firmware.controller.request = fuzz_below(self, 5u);
    }
    self->board.sample = 0u;
    firmware_interrupt(&self->firmware, &self->board);
    self->interrupts += 1u;
}

/* Settings with short ways; one in four has fields of any kind. */
static void fuzz_settings(fuzz_t *self)
{
    settings_t *s = &self->settings;
    float *numbers = &s->off_V;

    s->options = fuzz_below(self, 8u);
    s->off_V = fuzz_float(self, -2.0f, 2.0f);
    s->low_V = fuzz_float(self, -20.0f, s->off_V);
    s->high_V = fuzz_float(self, 50.0f, 120.0f);
    s->step_V = fuzz_float(self, 0.02f, 3.0f);
    s->ramp_V = s->step_V * fuzz_float(self, 0.3f, 1.0f);
    s->fall_V = s->step_V * fuzz_float(self, 0.3f, 1.0f);
    s->loop_low_V = fuzz_float(self, 20.0f, 30.0f);
    s->loop_high_V = fuzz_float(self, 40.0f, 50.0f);
    s->loop_middle_V = fuzz_float(self, 30.0f, 40.0f);
    s->hold_samples = 1u + fuzz_below(self, 200u);
    s->stroke_um = fuzz_float(self, 0.3f, 2.0f);
    s->offset_smoothing = fuzz_float(self, 0.0f, 1.0f);
    s->offset_um = fuzz_float(self, 0.3f, 2.0f);
    s->approach_um = fuzz_float(self, 0.001f, 0.1f);
    s->state_samples = 1000u + fuzz_below(self, 100000u);
    s->reference_step_um = fuzz_float(self, 0.0001f, 1.0f);
    s->low_um = -3.2f;
    s->high_um = 13.0f;
    s->stuck_V = fuzz_float(self, 0.1f, 2.0f);
    s->stuck_samples = 1u + fuzz_below(self, 200u);
    s->follow_um = fuzz_float(self, 0.05f, 1.0f);
    s->follow_samples = 1u + fuzz_below(self, 50u);
    s->bad_samples = 1u + fuzz_below(self, 20u);
    s->period_cycles = 7500u;
    s->budget_cycles = 1u + fuzz_below(self, 7500u);
    s->trim_integral = fuzz_float(self, 0.0f, 0.02f);
    s->trim_proportion = fuzz_float(self, 0.0f, 0.3f);
    s->trim_smoothing = fuzz_float(self, 0.0f, 1.0f);
    s->trim_limit_um = fuzz_float(self, 0.0f, 0.5f);
    s->commit_pause = fuzz_below(self, 500u);
    if (fuzz_below(self, 4u) == 0u) {
        numbers[fuzz_below(self, 9u)] = (fuzz_below(self, 2u) != 0u) ? fuzz_any(self) : fuzz_float(self, -150.0f, 150.0f);
    }
}

/* Something from outside: a fault, its end, a request, bytes on the line, another kind of reference. */
static void fuzz_event(fuzz_t *self, uint32_t *kind)
{
    board_t *board = &self->board;

    switch (fuzz_below(self, 6u)) {
    case 0u:
        board->fault = fuzz_below(self, 9u);
        board->fault_value = fuzz_any(self);
        board->fault_value = (board->fault == HOST_FAULT_LATE) || (board->fault == HOST_FAULT_LOST)
            ? fuzz_float(self, 0.0f, 30000.0f) : board->fault_value;
        board->fault_from = 0u;
        board->fault_until = 0xFFFFFFFFu;
        board->fault_period = (fuzz_below(self, 2u) != 0u) ? 1u + fuzz_below(self, 20u) : 0u;
        board->fault_length = fuzz_below(self, 20u);
        break;
    case 1u:
        board->fault = HOST_FAULT_NONE;
        break;
    case 2u:
        self->firmware.controller.request = fuzz_below(self, 5u);
        break;
    case 3u:
        for (uint32_t i = 0u; i < sizeof self->line; ++i) {
            self->line[i] = (uint8_t)fuzz_word(self);
        }
        board->incoming = self->line;
        board->incoming_count = 1u + fuzz_below(self, sizeof self->line);
        board->outgoing_count = 0u;
        break;
    default:
        *kind = fuzz_below(self, 4u);
        break;
    }
}

static float fuzz_reference(fuzz_t *self, uint32_t kind, uint32_t k)
{
    const float middle = 0.5f * (MODEL_Y_MIN_UM + MODEL_Y_MAX_UM);

    switch (kind) {
    case 0u:
        return middle;
    case 1u:
        return middle + 0.004f * ((float)(int32_t)((k % 600u < 300u) ? k % 300u : 300u - k % 300u) - 150.0f);
    case 2u:
        return ((k / 300u) % 2u != 0u) ? MODEL_Y_MIN_UM : MODEL_Y_MAX_UM;
    default:
        return fuzz_any(self);
    }
}

/* 1 if the numbers of both banks are equal. */
static uint32_t fuzz_same_bank(const model_bank_t *a, const model_bank_t *b)
{
    return (uint32_t)(memcmp(a, b, sizeof *a) == 0);
}

/* The invariants of one sample; returns the FUZZ_ bit of the first that is broken. */
static uint32_t fuzz_broken(fuzz_t *self, float before_V, float stage_um, float model_um)
{
    const controller_t *controller = &self->firmware.controller;
    const settings_t *s = &self->settings;
    const float u_V = self->board.output_V;
    /* Between two numbers below 128 V a sum is rounded by at most 2^-18 V. */
    /* The trim moves the model away from the stage by its correction, which the watchdog takes into account. */
    const float far_um = s->follow_um + (((s->options & SETTINGS_TRIM) != 0u) ? s->trim_limit_um : 0.0f);
    const uint32_t rate = (uint32_t)(number_size(u_V - before_V) > s->step_V + 4.0e-6f);

    if ((number_finite(u_V) == 0u) || (u_V < s->low_V) || (u_V > s->high_V)) {
        return FUZZ_RANGE;
    }
    if (rate != 0u) {
        return FUZZ_RATE;
    }
    if ((controller->state == CONTROLLER_TRACK) && ((controller->status & STATUS_FAULTS) == 0u)
        && ((s->options & SETTINGS_LEARN) == 0u) && (number_size(stage_um - model_um) > far_um)) {
        self->apart += 1u;
    } else {
        self->apart = 0u;
    }
    /* The leaky count reaches its limit after 9 times as many samples at the latest. */
    return (self->apart > 9u * s->follow_samples + 9u) ? FUZZ_APART : 0u;
}

uint32_t fuzz_case(uint64_t seed, uint32_t *tracked)
{
    static fuzz_t self;
    model_bank_t built_in;
    uint32_t kind = 0u;
    uint32_t broken = 0u;
    uint32_t refused;

    memset(&self, 0, sizeof self);
    self.random = seed * 0x9E3779B97F4A7C15u + 0x1234567u;
    (void)fuzz_word(&self);
    fuzz_settings(&self);
    memset(&self.firmware, 0xA5, sizeof self.firmware);
    memset(self.board.store, 0xFF, sizeof self.board.store);
    self.board.step = fuzz_stage;
    self.board.plant = &self;
    self.board.preempt = fuzz_preempt;
    self.board.preempt_with = &self;
    self.board.bytes_to_cut = HOST_NO_CUT;
    self.board.reference_um = self.reference_um;
    model_init(&self.stage, MODEL_Y_MIN_UM, MODEL_U_MIN_V);
    self.board.reading_um = self.stage.y_um;
    firmware_boot(&self.firmware, &self.board, &self.settings, &self.owner);
    built_in = self.firmware.controller.bank;
    refused = (uint32_t)(self.firmware.settings_wrong != 0);
    self.board.output_V = self.firmware.controller.output_V;
    self.firmware.controller.request = CONTROLLER_START;
    for (uint32_t k = 0u; (k < FUZZ_SAMPLES) && (broken == 0u); ++k) {
        const float before_V = self.board.output_V;
        float stage_um;

        if (fuzz_below(&self, 100u) == 0u) {
            fuzz_event(&self, &kind);
        }
        self.reference_um[0] = fuzz_reference(&self, kind, k);
        self.board.sample = 0u;
        firmware_interrupt(&self.firmware, &self.board);
        stage_um = self.stage.y_um;
        if (refused != 0u) {
            broken = (uint32_t)(self.board.output_V != before_V) * FUZZ_REFUSED;
        } else {
            broken = fuzz_broken(&self, before_V, stage_um, self.firmware.controller.model.y_um);
        }
        firmware_idle(&self.firmware, &self.board);
        *tracked += (uint32_t)(self.firmware.controller.state == CONTROLLER_TRACK);
    }
    /* Nothing but a certified image or a commit changes the parameters that a start begins with: here none is sent. */
    if ((broken == 0u) && ((self.settings.options & SETTINGS_KEEP) == 0u)
        && (fuzz_same_bank(&self.firmware.controller.bank, &built_in) == 0u)) {
        broken = FUZZ_PARAMETERS;
    }
    return broken;
}

uint64_t fuzz_cases(uint64_t first, uint64_t count, uint32_t broken[6], uint32_t *tracked)
{
    uint64_t worst = UINT64_MAX;

    for (uint64_t seed = first; seed < first + count; ++seed) {
        const uint32_t found = fuzz_case(seed, tracked);

        for (uint32_t i = 0u; i < 6u; ++i) {
            broken[i] += (found >> i) & 1u;
        }
        worst = ((found != 0u) && (worst == UINT64_MAX)) ? seed : worst;
    }
    return worst;
}
