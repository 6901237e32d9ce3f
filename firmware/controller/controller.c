#include "controller.h"

#include "board.h"
#include "number.h"

/* A change of the voltage from this part of the largest one on counts as the largest one: rounding loses the rest. */
#define CONTROLLER_WHOLE_STEP 0.99f

/* Change of the reference per volt of the ramp while it is approached: the mean slope of the model. */
#define CONTROLLER_UM_PER_V ((MODEL_Y_MAX_UM - MODEL_Y_MIN_UM) / (MODEL_U_MAX_V - MODEL_U_MIN_V))

/* LOOP: largest difference between the strokes of stage and model, as a share of the model's stroke. */
#define CONTROLLER_STROKE_SHARE 0.45f

/* One step of at most `step` from `from` towards `target`; within reach it is `target` itself, without rounding. */
static float controller_towards(float from, float target, float step)
{
    const float way = target - from;

    if (number_size(way) <= step) {
        return target;
    }
    return from + ((way < 0.0f) ? -step : step);
}

/* [S1] */
uint32_t hysgen_controller_drives(const controller_t *self)
{
    return (uint32_t)((self->state != CONTROLLER_OFF) && (self->state != CONTROLLER_TRIPPED));
}

static void controller_restart_trace(controller_t *self)
{
    self->trace.count = 0u;
    self->trace.left = TRACE_BEHIND;
}

/* The parameters that drive the model are those of the next start. */
static void controller_take_bank(controller_t *self)
{
    hysgen_bank_take(&self->bank, &self->model);
    self->bank_check = hysgen_bank_check(&self->bank);
}

void hysgen_controller_init(controller_t *self, const settings_t *settings, float rest_V)
{
    self->settings = settings;
    self->state = CONTROLLER_OFF;
    self->request = CONTROLLER_NO_REQUEST;
    self->clears = 0u;
    self->committing = 0u;
    self->installing = 0u;
    self->damaged = 0u;
    self->plays = 0u;
    self->learns = 0u;
    self->start_um = MODEL_Y_MIN_UM;
    self->begun = 0u;
    self->status = 0u;
    self->first = 0u;
    self->powered = 0u;
    self->upward = 1u;
    self->waited = 0u;
    self->held = 0u;
    self->top_um = 0.0f;
    self->top_model_um = 0.0f;
    self->above_um = 0.0f;
    self->below_um = 0.0f;
    self->offset_um = 0.0f;
    self->hold_mean = 1u;
    self->hold_share = 1.0f;
    while (self->hold_mean <= (settings->hold_samples >> 1)) {
        self->hold_mean += self->hold_mean;
        self->hold_share *= 0.5f;
    }
    self->held_um = 0.0f;
    self->output_V = rest_V;
    self->reference_um = MODEL_Y_MIN_UM;
    self->wanted_um = MODEL_Y_MIN_UM;
    for (uint32_t i = 0u; i < CONTROLLER_LINE; ++i) {
        self->asked_um[i] = MODEL_Y_MIN_UM;
        self->expected_um[i] = MODEL_Y_MIN_UM;
    }
    self->oldest = 0u;
    self->samples = 0u;
    hysgen_watchdog_init(&self->watchdog, settings);
    controller_restart_trace(self);
    model_init(&self->model, MODEL_Y_MIN_UM, MODEL_U_MIN_V);
    model_learn_init(&self->learner, &self->model);
    controller_take_bank(self);
}

uint32_t hysgen_controller_install(controller_t *self, const bank_t *bank, uint32_t check)
{
    const controller_state_t state = self->state;

    if ((state != CONTROLLER_OFF) && (state != CONTROLLER_TRIP) && (state != CONTROLLER_TRIPPED)) {
        return 0u;
    }
    hysgen_bank_copy(&self->bank, bank);
    self->bank_check = check;
    return 1u;
}

/* The model starts where the stage is, under the voltage that it has, with the parameters to begin with. Its inverse keeps to the
 * limits of the output, so that model and stage get the same voltage. */
static void controller_begin(controller_t *self)
{
    model_init(&self->model, self->watchdog.reading_um, self->output_V);
    model_limits(&self->model, self->settings->low_V, self->settings->high_V, self->settings->step_V);
    hysgen_bank_drive(&self->model, &self->bank);
    model_init(&self->witness, self->watchdog.reading_um, self->output_V);
    hysgen_bank_drive(&self->witness, &self->bank);
    self->upward = 1u;
    self->begun = 1u;
    self->held = 0u;
    self->held_um = 0.0f;
    self->offset_um = 0.0f;
    self->state = CONTROLLER_LOOP;
}

