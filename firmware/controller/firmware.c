#include "firmware.h"

#include "model.h"

void firmware_boot(firmware_t *self, board_t *board, const settings_t *settings)
{
    self->received = 0u;
    self->image_answer = IMAGE_GOOD;
    self->image_pending = 0u;
    self->commit_answer = MODEL_BUSY;
    self->commits = 0u;
    self->commit_last = 0u;
    self->committing = 0u;
    self->ticked = 0u;
    self->cycles_last = 0u;
    self->cycles_most = 0u;
    controller_init(&self->controller, settings);
    self->selftest = model_selftest();
    if (self->selftest != 0u) {
        self->controller.status |= STATUS_FAULT_SELFTEST;
    }
    if (store_load(&self->store, board, &self->bench, &self->controller.bank) != 0u) {
        self->controller.status |= STATUS_IMAGE_FALLBACK;
    }
}

void firmware_interrupt(firmware_t *self, board_t *board)
{
    const uint32_t start = board_cycles(board);
    const float y_um = board_displacement_um(board);
    const float reference_um = board_reference_um(board);
    const uint32_t amplifier = board_amplifier(board);

    board_voltage(board, controller_step(&self->controller, y_um, reference_um, amplifier));
    controller_learn(&self->controller);
    self->cycles_last = board_cycles(board) - start;
    self->cycles_most = (self->cycles_last > self->cycles_most) ? self->cycles_last : self->cycles_most;
    controller_time(&self->controller, self->cycles_last, board_overrun(board));
}

/* Bytes of an image as they arrive; a complete one waits for the stage to be off. */
static void firmware_receive(firmware_t *self, board_t *board)
{
    uint8_t bytes[64];
    uint32_t begin = 0u;
    const uint32_t count = board_receive(board, bytes, (uint32_t)sizeof bytes, &begin);

    if (begin != 0u) {
        self->received = 0u;
        self->image_pending = 0u;
    }
    for (uint32_t i = 0u; i < count; ++i) {
        if (self->received < IMAGE_BYTES) {
            self->incoming[self->received] = bytes[i];
        }
        self->received += (uint32_t)(self->received < UINT32_MAX);
    }
    if ((count != 0u) & (self->received == IMAGE_BYTES)) {
        self->image_pending = 1u;
    }
    if (self->received > IMAGE_BYTES) {
        self->image_pending = 0u;
        self->image_answer = IMAGE_INCOMPLETE;
        self->controller.status |= STATUS_IMAGE_REFUSED;
    }
}

/* Certification and store take milliseconds and touch nothing that the interrupt uses; taking over is one copy. */
static void firmware_take_image(firmware_t *self, board_t *board)
{
    const controller_state_t state = self->controller.state;
    model_bank_t bank;

    if ((self->image_pending == 0u) | ((state != CONTROLLER_OFF) & (state != CONTROLLER_TRIPPED))) {
        return;
    }
    self->image_pending = 0u;
    self->received = 0u;
    for (uint32_t i = 0u; i < IMAGE_BYTES; ++i) {
        self->store.bytes[i] = self->incoming[i];
    }
    self->image_answer = store_keep(&self->store, board, &self->bench, &bank, IMAGE_BYTES);
    if (self->image_answer != IMAGE_GOOD) {
        self->controller.status |= STATUS_IMAGE_REFUSED;
        return;
    }
    (void)controller_install(&self->controller, &bank);
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
    firmware_receive(self, board);
    firmware_take_image(self, board);
    if (self->ticked != self->controller.samples) {
        self->ticked = self->controller.samples;
        firmware_commit(self);
    }
}
