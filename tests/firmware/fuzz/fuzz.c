/* fuzz.c: cases of random settings, faults, references, requests, images, resets and interrupts inside the idle loop; invariants at
 * every interrupt.
 *
 * The stage is the model itself, so every error is the firmware's. One case is one seed: it repeats to the bit. */

#include "case.h"

#include <string.h>

#include "bytes.h"

/* Between two numbers below 128 V a sum is rounded by at most 2^-18 V. */
#define ROUNDING_V 4.0e-6f
#define NOISE_UM    1.0e-3f
#define CALM        16u
#define SLOW        256u
#define SLOW_DRIFT  4.0e-6f  /* a half in 125 000 samples, 2.5 s */

uint8_t fuzz_image[FUZZ_IMAGES][IMAGE_BYTES];
bank_t fuzz_bank[FUZZ_IMAGES];

static uint8_t *fuzz_reached;   /* FUZZ_FEATURES flags of the present case */

void fuzz_give(const uint8_t *images)
{
    memcpy(fuzz_image, images, sizeof fuzz_image);
    for (uint32_t i = 0u; i < FUZZ_IMAGES; ++i) {
        const uint8_t *number = &fuzz_image[i][4u * IMAGE_HEADER];

        memset(&fuzz_bank[i], 0, sizeof fuzz_bank[i]);
        for (uint32_t j = 0u; j < BANK_WORDS; ++j) {
            hysgen_bank_put(&fuzz_bank[i], j, bytes_word(&number[4u * j]));
        }
    }
}

uint32_t fuzz_image_bytes(void)
{
    return IMAGE_BYTES;
}

/* The stage holds u_V for a period; returns its displacement through a noisy sensor, which may drift by a half. */
static double stage_step(void *plant, double u_V)
{
    fuzz_t *self = plant;
    const float y_um = model_simulate(&self->stage, (float)u_V);
    const float share = number_limited(self->drift * (float)self->drifted, -0.5f, 0.5f);

    self->wrong_um = (self->drifts_offset != 0u) ? share : share * y_um;
    return (double)y_um + (double)self->wrong_um + 1.0e-4 * (double)fuzz_float(self, -1.0f, 1.0f);
}

/* Parameters of the next start: number of the image that holds them, FUZZ_IMAGES for the built-in ones, FUZZ_IMAGES + 1 for others. */
static uint32_t parameters_of(const fuzz_t *self, const bank_t *bank)
{
    uint32_t found = FUZZ_IMAGES + 1u;

    if (memcmp(bank, &self->built_in, sizeof *bank) == 0) {
        found = FUZZ_IMAGES;
    }
    for (uint32_t i = 0u; i < FUZZ_IMAGES; ++i) {
        found = (memcmp(bank, &fuzz_bank[i], sizeof *bank) == 0) ? i : found;
    }
    return found;
}

/* Invariants of the output: inside its range, below its rate; at rest under settings that were refused. */
static uint32_t broken_output(const fuzz_t *self, float before_V)
{
    const settings_t *s = &self->settings;
    const float u_V = self->board.output_V;
    uint32_t broken = 0u;

    if (self->refused != 0u) {
        broken = (u_V != BOARD_SAFE_V) ? FUZZ_REFUSED : 0u;
    } else if ((number_finite(u_V) == 0u) || (u_V < s->low_V) || (u_V > s->high_V)) {
        broken = FUZZ_RANGE;
    } else if (number_size(u_V - before_V) > s->step_V + ROUNDING_V) {
        broken = FUZZ_RATE;
    } else {
        /* Good. */
    }
    return broken;
}

/* 1 if y_um is a number inside the board's range. */
static uint32_t believable(const fuzz_t *self, float y_um)
{
    return number_finite(y_um) & (uint32_t)(y_um >= BOARD_LOW_UM) & (uint32_t)(y_um <= BOARD_HIGH_UM);
}

/* Notes what the sensor did at this interrupt, whose reading came under before_V. */
static void watch_sensor(fuzz_t *self, float y_um, float before_V)
{
    const uint32_t fault = self->board.fault;
    const uint32_t off = (uint32_t)(self->firmware.controller.state == CONTROLLER_OFF)
        | (uint32_t)(self->firmware.controller.state == CONTROLLER_TRIPPED);

    self->lied = (off != 0u) ? 0u : self->lied;
    self->lied |= (uint32_t)(fault == HOST_FAULT_STUCK)
        | ((uint32_t)(fault == HOST_FAULT_READING) & believable(self, self->board.fault_value));
    if ((believable(self, y_um) != 0u) && (number_bits(y_um) != self->same_bits)) {
        self->taken_V = before_V;
    }
    if ((off != 0u) || ((believable(self, y_um) != 0u) && (number_bits(y_um) != self->same_bits))) {
        self->same_bits = number_bits(y_um);
        self->same_V = before_V;
        self->same = 0u;
    } else {
        self->same += believable(self, y_um);
    }
}

