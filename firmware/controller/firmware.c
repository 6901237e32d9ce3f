#include "firmware.h"

#include <stddef.h>

#include "bank.h"
#include "bytes.h"
#include "model.h"
#include "number.h"

/* Kept over a reset: the first fault, and the same word with these bits turned. */
#define FIRMWARE_KEPT 0x5AFE0FFFu

/* Parameters and settings, of an image. */
#define FIRMWARE_KEPT_WORDS (BANK_WORDS + SETTINGS_WORDS)

/* Samples until an idle loop that does not come back is left to the hardware's watchdog: 1 s, more than twice the erasing of a slot. */
#define FIRMWARE_IDLE_SAMPLES 50000u

static void firmware_keep(board_t *board, uint32_t fault)
{
    uint32_t *kept = hysgen_board_kept(board);

    kept[0] = fault;
    kept[1] = fault ^ FIRMWARE_KEPT;
}

/* What was kept, 0: nothing. Both words are of faults, though the reset may have come between them. */
static uint32_t firmware_kept(board_t *board)
{
    const uint32_t *kept = hysgen_board_kept(board);

    return (((kept[0] | (kept[1] ^ FIRMWARE_KEPT)) & ~STATUS_FAULTS) == 0u) ? kept[0] : 0u;
}

void hysgen_firmware_boot(firmware_t *self, board_t *board, const settings_t *settings, const image_owner_t *owner)
{
    const settings_t *used = &self->settings;
    bank_t bank;

    self->received = 0u;
    self->image_arrives = 0u;
    self->image_status = 0u;
    self->cleared = 0u;
    self->image_answer = IMAGE_GOOD;
    self->image_pending = 0u;
    self->commit_answer = MODEL_BUSY;
    self->commits = 0u;
    self->committing = 0u;
    self->ticked = 0u;
    self->cycles_last = 0u;
    self->cycles_most = 0u;
    self->entered = 0u;
    self->asked_um = 0.0f;
    self->asks = 0u;
    self->lease = 0u;
    self->heard = 0u;
    hysgen_link_init(&self->link);
    self->built_in = settings;
    for (uint32_t i = 0u; i < SETTINGS_WORDS; ++i) {
        hysgen_settings_put(&self->settings, i, hysgen_settings_word(settings, i));
    }
    if (hysgen_store_load(&self->store, board, owner, &self->bench, &bank) != 0u) {
        self->image_status = STATUS_IMAGE_FALLBACK;
    }
    if (self->store.slot != STORE_NONE) {
        hysgen_image_settings(self->store.bytes, settings, &self->settings);
    }
    for (uint32_t i = 0u; i < SETTINGS_WORDS; ++i) {
        hysgen_settings_put(&self->next, i, hysgen_settings_word(used, i));
    }
    self->settings_wrong = hysgen_settings_check(used);  /* [S3] */
    hysgen_controller_init(&self->controller, used, (self->settings_wrong == NULL) ? used->off_V : BOARD_SAFE_V);
    if (self->store.slot != STORE_NONE) {
        (void)hysgen_controller_install(&self->controller, &bank, hysgen_image_numbers(self->store.bytes));
    }
    hysgen_play_init(&self->controller.play, hysgen_board_record(board));
    if (self->settings_wrong == NULL) {
        hysgen_board_calibrate(board, used->reading_zero_um, used->reading_gain, used->output_zero_V, used->output_gain);
    } else {
        hysgen_board_calibrate(board, 0.0f, 1.0f, 0.0f, 1.0f);
    }
    if (hysgen_board_power_on(board) == 0u) {
        self->controller.status |= STATUS_FAULT_RESET;  /* [S8] */
        self->controller.first = firmware_kept(board);
    }
    if (self->settings_wrong != NULL) {
        self->controller.status |= STATUS_FAULT_SETTINGS;
    }
    self->selftest = model_selftest();  /* [S6] */
    if (self->selftest != 0u) {
        self->controller.status |= STATUS_FAULT_SELFTEST;
    }
    hysgen_integrity_init(&self->integrity, board, used);
}