static void controller_take_request(controller_t *self)
{
    const uint32_t request = self->request;
    uint32_t plays;

    if (((request == CONTROLLER_START) || (request == CONTROLLER_RECORD)) && (self->installing != 0u)) {
        return;
    }
    self->request = CONTROLLER_NO_REQUEST;
    /* What was played, in part too, is a record and no table any more. */
    plays = (uint32_t)(request == CONTROLLER_RECORD) & (uint32_t)(self->play.done == 0u) & (uint32_t)(self->play.count != 0u);
    if (((request == CONTROLLER_START) || (plays != 0u)) && (self->state == CONTROLLER_OFF)) {
        self->plays = plays;
        self->begun = 0u;
        self->powered = 0u;
        self->state = CONTROLLER_POWER;
    }
    if ((request == CONTROLLER_STOP) && (hysgen_controller_drives(self) != 0u) && (self->state != CONTROLLER_TRIP)) {
        self->state = CONTROLLER_FALL;
    }
    if (request == CONTROLLER_CLEAR) {
        /* A processor that fails its self-test stays where it is, and so do impossible settings. The watchdog restarts its counts
         * only where the output rests: a sensor that repeats its reading must not pass because of a CLEAR on the way. */
        self->status &= STATUS_LASTING;
        self->model.status = 0u;
        self->clears += 1u;
        if (hysgen_controller_drives(self) == 0u) {
            self->first = 0u;
            controller_restart_trace(self);
            hysgen_watchdog_init(&self->watchdog, self->settings);
        }
        if ((self->state == CONTROLLER_TRIPPED) && (self->status == 0u)) {
            self->state = CONTROLLER_OFF;
        }
    }
}

/* Reference for the inverse: finite (else the last one), inside the range, changed by at most `step`. reached: 1 if by all that is left. */
static float controller_reference(controller_t *self, float reference_um, float step, uint32_t *reached)
{
    float within;
    float next_um;

    if (number_finite(reference_um) == 0u) {
        self->status |= STATUS_REFERENCE_INVALID;
    } else {
        self->wanted_um = reference_um;
    }
    within = number_limited(self->wanted_um, MODEL_Y_MIN_UM + self->offset_um, MODEL_Y_MAX_UM + self->offset_um);
    if (within != self->wanted_um) {
        self->status |= STATUS_REFERENCE_LIMITED;
    }
    next_um = controller_towards(self->reference_um, within, step);
    *reached = (uint32_t)(next_um == within);
    return next_um;
}

/* Status of a voltage that the inverse found inside the limits: it rests at one of them, or moves as fast as it may. */
static uint32_t controller_limits_reached(const controller_t *self, float u_V)
{
    const settings_t *settings = self->settings;
    const uint32_t ends = (uint32_t)(u_V <= settings->low_V) | (uint32_t)(u_V >= settings->high_V);
    const uint32_t fast = (uint32_t)(number_size(u_V - self->output_V) >= CONTROLLER_WHOLE_STEP * settings->step_V);

    return (ends * STATUS_OUTPUT_LIMITED) | (fast * STATUS_OUTPUT_SLEWED);
}

/* Feed-forward through the inverse, Eq. (11), with feedback, of a model that has one, and learning as the settings have them. What the feedback
 * adds to the reference passes through the model, whose memory sees the voltage that the stage sees. The reading is held against what the
 * parameters of START say of the voltage that was put out: neither feedback nor learning can follow a sensor that fails. */
static float controller_follow(controller_t *self, float reference_um)
{
    const settings_t *settings = self->settings;
    const uint32_t now = self->oldest;
    const uint32_t learns = (uint32_t)((settings->options & SETTINGS_LEARN) != 0u);
    float correction = 0.0f;
    uint32_t status;
    float u_V;

    status = hysgen_watchdog_follow(
        &self->watchdog, (learns != 0u) ? self->start_um + self->offset_um : self->expected_um[now]);
#ifdef MODEL_LOOP_LIMIT_UM
    if ((settings->options & SETTINGS_LOOP) != 0u) {
        correction = model_correct(&self->model, self->asked_um[now] - self->watchdog.reading_um);
        status |= (number_size(correction) >= MODEL_LOOP_LIMIT_UM) ? STATUS_LOOP_LIMITED : 0u;
    }
#endif
    u_V = model_inverse(&self->model, self->model.y_um, reference_um - self->offset_um + correction);
    status |= (self->model.status != 0u) ? STATUS_MODEL : 0u;
    self->status |= status | controller_limits_reached(self, u_V);
    self->reference_um = reference_um;
    self->asked_um[now] = reference_um;
    self->expected_um[now] = self->model.y_um + self->offset_um;
    self->oldest = (now + 1u < CONTROLLER_LINE) ? now + 1u : 0u;
    self->learns = learns;
    return u_V;
}