/* A reading that repeats itself is a fault once the input has moved by WATCHDOG_STUCK_V since it was taken, a jump at its second sample, or since
 * a CLEAR at rest. It may have been taken on the way down before: the fuzzer found one. */
static uint32_t broken_stuck(const fuzz_t *self, float before_V)
{
    const controller_t *controller = &self->firmware.controller;
    const settings_t *s = &self->settings;
    const float least_V = WATCHDOG_STUCK_V + s->step_V + ROUNDING_V;
    const uint32_t must = (uint32_t)(self->same > WATCHDOG_STUCK + 1u) & (uint32_t)(number_size(before_V - self->same_V) > least_V)
        & (uint32_t)(number_size(before_V - self->taken_V) > least_V);
    const uint32_t told = (uint32_t)((controller->status & STATUS_FAULTS) != 0u);

    return ((must != 0u) && (told == 0u)) ? FUZZ_STUCK : 0u;
}

/* Invariants of TRACK without a fault. Offset and correction are inside their limits. The stage is within follow_um of the displacement
 * that the firmware expects of it, or outside no longer than WATCHDOG_ASTRAY; not judged while readings are none.
 *
 * The expected displacement is the model's plus the offset that HOLD found, without the feedback's correction: an amplifier that fails
 * before HOLD may leave an offset of up to offset_um between model and stage (seed 5590 of the fuzzer without this term). A sensor
 * that repeats or invents believable readings is another matter: broken_stuck. */
static uint32_t broken_tracking(fuzz_t *self)
{
    const controller_t *controller = &self->firmware.controller;
    const settings_t *s = &self->settings;
    const float most_um = ((s->options & SETTINGS_LOOP) != 0u) ? MODEL_LOOP_LIMIT_UM : 0.0f;
    const uint32_t tracks = (uint32_t)((controller->state == CONTROLLER_TRACK) && ((controller->status & STATUS_FAULTS) == 0u));
    const uint32_t judged = tracks & (uint32_t)(self->lied == 0u) & (uint32_t)(self->board.fault != HOST_FAULT_READING);
    uint32_t broken = 0u;
    uint32_t far;

    self->tracked += judged;
    far = (uint32_t)(number_size(self->stage.y_um - controller->expected_um[controller->oldest]) > controller->watchdog.follow_um + NOISE_UM);
    self->apart = ((judged & far) != 0u) ? self->apart + 1u : 0u;
    if ((tracks != 0u) && ((number_size(controller->offset_um) > s->offset_um)
                           || (number_size(controller->model.loop.correction_um) > most_um))) {
        broken = FUZZ_CORRECTION;
    } else if (self->apart > WATCHDOG_ASTRAY + 9u) {
        broken = FUZZ_APART;
    } else {
        /* Good. */
    }
    return broken;
}

/* A sensor that drifts from the first sample of TRACK on is told once its reading has been wrong by more than follow_um for WATCHDOG_ASTRAY,
 * whatever feedback and learning make of it: the stage is the model of START. wrong_um: of the reading of this interrupt. */
static uint32_t broken_drift(fuzz_t *self, float wrong_um)
{
    const controller_t *controller = &self->firmware.controller;
    const uint32_t tracks = (uint32_t)((controller->state == CONTROLLER_TRACK) && ((controller->status & STATUS_FAULTS) == 0u));
    const uint32_t far = (uint32_t)(number_size(wrong_um - controller->offset_um) > controller->watchdog.follow_um + NOISE_UM);

    if ((hysgen_controller_drives(controller) == 0u) || (controller->state == CONTROLLER_POWER)) {
        self->drifted = 0u;
        self->spoiled = (uint32_t)(parameters_of(self, &controller->bank) != FUZZ_IMAGES);
    }
    self->spoiled |= (uint32_t)(self->board.fault != HOST_FAULT_NONE);
    if ((self->drift != 0.0f) && ((tracks | self->drifted) != 0u)) {
        self->drifted += 1u;
        self->lied = 1u;
    }
    self->untold = ((tracks & far) != 0u) && (self->spoiled == 0u) ? self->untold + 1u : 0u;
    return (self->untold > WATCHDOG_ASTRAY + 2u) ? FUZZ_DRIFT : 0u;
}