void hysgen_firmware_interrupt(firmware_t *self, board_t *board)
{
    const uint32_t start = hysgen_board_cycles(board);
    const uint32_t since = (self->controller.samples != 0u) ? start - self->entered : 0u;
    const float y_um = hysgen_board_displacement_um(board);
    const float board_um = hysgen_board_reference_um(board);
    const float reference_um = (self->asks != 0u) ? self->asked_um : board_um;
    const uint32_t amplifier = hysgen_board_amplifier(board);

    self->entered = start;
    hysgen_board_voltage(board, hysgen_controller_step(&self->controller, y_um, reference_um, amplifier));
    hysgen_controller_learn(&self->controller);
    hysgen_board_line_serve(board);
    hysgen_board_amplifier_enable(board, hysgen_controller_drives(&self->controller));
    firmware_keep(board, self->controller.first);
    /* [S7] The watchdog waits for both: an idle loop that is stuck stops it too, though not one that erases memory. */
    if (self->controller.samples - self->ticked < FIRMWARE_IDLE_SAMPLES) {
        hysgen_board_alive(board);
    }
    self->cycles_last = hysgen_board_cycles(board) - start;
    self->cycles_most = (self->cycles_last > self->cycles_most) ? self->cycles_last : self->cycles_most;
    hysgen_controller_time(&self->controller, self->cycles_last, hysgen_board_overrun(board), since);
}

uint32_t hysgen_firmware_status(const firmware_t *self)
{
    return self->controller.status | self->image_status;
}

void hysgen_firmware_panic(const firmware_t *self, board_t *board)
{
    hysgen_board_amplifier_enable(board, 0u);
    /* Before boot the first fault is where it was kept. */
    firmware_keep(board, self->controller.first | firmware_kept(board) | STATUS_FAULT_EXCEPTION);
}

static void firmware_answer_status(firmware_t *self, const board_t *board)
{
    const controller_t *controller = &self->controller;
    link_t *link = &self->link;

    hysgen_link_add(link, (uint32_t)controller->state);
    hysgen_link_add(link, hysgen_firmware_status(self));
    hysgen_link_add(link, controller->first);
    hysgen_link_add(link, controller->samples);
    hysgen_link_add(link, number_bits(controller->watchdog.reading_um));
    hysgen_link_add(link, number_bits(controller->output_V));
    hysgen_link_add(link, number_bits(controller->reference_um));
    hysgen_link_add(link, number_bits(controller->offset_um));
    hysgen_link_add(link, self->image_answer);
    hysgen_link_add(link, self->image_pending);
    hysgen_link_add(link, self->received);
    hysgen_link_add(link, self->store.counter);
    hysgen_link_add(link, self->commits);
    hysgen_link_add(link, self->commit_answer);
    hysgen_link_add(link, controller->learner.updates);
    hysgen_link_add(link, controller->learner.rejected);
    hysgen_link_add(link, self->cycles_last);
    hysgen_link_add(link, self->cycles_most);
    hysgen_link_add(link, self->selftest);
    hysgen_link_add(link, 4u * self->integrity.unused);
    hysgen_link_add(link, number_bits(hysgen_board_read_back_V(board)));
}