/* End of HOLD: reference and delay lines start at the displacement of the model; from here on the inverse gives the voltage. */
static void controller_take_over(controller_t *self)
{
    self->reference_um = self->model.y_um + self->offset_um;
    for (uint32_t i = 0u; i < CONTROLLER_LINE; ++i) {
        self->asked_um[i] = self->reference_um;
        self->expected_um[i] = self->reference_um;
    }
    self->oldest = 0u;
    hysgen_watchdog_judge(&self->watchdog, self->settings, 0.5f * (self->above_um - self->below_um));
    model_learn_init(&self->learner, &self->model);
    self->model.status = 0u;  /* of the way here: LOOP may begin below the model's range */
    self->state = CONTROLLER_APPROACH;
}

/* On the way back of LOOP and in HOLD: how far the model's error goes either way. */
static void controller_compare(controller_t *self)
{
    const float beyond_um = self->watchdog.reading_um - self->model.y_um;

    self->above_um = (beyond_um > self->above_um) ? beyond_um : self->above_um;
    self->below_um = (beyond_um < self->below_um) ? beyond_um : self->below_um;
}

/* Voltage of LOOP; the model follows by simulation. At its highest voltage the parameters must be those that were meant: others, because a
 * wild access or a glitch came between, are told before the inverse uses them [S9]. At the end the strokes of stage and model are compared. */
static float controller_loop(controller_t *self)
{
    const settings_t *settings = self->settings;
    const float middle_V = 0.5f * (settings->loop_low_V + settings->loop_high_V);
    const float target_V = (self->upward != 0u) ? settings->loop_high_V : middle_V;
    const float u_V = controller_towards(self->output_V, target_V, settings->ramp_V);
    bank_t taken;

    if (u_V == target_V) {
        if (self->upward != 0u) {
            self->upward = 0u;
            hysgen_bank_take(&taken, &self->model);
            if (hysgen_bank_check(&taken) != self->bank_check) {
                self->status |= STATUS_FAULT_MEMORY;
            }
            self->top_um = self->watchdog.reading_um;
            self->top_model_um = self->model.y_um;
            self->above_um = self->top_um - self->top_model_um;
            self->below_um = self->above_um;
        } else {
            const float stroke_um = self->top_um - self->watchdog.reading_um;
            const float model_um = self->top_model_um - self->model.y_um;

            if (!(number_size(stroke_um - model_um) <= CONTROLLER_STROKE_SHARE * number_size(model_um))) {
                self->status |= STATUS_FAULT_STROKE;
            }
            self->state = CONTROLLER_HOLD;
        }
    }
    if (self->upward == 0u) {
        controller_compare(self);
    }
    (void)model_simulate(&self->model, u_V);
    return u_V;
}

/* Voltage of RISE, which leads to the loop, or to the first voltage of the table. */
static float controller_rise(controller_t *self)
{
    const settings_t *settings = self->settings;
    const float first_V = (self->plays != 0u) ? hysgen_play_voltage(&self->play, 0u) : settings->loop_low_V;
    const float target_V = number_limited(first_V, settings->low_V, settings->high_V);
    const float u_V = controller_towards(self->output_V, target_V, settings->ramp_V);

    if ((u_V == target_V) && (self->plays != 0u)) {
        self->state = CONTROLLER_PLAY;
    } else if (u_V == target_V) {
        controller_begin(self);
    } else {
        /* On the way. */
    }
    return u_V;
}