/* Features of this interrupt: the state's change and each bit of the status word in this state. */
static void reach(fuzz_t *self)
{
    const uint32_t state = (uint32_t)self->firmware.controller.state;
    const uint32_t status = hysgen_firmware_status(&self->firmware);

    fuzz_reached[16u * self->before + state] = 1u;
    for (uint32_t rest = status; rest != 0u; rest &= rest - 1u) {
        fuzz_reached[256u + 32u * state + (uint32_t)__builtin_ctz(rest)] = 1u;
    }
    fuzz_reached[1024u + (self->firmware.image_answer & 31u)] = 1u;
    fuzz_reached[1056u + (self->firmware.commit_answer & 31u)] = 1u;
    fuzz_reached[1088u + 16u * (self->settings.options & 7u) + state] = 1u;
    self->before = state;
}

/* The amplifier is on only behind a START out of OFF, which a reset under power forbids until CLEAR. */
static uint32_t broken_amplifier(fuzz_t *self, uint32_t asked)
{
    const uint32_t off = (uint32_t)(self->before == (uint32_t)CONTROLLER_OFF);

    self->locked = (self->clears != self->firmware.controller.clears) ? 0u : self->locked;
    self->armed = (off != 0u) ? (uint32_t)((asked == CONTROLLER_START) | (asked == CONTROLLER_RECORD)) : self->armed;
    return ((self->board.enabled != 0u) && ((self->armed == 0u) || (self->locked != 0u))) ? FUZZ_ARMED : 0u;
}

static void interrupt(fuzz_t *self)
{
    const uint32_t asked = self->firmware.controller.request;
    const float before_V = self->board.output_V;
    const float y_um = self->board.reading_um;
    const float wrong_um = self->wrong_um;
    const controller_t *controller = &self->firmware.controller;

    self->reference_um[0] = fuzz_reference(self);
    self->board.sample = 0u;
    hysgen_firmware_interrupt(&self->firmware, &self->board);
    self->k += 1u;
    self->broken |= (((self->status & ~controller->status) != 0u) && (self->clears == controller->clears)) ? FUZZ_STATUS : 0u;
    self->broken |= broken_amplifier(self, asked);
    self->status = controller->status;
    self->clears = controller->clears;
    watch_sensor(self, y_um, before_V);
    self->broken |= broken_output(self, before_V);
    if (self->refused == 0u) {
        self->broken |= broken_stuck(self, before_V);
        self->broken |= broken_tracking(self);
        self->broken |= broken_drift(self, wrong_um);
    }
    reach(self);
}

/* The processor starts, with what the store holds. */
static void boot(fuzz_t *self)
{
    memset(&self->firmware, 0xA5, sizeof self->firmware);
    self->board.bytes_to_cut = HOST_NO_CUT;
    self->board.incoming_count = 0u;
    hysgen_firmware_boot(&self->firmware, &self->board, &self->settings, &self->owner);
    self->refused = (uint32_t)(self->firmware.settings_wrong != 0);
    self->board.output_V = self->firmware.controller.output_V;
    self->apart = 0u;
    self->untold = 0u;
    self->drifted = 0u;
    self->lied = 0u;
    self->same_bits = number_bits(self->board.reading_um);
    self->same_V = self->board.output_V;
    self->taken_V = self->board.output_V;
    self->same = 0u;
    self->before = (uint32_t)self->firmware.controller.state;
    self->status = self->firmware.controller.status;
    self->clears = self->firmware.controller.clears;
    self->counter = self->firmware.store.counter;
}

/* After the idle loop: an image that the store has acknowledged is what the next start begins with; parameters have a known origin. */
static void look_at_parameters(fuzz_t *self)
{
    const uint32_t now = parameters_of(self, &self->firmware.controller.bank);
    const uint32_t kept = self->settings.options & SETTINGS_KEEP;
    const uint32_t counter = self->firmware.store.counter;

    if (counter != self->counter) {
        self->counter = counter;
        self->broken |= (now + 1u != counter) ? FUZZ_PARAMETERS : 0u;
    }
    if ((now < FUZZ_GOOD) && (now != self->stored) && (self->firmware.image_answer == IMAGE_GOOD)) {
        self->stored = now;
        self->sent = 0u;
    }
    if (((now >= FUZZ_GOOD) && (now < FUZZ_IMAGES)) || ((now > FUZZ_IMAGES) && (kept == 0u))) {
        self->broken |= FUZZ_PARAMETERS;
    }
}

/* Three of four starts track; the others rest, so that images are taken. */
static void ask(fuzz_t *self)
{
    self->firmware.controller.request = (fuzz_below(self, 4u) != 0u) ? CONTROLLER_START : CONTROLLER_NO_REQUEST;
}