static void firmware_answer_identity(firmware_t *self)
{
    static const uint32_t digest[4] = MODEL_DIGEST;
    const image_owner_t *owner = self->store.owner;
    link_t *link = &self->link;

    hysgen_link_add(link, LINK_VERSION);
    for (uint32_t i = 0u; i < 4u; ++i) {
        hysgen_link_add(link, digest[i]);
    }
    hysgen_link_add(link, MODEL_BUILD);
    hysgen_link_add(link, owner->device[0]);
    hysgen_link_add(link, owner->device[1]);
    hysgen_link_add(link, hysgen_image_keyed(owner));
    hysgen_link_add(link, MODEL_PERIOD_NS);
    hysgen_link_add(link, MODEL_PREVIEW);
    hysgen_link_add(link, IMAGE_BYTES);
    hysgen_link_add(link, MODEL_RULES);
    hysgen_link_add(link, MODEL_WEIGHTS);
    hysgen_link_add(link, number_bits(MODEL_Y_MIN_UM));
    hysgen_link_add(link, number_bits(MODEL_Y_MAX_UM));
    hysgen_link_add(link, number_bits(MODEL_U_MIN_V));
    hysgen_link_add(link, number_bits(MODEL_U_MAX_V));
    hysgen_link_add(link, number_bits(BOARD_LOW_V));
    hysgen_link_add(link, number_bits(BOARD_HIGH_V));
    hysgen_link_add(link, number_bits(BOARD_LOW_UM));
    hysgen_link_add(link, number_bits(BOARD_HIGH_UM));
    hysgen_link_add(link, BOARD_RECORD);
    hysgen_link_add_text(link, MODEL_NAME);
}

/* 1 if the stage rests and will: nobody but the idle loop writes the table then. */
static uint32_t firmware_rests(const firmware_t *self)
{
    return (uint32_t)(hysgen_controller_drives(&self->controller) == 0u) & (uint32_t)(self->controller.request == CONTROLLER_NO_REQUEST);
}

/* The table becomes a record. A repeated command, whose answer was lost, finds that one in play. */
static uint8_t firmware_record(firmware_t *self)
{
    play_t *play = &self->controller.play;
    uint8_t code = LINK_VALUE;

    if ((self->controller.state == CONTROLLER_OFF) && (play->loaded != 0u)) {
        play->count = play->loaded;
        play->loaded = 0u;
        play->done = 0u;
        code = LINK_DONE;
    } else if ((self->controller.plays != 0u) && (hysgen_controller_drives(&self->controller) != 0u)) {
        code = LINK_DONE;
    } else {
        /* Not at rest, or no table. */
    }
    return code;
}

/* A piece of a table of voltages. Offset 0 begins one; any other piece follows the one before, or repeats one. */
static uint8_t firmware_table(firmware_t *self, const uint8_t *data, uint32_t count)
{
    play_t *play = &self->controller.play;
    uint8_t code = LINK_LENGTH;

    if ((count > 4u) && (count <= 4u + LINK_CHUNK) && ((count & 1u) == 0u)) {
        const uint32_t place = bytes_word(data) >> 1;
        const uint32_t length = (count - 4u) >> 1;

        code = LINK_VALUE;
        if ((firmware_rests(self) != 0u) && (place <= play->loaded) && (place <= BOARD_RECORD - length)) {
            for (uint32_t i = 0u; i < length; ++i) {
                const uint8_t *at = &data[4u + 2u * i];

                play->words[(place + i) & (BOARD_RECORD - 1u)] = (uint16_t)((uint32_t)at[0] | ((uint32_t)at[1] << 8));
            }
            play->loaded = place + length;
            code = LINK_DONE;
        }
    }
    return code;
}

static void firmware_answer_record(firmware_t *self, uint32_t place)
{
    const play_t *play = &self->controller.play;

    hysgen_link_add(&self->link, play->done);
    for (uint32_t i = 0u; i < LINK_CHUNK / 2u; i += 2u) {
        const uint32_t low = play->words[(place + i) & (BOARD_RECORD - 1u)];
        const uint32_t high = play->words[(place + i + 1u) & (BOARD_RECORD - 1u)];

        hysgen_link_add(&self->link, low | (high << 16));
    }
}