/* The next voltage of the table, and the reading in its place. A voltage beyond range or rate ends the table in front of it. [S12] */
static float controller_play(controller_t *self)
{
    const settings_t *settings = self->settings;
    const float u_V = hysgen_play_voltage(&self->play, self->play.done);
    const uint32_t beyond = (uint32_t)(u_V < settings->low_V) | (uint32_t)(u_V > settings->high_V);
    const uint32_t fast = (uint32_t)(number_size(u_V - self->output_V) > settings->step_V);

    self->status |= (beyond * STATUS_OUTPUT_LIMITED) | (fast * STATUS_OUTPUT_SLEWED);
    if ((beyond | fast) != 0u) {
        self->state = CONTROLLER_FALL;
        return self->output_V;
    }
    hysgen_play_record(&self->play, self->watchdog.sample_um);
    if (self->play.done >= self->play.count) {
        self->state = CONTROLLER_FALL;
    }
    return u_V;
}

/* Voltage of the present state, before the limits of the output; changes to the next state where it is due. */
static float controller_voltage(controller_t *self, float reference_um)
{
    const settings_t *settings = self->settings;
    float u_V = settings->off_V;
    uint32_t reached;
    float next_um;

    switch (self->state) {
    case CONTROLLER_POWER:
        if (self->powered >= settings->power_samples) {
            self->state = CONTROLLER_RISE;
        }
        break;
    case CONTROLLER_RISE:
        u_V = controller_rise(self);
        break;
    case CONTROLLER_PLAY:
        u_V = controller_play(self);
        break;
    case CONTROLLER_LOOP:
        u_V = controller_loop(self);
        break;
    case CONTROLLER_HOLD:
        u_V = self->output_V;
        if (settings->hold_samples - self->held <= self->hold_mean) {
            self->held_um += self->watchdog.reading_um - self->model.y_um;
        }
        controller_compare(self);
        (void)model_simulate(&self->model, u_V);
        self->held += 1u;
        if (self->held >= settings->hold_samples) {
            const float mean_um = self->held_um * self->hold_share;

            self->offset_um = ((settings->options & SETTINGS_NO_OFFSET) == 0u) ? mean_um : 0.0f;
            if (!(number_size(mean_um) <= settings->offset_um)) {
                self->status |= STATUS_FAULT_OFFSET;
            } else {
                controller_take_over(self);
            }
        }
        break;
    case CONTROLLER_APPROACH:
        next_um = controller_reference(self, reference_um, CONTROLLER_UM_PER_V * settings->ramp_V, &reached);
        u_V = controller_follow(self, next_um);
        if (reached != 0u) {
            self->state = CONTROLLER_TRACK;
        }
        break;
    case CONTROLLER_TRACK:
        next_um = controller_reference(self, reference_um, settings->reference_step_um, &reached);
        self->status |= (reached == 0u) ? STATUS_REFERENCE_SLEWED : 0u;
        u_V = controller_follow(self, next_um);
        break;
    case CONTROLLER_FALL:
        u_V = controller_towards(self->output_V, settings->off_V, settings->ramp_V);
        if (u_V == settings->off_V) {
            if (((settings->options & SETTINGS_KEEP) != 0u) && (self->begun != 0u)) {
                controller_take_bank(self);
            }
            self->state = CONTROLLER_OFF;
        }
        break;
    case CONTROLLER_TRIP:
        u_V = controller_towards(self->output_V, settings->off_V, settings->ramp_V);
        if (u_V == settings->off_V) {
            self->state = CONTROLLER_TRIPPED;
        }
        break;
    default:
        break;
    }
    return u_V;
}

/* No state but OFF, TRACK and TRIPPED lasts for ever; PLAY ends with its table. TRIP that does not end by itself ends at the largest rate. */
static void controller_limit_time(controller_t *self, controller_state_t before)
{
    const controller_state_t state = self->state;

    if (state != before) {
        self->waited = 0u;
    } else if (self->waited < self->settings->state_samples) {
        self->waited += 1u;
    } else if (state == CONTROLLER_TRIP) {
        self->status |= STATUS_FAULT_TIMEOUT;
        self->state = CONTROLLER_TRIPPED;
    } else if ((hysgen_controller_drives(self) != 0u) && (state != CONTROLLER_TRACK) && (state != CONTROLLER_PLAY)) {
        self->status |= STATUS_FAULT_TIMEOUT;
    } else {
        /* A state that may last. */
    }
}

/* BOARD_AMPLIFIER_ bits of this sample: of no meaning while the amplifier is off, and waited for in POWER. */
static void controller_watch_amplifier(controller_t *self, uint32_t amplifier)
{
    if (hysgen_controller_drives(self) == 0u) {
        return;
    }
    if (((amplifier & BOARD_STOPPED) != 0u) && (self->state != CONTROLLER_TRIP)) {
        self->state = CONTROLLER_FALL;
    }
    if (self->state == CONTROLLER_POWER) {
        self->powered = (amplifier == 0u) ? self->powered + 1u : 0u;
    } else {
        self->status |= hysgen_watchdog_amplifier(&self->watchdog, amplifier);
    }
}