/* Power off or an exception, then a start. The store keeps the image that it acknowledged last, or one that was sent since. */
static void reset(fuzz_t *self)
{
    uint32_t found;

    self->board.restarted = fuzz_below(self, 2u);
    self->locked = self->board.restarted;
    self->armed = 0u;
    if (self->board.restarted != 0u) {
        const float held_V = self->board.output_V;

        hysgen_firmware_panic(&self->firmware, &self->board);
        self->broken |= ((self->board.output_V != held_V) || (self->board.enabled != 0u)) ? FUZZ_PANIC : 0u;
    }
    self->board.enabled = 0u;  /* the pin, by its pull-down */
    boot(self);
    found = parameters_of(self, &self->firmware.controller.bank);
    if ((found != self->stored) && ((found >= FUZZ_GOOD) || (((self->sent >> found) & 1u) == 0u))) {
        self->broken |= FUZZ_STORE;
    }
    self->stored = found;
    self->sent = 0u;
    if (self->locked != 0u) {
        self->firmware.controller.request = CONTROLLER_START;
        interrupt(self);
        interrupt(self);
        self->firmware.controller.request = CONTROLLER_CLEAR;
        interrupt(self);
    }
    ask(self);
}

uint32_t fuzz_case(uint64_t seed, uint32_t interrupts, uint8_t *features, uint64_t *tracked)
{
    static fuzz_t self;
    uint32_t slow;

    memset(&self, 0, sizeof self);
    fuzz_reached = features;
    self.random = seed * 0x9E3779B97F4A7C15u + 0x1234567u;
    (void)fuzz_word(&self);
    /* Every sixteenth sensor drifts, by a half in 500 to 8000 samples either way, in a long case of few events; every 4096th so slowly, in a
     * case of few more, that feedback and learning follow it from commit to commit. */
    slow = (uint32_t)((seed & 4095u) == 4095u);
    self.drift = ((seed & 15u) == 15u) ? 0.001f / (float)(1u + ((seed >> 6) & 15u)) : 0.0f;
    self.drift = (slow != 0u) ? SLOW_DRIFT : self.drift;
    self.drift = ((seed & 16u) != (seed >> 12 & 16u)) ? self.drift : -self.drift;
    self.drifts_offset = (uint32_t)((seed >> 5) ^ (seed >> 13)) & 1u;
    self.calm = (slow != 0u) ? SLOW : CALM;
    self.calm = (self.drift != 0.0f) ? self.calm : 1u;
    fuzz_settings(&self);
    if (slow != 0u) {
        self.settings.options |= SETTINGS_LOOP | SETTINGS_LEARN;
        self.kind = 1u;
    }
    memset(self.board.store, 0xFF, sizeof self.board.store);
    for (uint32_t i = 0u; i < 16u; ++i) {
        self.owner.key[i / 4u] |= (i + 1u) << (8u * (i % 4u));  /* of fixtures/firmware_bench.py */
    }
    self.board.step = stage_step;
    self.board.plant = &self;
    self.board.reference_um = self.reference_um;
    model_init(&self.stage, MODEL_Y_MIN_UM, MODEL_U_MIN_V);
    self.board.reading_um = self.stage.y_um;
    boot(&self);
    self.built_in = self.firmware.controller.bank;
    self.stored = FUZZ_IMAGES;
    ask(&self);
    while ((self.k < self.calm * interrupts) && (self.broken == 0u)) {
        if (fuzz_below(&self, 60u * self.calm) == 0u) {
            fuzz_event(&self);
        }
        interrupt(&self);
        fuzz_preempted_idle(&self, interrupt);
        look_at_parameters(&self);
        if ((self.board.bytes_to_cut == 0u) || (fuzz_below(&self, (slow != 0u) ? 1000u * SLOW : 1000u) == 0u)) {
            reset(&self);
        }
    }
    *tracked += self.tracked;
    return self.broken;
}

uint64_t fuzz_cases(uint64_t first, uint64_t count, uint32_t interrupts, uint32_t broken[FUZZ_INVARIANTS], uint64_t *tracked,
                    uint8_t *features, uint64_t *finders, uint32_t room, uint32_t *found)
{
    static uint8_t reached[FUZZ_FEATURES];
    uint64_t worst = UINT64_MAX;

    for (uint64_t seed = first; seed < first + count; ++seed) {
        uint32_t broke;
        uint32_t new_ones = 0u;

        memset(reached, 0, sizeof reached);
        broke = fuzz_case(seed, interrupts, reached, tracked);
        for (uint32_t i = 0u; i < FUZZ_FEATURES; ++i) {
            new_ones |= (uint32_t)(reached[i] > features[i]);
            features[i] |= reached[i];
        }
        if ((new_ones != 0u) && (*found < room)) {
            finders[*found] = seed;
            *found += 1u;
        }
        for (uint32_t i = 0u; i < FUZZ_INVARIANTS; ++i) {
            broken[i] += (broke >> i) & 1u;
        }
        worst = ((broke != 0u) && (worst == UINT64_MAX)) ? seed : worst;
    }
    return worst;
}