static void firmware_answer_trace(firmware_t *self, uint32_t place)
{
    const trace_t *trace = &self->controller.trace;

    hysgen_link_add(&self->link, trace->count);
    for (uint32_t i = 0u; i < LINK_CHUNK / 4u; ++i) {
        hysgen_link_add(&self->link, trace->words[(place + i) & ((TRACE_WORDS * TRACE_SAMPLES) - 1u)]);
    }
}

/* What an image made of it would hold. */
static void firmware_answer_kept(firmware_t *self, uint32_t place)
{
    const uint32_t end = (place < FIRMWARE_KEPT_WORDS) ? place + (LINK_CHUNK / 4u) : 0u;

    hysgen_link_add(&self->link, 4u * FIRMWARE_KEPT_WORDS);
    for (uint32_t i = place; (i < end) && (i < FIRMWARE_KEPT_WORDS); ++i) {
        hysgen_link_add(&self->link, (i < BANK_WORDS) ? hysgen_bank_word(&self->controller.bank, i)
                                                      : hysgen_settings_word(&self->next, i - BANK_WORDS));
    }
}

static uint8_t firmware_request(firmware_t *self, const uint8_t *data, uint32_t count)
{
    const uint32_t waits = self->controller.request;
    uint8_t code = LINK_LENGTH;

    if (count == 1u) {
        const uint32_t starts = (uint32_t)(data[0] == CONTROLLER_START);
        const uint32_t known = (uint32_t)(data[0] >= CONTROLLER_START) & (uint32_t)(data[0] <= CONTROLLER_RECORD);

        code = LINK_VALUE;
        if ((waits != CONTROLLER_NO_REQUEST) && (data[0] != CONTROLLER_STOP)) {
            /* Only STOP takes the place of a request that the interrupt has not seen; another of the kind is a repetition. [S11] */
            code = (waits == data[0]) ? LINK_DONE : LINK_VALUE;
        } else if (data[0] == CONTROLLER_RECORD) {
            code = firmware_record(self);
        } else if ((known != 0u) && ((starts == 0u) || (self->controller.state < CONTROLLER_FALL))) {
            code = LINK_DONE;
        } else {
            /* Unknown, or a START that would not be taken. */
        }
        if (code == LINK_DONE) {
            self->controller.request = data[0];
        }
    }
    return code;
}

static uint8_t firmware_reference(firmware_t *self, const uint8_t *data, uint32_t count)
{
    uint8_t code = LINK_LENGTH;

    if (count == 0u) {
        self->asks = 0u;
        self->lease = 0u;
        code = LINK_DONE;
    } else if ((count == 4u) || (count == 8u)) {
        const float asked_um = number_of(bytes_word(data));

        code = (number_finite(asked_um) != 0u) ? LINK_DONE : LINK_VALUE;
        if (code == LINK_DONE) {
            self->asked_um = asked_um;
            self->asks = 1u;
            self->lease = (count == 8u) ? bytes_word(&data[4]) : 0u;
        }
    } else {
        /* Neither a word nor nothing. */
    }
    return code;
}

/* A piece of an image. Offset 0 begins one and discards the pieces before; any other piece has to follow the one before, or to
 * repeat a piece whose answer was lost. A complete image waits for the stage to be off. */
static uint8_t firmware_piece(firmware_t *self, const uint8_t *data, uint32_t count)
{
    uint8_t code = LINK_LENGTH;

    if ((count > 4u) && (count <= 4u + LINK_CHUNK)) {
        const uint32_t offset = bytes_word(data);
        const uint32_t length = count - 4u;

        if (offset == 0u) {
            self->received = 0u;
            self->image_pending = 0u;
            self->image_arrives = 1u;
        }
        if ((self->image_arrives == 0u) && (self->received == IMAGE_BYTES) && (offset == IMAGE_BYTES - length)) {
            code = LINK_DONE;  /* the last piece once more: its answer was lost */
        } else if ((self->image_arrives == 0u) || (offset > self->received) || (length > IMAGE_BYTES - offset)) {
            code = LINK_VALUE;
        } else {
            for (uint32_t i = 0u; i < length; ++i) {
                const uint32_t at = offset + i;

                if (at < IMAGE_BYTES) {
                    self->incoming[at] = data[4u + i];
                }
            }
            self->received = offset + length;
            code = LINK_DONE;
        }
        if ((code == LINK_DONE) && (self->image_arrives != 0u) && (self->received == IMAGE_BYTES)) {
            self->image_pending = 1u;
            self->image_arrives = 0u;
        }
    }
    return code;
}