/* A fault brings the voltage down, or, where the voltage is down already, switches off at once. */
static void controller_trip(controller_t *self)
{
    const uint32_t faults = self->status & STATUS_FAULTS;

    if (faults != 0u) {
        if (self->first == 0u) {
            self->first = faults;
        }
        if ((hysgen_controller_drives(self) == 0u) || (self->state == CONTROLLER_POWER)) {
            self->state = CONTROLLER_TRIPPED;
        } else {
            self->state = CONTROLLER_TRIP;
        }
    }
}

float hysgen_controller_step(controller_t *self, float y_um, float reference_um, uint32_t amplifier)
{
    const settings_t *settings = self->settings;
    controller_state_t before;
    float state_V;
    float within_V;

    self->samples += 1u;
    self->learns = 0u;
    if ((self->status & STATUS_FAULT_SETTINGS) != 0u) {
        controller_trip(self);
        controller_take_request(self);
        return self->output_V;
    }
    before = self->state;
    if (self->request != CONTROLLER_NO_REQUEST) {
        controller_take_request(self);
    }
    self->status |= hysgen_watchdog_reading(&self->watchdog, y_um, self->output_V) | self->damaged;
    controller_watch_amplifier(self, amplifier);
    controller_trip(self);
    state_V = controller_voltage(self, reference_um);
    controller_limit_time(self, before);
    /* [S2] Each state keeps to the limits by itself, so that model and output get the same voltage. These lines hold for any
     * voltage of a state, even for NaN: the output stays inside its range and below its rate. */
    if (number_finite(state_V) == 0u) {
        state_V = self->output_V;
        self->status |= STATUS_OUTPUT_LIMITED;
    }
    within_V = number_limited(state_V, settings->low_V, settings->high_V);
    if (within_V != state_V) {
        self->status |= STATUS_OUTPUT_LIMITED;
    }
    self->output_V = number_limited(controller_towards(self->output_V, within_V, settings->step_V), settings->low_V, settings->high_V);
    if (self->output_V != within_V) {
        self->status |= STATUS_OUTPUT_SLEWED;
    }
    return self->output_V;
}

/* The sample of this interrupt; dropped TRACE_BEHIND samples behind the first fault. */
static void controller_trace(controller_t *self)
{
    trace_t *trace = &self->trace;
    const uint32_t count = trace->count;
    const uint32_t left = trace->left;
    uint32_t *place = &trace->words[TRACE_WORDS * (count & (TRACE_SAMPLES - 1u))];

    if (left != 0u) {
        place[0] = number_bits(self->watchdog.raw_um);
        place[1] = number_bits(self->output_V);
        place[2] = number_bits(self->reference_um);
        place[3] = (uint32_t)self->state;
        trace->count = (count != UINT32_MAX) ? count + 1u : TRACE_SAMPLES;
        trace->left = (self->first != 0u) ? left - 1u : left;
    }
}

/* A commit reads and writes parameters, their age and its candidate only. A sample that comes inside a commit is handed on as a reading
 * that is none: the learner rejects it before it touches these, but its path and its terms go on with the stage. */
void hysgen_controller_learn(controller_t *self)
{
    float sample_um = self->watchdog.sample_um;

    controller_trace(self);
    if ((self->begun & (uint32_t)((self->settings->options & SETTINGS_LEARN) != 0u)) != 0u) {
        self->start_um = model_simulate(&self->witness, self->output_V);
    }
    if (self->learns == 0u) {
        return;
    }
    self->learns = 0u;
    if (self->committing != 0u) {
        self->status |= STATUS_LEARN_SKIPPED;
        sample_um = number_of(NUMBER_NAN);
    }
    model_learn(&self->learner, sample_um - self->offset_um, self->output_V);
}

void hysgen_controller_time(controller_t *self, uint32_t cycles, uint32_t overrun, uint32_t since)
{
    const uint32_t lost = (uint32_t)(since > BOARD_PERIOD_CYCLES + (BOARD_PERIOD_CYCLES >> 1));

    if (lost != 0u) {
        self->status |= STATUS_INTERRUPT_LOST;
    }
    self->status |= hysgen_watchdog_time(&self->watchdog, cycles, overrun | lost);
}
