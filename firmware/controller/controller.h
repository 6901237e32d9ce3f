/* controller.h: from reading and reference to voltage, once per sample: feed-forward through the model's inverse, with
 * safe start and stop around it.
 *
 *     OFF -> POWER -> RISE -> LOOP -> HOLD -> APPROACH -> TRACK   start
 *     OFF -> POWER -> RISE -> PLAY -> FALL -> OFF                  play a table, record the readings
 *     any of these but OFF -> FALL -> OFF                          stop
 *     any of them -> TRIP -> TRIPPED -> OFF                        fault; back to OFF by `clear` only
 *
 * The amplifier is on from POWER to OFF or TRIPPED, and a fault in OFF or POWER leads to TRIPPED without TRIP. POWER waits until the
 * amplifier has been good for power_samples in a row; only behind it is a failure of the amplifier a fault. RISE goes to the loop's low
 * voltage. LOOP goes from there to its high one and back to the middle: the hysteresis of model and stage no longer depends on earlier
 * voltages, and the stage must move as far on the way back as the model does, within 45 % of the model's stroke.
 * HOLD waits until the lag has decayed and takes the mean offset between stage and model (the sensor's zero, and earlier
 * creep), which must lie within +-offset_um: the only reading that the feed-forward ever uses. APPROACH
 * brings the reference, about as fast as the ramp, from where the model is to where the caller wants it, TRACK follows it. PLAY puts out
 * the voltages of a table, without model and feedback, and ends in front of the first one that the limits of the output would change. */

#ifndef CONTROLLER_H
#define CONTROLLER_H

#include <stdint.h>

#include "bank.h"
#include "linkage.h"
#include "model.h"
#include "play.h"
#include "settings.h"
#include "status.h"
#include "trace.h"
#include "watchdog.h"

LINKAGE_BEGIN

typedef enum {
    CONTROLLER_OFF = 0,
    CONTROLLER_POWER = 1,
    CONTROLLER_RISE = 2,
    CONTROLLER_LOOP = 3,
    CONTROLLER_HOLD = 4,
    CONTROLLER_APPROACH = 5,
    CONTROLLER_TRACK = 6,
    CONTROLLER_FALL = 7,
    CONTROLLER_TRIP = 8,
    CONTROLLER_TRIPPED = 9,
    CONTROLLER_PLAY = 10
} controller_state_t;

/* What the caller may ask for; taken at the next sample, START and RECORD not before parameters being installed are in place. */
#define CONTROLLER_NO_REQUEST     0u
#define CONTROLLER_START          1u  /* from OFF */
#define CONTROLLER_STOP           2u  /* from any state in which the stage moves */
#define CONTROLLER_CLEAR          3u  /* status; in OFF and TRIPPED also the watchdog's counts; from TRIPPED also back to OFF */
#define CONTROLLER_RECORD         4u  /* from OFF: play the table of `play` */

#define CONTROLLER_LINE (MODEL_PREVIEW + 1u)

typedef struct {
    const settings_t *settings;
    /* Shared by interrupt and idle loop. Idle writes `request`, `committing`, `installing` and `damaged` only. */
    volatile controller_state_t state;
    volatile uint32_t status;       /* STATUS_ bits, sticky until CLEAR */
    volatile uint32_t first;        /* STATUS_FAULT_ bits of the first sample that had any, until CLEAR at rest */
    volatile uint32_t samples;      /* since init; wraps */
    volatile uint32_t clears;       /* CLEARs that were taken; wraps */
    volatile uint32_t request;
    volatile uint32_t committing;   /* the idle loop is inside the model's commit */
    volatile uint32_t damaged;      /* STATUS_FAULT_MEMORY: code, constants or stack are not what they were, until the next boot */
    volatile uint32_t installing;   /* the idle loop is storing and installing parameters; START and RECORD wait */

    play_t play;             /* the idle loop writes all but `done`, and only at rest */
    uint32_t plays;          /* the start that was asked for last leads to PLAY */
    uint32_t learns;         /* this sample is one to learn from */
    float start_um;          /* displacement of the next sample by the parameters of START, learning or not */
    uint32_t begun;          /* the model drives with its own bank since the last START */
    uint32_t upward;         /* LOOP: on the way up */
    uint32_t waited;         /* samples in the present state */
    uint32_t powered;        /* POWER: samples in a row in which the amplifier was good */
    uint32_t held;           /* samples in HOLD */
    float top_um;            /* LOOP: reading at its highest voltage, */
    float top_model_um;      /* and displacement of the model there */
    float above_um;          /* on the way back of LOOP and in HOLD: largest displacement of the stage beyond the model's, */
    float below_um;          /* and smallest; half their difference is the model's own error */
    float offset_um;         /* displacement of the stage beyond the model's, its mean over the end of HOLD */
    uint32_t hold_mean;      /* samples of that mean: the largest power of two up to hold_samples */
    float hold_share;        /* 1 / hold_mean */
    float held_um;           /* sum of these displacements */
    float output_V;          /* voltage that was put out last */
    float reference_um;      /* reference that the inverse was asked for last, without feedback */
    float wanted_um;         /* last reference of the caller that was one */
    float asked_um[CONTROLLER_LINE];     /* references on their way to the present, oldest at `oldest` */
    float expected_um[CONTROLLER_LINE];  /* displacements of the stage by the model for the samples in between */
    uint32_t oldest;
    watchdog_t watchdog;
    trace_t trace;           /* of the samples around the first fault */
    model_t model;
    model_t witness;         /* with learning: the model as it was at START, under the voltage that is put out */
    model_learner_t learner;
    bank_t bank;             /* parameters that every start begins with, */
    uint32_t bank_check;     /* and their check word, which START compares with the parameters that it takes */
} controller_t;

/* Off at rest_V, with the parameters that the firmware was built with. */
void hysgen_controller_init(controller_t *self, const settings_t *settings, float rest_V);

/* 1 if the amplifier is to be on. */
uint32_t hysgen_controller_drives(const controller_t *self);

/* One sample.
 *
 * y_um          displacement y(k) [um] as read
 * reference_um  wanted displacement [um] of sample k + MODEL_PREVIEW + 1
 * amplifier     BOARD_AMPLIFIER_ bits
 * returns       u(k) [V] inside the settings' range, at most step_V from the one before */
float hysgen_controller_step(controller_t *self, float y_um, float reference_um, uint32_t amplifier);

/* After hysgen_controller_step, once its voltage is put out: learn from the same sample, the reading as it was and the voltage
 * that hysgen_controller_step returned. In this order the time of the learner does not delay the output. */
void hysgen_controller_learn(controller_t *self);

/* After a sample: cycles that it took, whether the next interrupt waits already, and cycles since the interrupt before, 0 if there was
 * none. Lost interrupts count as late ones. */
void hysgen_controller_time(controller_t *self, uint32_t cycles, uint32_t overrun, uint32_t since);

/* Parameters for the next start, and the check word of those that were meant; only in OFF, TRIP and TRIPPED. Returns 1 if taken. Set `installing` around the call, so that no
 * start begins inside it. */
uint32_t hysgen_controller_install(controller_t *self, const bank_t *bank, uint32_t check);

LINKAGE_END

#endif