/* A command and its answer. */
static void firmware_obey(firmware_t *self, const board_t *board, const uint8_t *command, uint32_t count)
{
    const uint8_t kind = command[0];
    const uint8_t number = (count > 1u) ? command[1] : 0u;
    const uint8_t *data = &command[2];
    const uint32_t length = (count > 2u) ? count - 2u : 0u;
    uint8_t code = LINK_UNKNOWN;

    if (count < 2u) {
        code = LINK_LENGTH;
    } else if (kind == LINK_REQUEST) {
        code = firmware_request(self, data, length);
    } else if (kind == LINK_REFERENCE) {
        code = firmware_reference(self, data, length);
    } else if (kind == LINK_IMAGE) {
        code = firmware_piece(self, data, length);
    } else if (kind == LINK_TABLE) {
        code = firmware_table(self, data, length);
    } else if ((kind == LINK_RECORD) || (kind == LINK_TRACE)) {
        code = (length == 4u) ? LINK_DONE : LINK_LENGTH;
    } else if (kind == LINK_KEPT) {
        code = (length == 4u) ? LINK_DONE : LINK_LENGTH;
        if ((code == LINK_DONE) && (firmware_rests(self) == 0u)) {
            code = LINK_VALUE;
        }
    } else if ((kind == LINK_STATUS) || (kind == LINK_IDENTIFY)) {
        code = (length == 0u) ? LINK_DONE : LINK_LENGTH;
    } else {
        /* Unknown. */
    }
    hysgen_link_answer(&self->link, kind, number, code);
    if ((code == LINK_DONE) && (kind == LINK_STATUS)) {
        firmware_answer_status(self, board);
    }
    if ((code == LINK_DONE) && (kind == LINK_IDENTIFY)) {
        firmware_answer_identity(self);
    }
    if ((code == LINK_DONE) && (kind == LINK_RECORD)) {
        firmware_answer_record(self, bytes_word(data) >> 1);
    }
    if ((code == LINK_DONE) && (kind == LINK_TRACE)) {
        firmware_answer_trace(self, bytes_word(data) >> 2);
    }
    if ((code == LINK_DONE) && (kind == LINK_KEPT)) {
        firmware_answer_kept(self, bytes_word(data) >> 2);
    }
    hysgen_link_close(&self->link);
}

/* At most so many bytes to and from the line a call: the idle loop has other things to do. */
#define FIRMWARE_LINE_BYTES 64u

/* Sends what is left of an answer, and takes commands. A command that comes while its place is taken by an answer on its way is
 * dropped, and its sender asks again; STOP is obeyed all the same, so that no flood of commands holds it back. [S11] */
static void firmware_line(firmware_t *self, board_t *board)
{
    link_t *link = &self->link;
    uint32_t more = 1u;

    for (uint32_t i = 0u; (i < FIRMWARE_LINE_BYTES) && (more != 0u); ++i) {
        uint32_t sends = 0u;
        uint32_t sent = 0u;
        uint8_t byte = 0u;

        if ((link->wire_sent < link->wire_count) && (link->wire_sent < FRAME_WIRE)) {
            sends = 1u;
            sent = hysgen_board_line_write(board, &link->wire[link->wire_sent], 1u);
            link->wire_sent += sent;
        }
        more = hysgen_board_line_read(board, &byte, 1u);
        if (more != 0u) {
            const uint8_t *command = link->frame.bytes;
            const uint32_t count = hysgen_frame_take(&link->frame, byte);

            if (count != 0u) {
                self->heard = self->controller.samples;
                if (sends == 0u) {
                    firmware_obey(self, board, command, count);
                } else if ((count == 3u) && (command[0] == LINK_REQUEST) && (command[2] == CONTROLLER_STOP)) {
                    self->controller.request = CONTROLLER_STOP;
                } else {
                    /* Dropped. */
                }
            }
        }
        more |= sent;
    }
}

