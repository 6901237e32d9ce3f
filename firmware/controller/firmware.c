#include "firmware.h"

#include "model.h"

void firmware_boot(firmware_t *self, board_t *board, const settings_t *settings)
{
    self->received = IMAGE_BYTES;
    self->image_status = 0u;
    self->cleared = 0u;
    self->image_answer = IMAGE_GOOD;
    self->image_pending = 0u;
    self->commit_answer = MODEL_BUSY;
    self->commits = 0u;
    self->commit_last = 0u;
    self->committing = 0u;
    self->ticked = 0u;
    self->cycles_last = 0u;
    self->cycles_most = 0u;
    self->entered = 0u;
    controller_init(&self->controller, settings);
    self->settings_wrong = settings_check(settings);
    if (self->settings_wrong != (const char *)0) {
        self->controller.status |= STATUS_FAULT_SETTINGS;
    }
    self->selftest = model_selftest();
    if (self->selftest != 0u) {
        self->controller.status |= STATUS_FAULT_SELFTEST;
    }
    if (store_load(&self->store, board, &self->bench, &self->controller.bank) != 0u) {
        self->image_status = STATUS_IMAGE_FALLBACK;
    }
}

void firmware_interrupt(firmware_t *self, board_t *board)
{
    const uint32_t start = board_cycles(board);
    const uint32_t since = (self->controller.samples != 0u) ? start - self->entered : 0u;
    const float y_um = board_displacement_um(board);
    const float reference_um = board_reference_um(board);
    const uint32_t amplifier = board_amplifier(board);

    self->entered = start;
    board_voltage(board, controller_step(&self->controller, y_um, reference_um, amplifier));
    controller_learn(&self->controller);
    self->cycles_last = board_cycles(board) - start;
    self->cycles_most = (self->cycles_last > self->cycles_most) ? self->cycles_last : self->cycles_most;
    controller_time(&self->controller, self->cycles_last, board_overrun(board), since);
}

uint32_t firmware_status(const firmware_t *self)
{
    return self->controller.status | self->image_status;
}

/* Bytes of an image as they arrive; a complete one waits for the stage to be off. Bytes behind a complete one, noise on the
 * line for instance, are ignored until the next image begins. */
static void firmware_receive(firmware_t *self, board_t *board)
{
    uint8_t bytes[64];
    uint32_t begin = 0u;
    const uint32_t count = board_receive(board, bytes, (uint32_t)sizeof bytes, &begin);

    if (begin != 0u) {
        self->received = 0u;
        self->image_pending = 0u;
    }
    for (uint32_t i = 0u; (i < count) & (self->received < IMAGE_BYTES); ++i) {
        self->incoming[self->received] = bytes[i];
        self->received += 1u;
        self->image_pending = (uint32_t)(self->received == IMAGE_BYTES);
    }
}

/* Certification and store take milliseconds and touch nothing that the interrupt uses; taking over is one copy. */
static void firmware_take_image(firmware_t *self, board_t *board)
{
    model_bank_t bank;

    self->image_pending = 0u;
    for (uint32_t i = 0u; i < IMAGE_BYTES; ++i) {
        self->store.bytes[i] = self->incoming[i];
    }
    self->image_answer = store_keep(&self->store, board, &self->bench, &bank, IMAGE_BYTES);
    if (self->image_answer != IMAGE_GOOD) {
        self->image_status |= STATUS_IMAGE_REFUSED;
    } else {
        (void)controller_install(&self->controller, &bank);
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
    if ((state == CONTROLLER_OFF) | (state == CONTROLLER_TRIPPED)) {
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

    if (((controller->settings->options & SETTINGS_LEARN) == 0u) | (controller->state != CONTROLLER_TRACK)) {
        self->committing = 0u;
        return;
    }
    if ((self->committing == 0u) & (controller->samples - self->commit_last < controller->settings->commit_pause)) {
        return;
    }
    self->committing = 1u;
    controller->committing = 1u;
    answer = model_commit(&controller->model, &controller->learner);
    controller->committing = 0u;
    if (answer != MODEL_BUSY) {
        self->committing = 0u;
        self->commit_answer = answer;
        self->commit_last = controller->samples;
        self->commits += (uint32_t)(answer == MODEL_COMMITTED);
    }
}

void firmware_idle(firmware_t *self, board_t *board)
{
    const uint32_t clears = self->controller.clears;
    const uint32_t samples = self->controller.samples;

    if (self->cleared != clears) {
        self->cleared = clears;
        self->image_status = 0u;
    }
    firmware_receive(self, board);
    firmware_image(self, board);
    if (self->ticked != samples) {
        self->ticked = samples;
        firmware_commit(self);
    }
}