/* The status of images ends with a CLEAR. */
static void firmware_clear_images(firmware_t *self)
{
    const uint32_t clears = self->controller.clears;

    if (self->cleared != clears) {
        self->cleared = clears;
        self->image_status = 0u;
    }
}

/* Certification and store take milliseconds and touch nothing that the interrupt uses; taking over is one copy. */
static void firmware_take_image(firmware_t *self, board_t *board)
{
    bank_t bank;

    hysgen_bank_copy(&bank, &self->controller.bank);
    self->image_pending = 0u;
    for (uint32_t i = 0u; i < IMAGE_BYTES; ++i) {
        self->store.bytes[i] = self->incoming[i];
    }
    self->image_answer = hysgen_store_keep(&self->store, board, &self->bench, &bank, IMAGE_BYTES);
    firmware_clear_images(self);  /* one that came meanwhile: what is told from here on comes behind it */
    if (self->image_answer != IMAGE_GOOD) {
        self->image_status |= STATUS_IMAGE_REFUSED;
    } else {
        (void)hysgen_controller_install(&self->controller, &bank, hysgen_image_numbers(self->store.bytes));
        hysgen_image_settings(self->store.bytes, self->built_in, &self->next);
    }
}

/* From the moment that `installing` is set no START is taken: a state that is off stays off until the image is installed. */
static void firmware_image(firmware_t *self, board_t *board)
{
    controller_state_t state;

    if (self->image_pending == 0u) {
        return;
    }
    self->controller.installing = 1u;
    state = self->controller.state;
    if ((state == CONTROLLER_OFF) || (state == CONTROLLER_TRIPPED)) {
        firmware_take_image(self, board);
    }
    self->controller.installing = 0u;
}

/* One call of the model's commit per sample, right behind the interrupt, so that it ends before the next one. Should it
 * not, the interrupt sees `committing` and leaves the learner alone for that sample. */
static void firmware_commit(firmware_t *self)
{
    controller_t *controller = &self->controller;
    uint32_t answer;

    if (((controller->settings->options & SETTINGS_LEARN) == 0u) || (controller->state != CONTROLLER_TRACK)) {
        self->committing = 0u;
        return;
    }
    if ((self->committing == 0u) && (controller->learner.age < MODEL_COMMIT_MATURE)) {
        return;
    }
    self->committing = 1u;
    controller->committing = 1u;
    answer = (uint32_t)model_commit(&controller->model, &controller->learner);
    controller->committing = 0u;
    if ((answer != MODEL_BUSY) && (answer != MODEL_TRYING)) {
        self->committing = 0u;
        self->commit_answer = answer;
        self->commits += (uint32_t)(answer == MODEL_COMMITTED);
    }
}

void hysgen_firmware_idle(firmware_t *self, board_t *board)
{
    const uint32_t samples = self->controller.samples;

    firmware_clear_images(self);
    firmware_line(self, board);
    if ((self->lease != 0u) && (self->controller.samples - self->heard > self->lease)) {
        /* Nobody speaks any more who has asked for a reference with a lease. */
        self->lease = 0u;
        self->controller.request = CONTROLLER_STOP;
    }
    firmware_image(self, board);
    if (self->ticked != samples) {
        self->ticked = samples;
        firmware_commit(self);
        if (hysgen_integrity_step(&self->integrity) != 0u) {
            self->controller.damaged = STATUS_FAULT_MEMORY;
        }
    }
}
