/* inputs.c: random settings, faults, references, requests and bytes on the line. */

#include "case.h"

#include "frame.h"
#include "link.h"

/* A number of any kind: bits, infinities, NaN, denormals, or one near the stage's range. */
static float any(fuzz_t *self)
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

/* Settings with short ramps; one case in four has a voltage of any kind. */
void fuzz_settings(fuzz_t *self)
{
    settings_t *s = &self->settings;
    float *voltages = &s->off_V;

    s->options = fuzz_below(self, 16u);
    if (fuzz_below(self, 2u) == 0u) {
        s->options &= ~SETTINGS_LEARN;  /* which takes half of the time of a case */
    }
    s->off_V = fuzz_float(self, -2.0f, 2.0f);
    s->low_V = fuzz_float(self, -20.0f, s->off_V);
    s->high_V = fuzz_float(self, 50.0f, 120.0f);
    s->step_V = fuzz_float(self, 0.02f, 3.0f);
    s->ramp_V = s->step_V * fuzz_float(self, 0.3f, 1.0f);
    s->loop_low_V = fuzz_float(self, 22.0f, 30.0f);
    s->loop_high_V = fuzz_float(self, 40.0f, 50.0f);
    s->power_samples = 1u + fuzz_below(self, 20u);
    s->hold_samples = 64u + fuzz_below(self, 140u);
    s->offset_um = fuzz_float(self, 0.3f, 2.0f);
    s->state_samples = 20000u + fuzz_below(self, 100000u);
    s->reference_step_um = fuzz_float(self, 0.0001f, 1.0f);
    s->follow_um = fuzz_float(self, 0.05f, 0.5f);
    s->follow_um = (s->follow_um < 0.45f) ? s->follow_um : 0.0f;
    s->reading_gain = 1.0f;
    s->output_gain = 1.0f;
    if (fuzz_below(self, 4u) == 0u) {
        voltages[fuzz_below(self, 5u)] = (fuzz_below(self, 2u) != 0u) ? any(self) : fuzz_float(self, -150.0f, 150.0f);
    }
}

static void fault(fuzz_t *self)
{
    board_t *board = &self->board;

    board->fault = fuzz_below(self, 10u);
    board->fault_value = any(self);
    if ((board->fault == HOST_FAULT_LATE) || (board->fault == HOST_FAULT_LOST)) {
        board->fault_value = fuzz_float(self, 0.0f, 30000.0f);
    }
    board->fault_from = 0u;
    board->fault_until = 0xFFFFFFFFu;
    board->fault_period = (fuzz_below(self, 2u) != 0u) ? 1u + fuzz_below(self, 20u) : 0u;
    board->fault_length = fuzz_below(self, 20u);
}

/* Appends the frame of a command to the bytes on the line. */
static uint32_t command(fuzz_t *self, uint32_t at, const uint8_t *payload, uint32_t count)
{
    uint8_t wire[FRAME_WIRE];
    const uint32_t length = hysgen_frame_make(payload, count, wire);

    for (uint32_t i = 0u; (i < length) && (at + i < FUZZ_LINE); ++i) {
        self->line[at + i] = wire[i];
    }
    return at + length;
}

/* The frames of an image; one in four is damaged, in the image or on the line. Returns the bytes. */
static uint32_t send_image(fuzz_t *self)
{
    const uint32_t number = fuzz_below(self, FUZZ_IMAGES);
    const uint32_t damage = fuzz_below(self, 8u);
    const uint32_t flipped = fuzz_below(self, 8u * IMAGE_BYTES);
    uint32_t end = 0u;

    for (uint32_t offset = 0u; offset < IMAGE_BYTES; offset += LINK_CHUNK) {
        uint8_t payload[6u + LINK_CHUNK] = { LINK_IMAGE, (uint8_t)offset, (uint8_t)(offset & 0xFFu), (uint8_t)(offset >> 8), 0u, 0u };
        uint32_t count = 6u;

        for (uint32_t i = offset; (i < offset + LINK_CHUNK) && (i < IMAGE_BYTES); ++i) {
            payload[count] = fuzz_image[number][i];
            if ((damage == 0u) && (i == flipped / 8u)) {
                payload[count] ^= (uint8_t)(1u << (flipped % 8u));
            }
            count += 1u;
        }
        end = command(self, end, payload, count);
    }
    if (damage == 1u) {
        self->line[fuzz_below(self, end)] ^= (uint8_t)(1u + fuzz_below(self, 255u));
    } else if (damage != 0u) {
        self->sent |= 1u << number;
    }
    return end;
}

/* Commands of any kind and data. */
static uint32_t send_commands(fuzz_t *self)
{
    uint32_t end = 0u;

    for (uint32_t i = 0u; i < 4u; ++i) {
        uint8_t payload[8];

        for (uint32_t j = 0u; j < sizeof payload; ++j) {
            payload[j] = (uint8_t)fuzz_word(self);
        }
        payload[0] = (uint8_t)fuzz_below(self, 10u);
        payload[2] = (uint8_t)fuzz_below(self, 5u);
        end = command(self, end, payload, 2u + fuzz_below(self, 7u));
    }
    return end;
}

/* A table of voltages, most of which the limits allow, and a request to play it. */
static uint32_t send_table(fuzz_t *self)
{
    const float code_per_V = 65535.0f / (BOARD_HIGH_V - BOARD_LOW_V);
    const uint8_t plays[3] = { LINK_REQUEST, 0u, CONTROLLER_RECORD };
    uint8_t payload[6u + LINK_CHUNK] = { LINK_TABLE, 0u, 0u, 0u, 0u, 0u };
    float u_V = fuzz_float(self, 0.0f, 60.0f);

    for (uint32_t i = 0u; i < LINK_CHUNK; i += 2u) {
        const uint32_t code = (uint32_t)((u_V - BOARD_LOW_V) * code_per_V);

        payload[6u + i] = (uint8_t)(code & 0xFFu);
        payload[7u + i] = (uint8_t)((code >> 8) & 0xFFu);
        u_V = number_limited(u_V + self->settings.step_V * fuzz_float(self, -1.01f, 1.01f), BOARD_LOW_V, BOARD_HIGH_V);
    }
    return command(self, command(self, 0u, payload, sizeof payload), plays, sizeof plays);
}

static uint32_t send_noise(fuzz_t *self)
{
    const uint32_t count = 1u + fuzz_below(self, 64u);

    for (uint32_t i = 0u; i < count; ++i) {
        self->line[i] = (uint8_t)fuzz_word(self);
    }
    return count;
}

/* Something from outside: a fault, its end, a request, bytes on the line, power of the store, another kind of reference. */
void fuzz_event(fuzz_t *self)
{
    board_t *board = &self->board;
    uint32_t count = 0u;

    switch (fuzz_below(self, 10u)) {
    case 0u:
        fault(self);
        break;
    case 1u:
        board->fault = HOST_FAULT_NONE;
        break;
    case 2u:
        self->firmware.controller.request = fuzz_below(self, 5u);
        break;
    case 3u:
        count = send_noise(self);
        break;
    case 4u:
        count = send_commands(self);
        break;
    case 5u:
    case 6u:
        count = send_image(self);
        if (fuzz_below(self, 2u) == 0u) {
            /* The power fails while the image is being stored, or later. */
            board->bytes_to_cut = 1u + fuzz_below(self, 2u * BOARD_SLOT_BYTES);
        }
        break;
    case 7u:
        count = send_table(self);
        break;
    default:
        self->kind = fuzz_below(self, 4u);
        break;
    }
    if (count != 0u) {
        board->incoming = self->line;
        board->incoming_count = (count < FUZZ_LINE) ? count : FUZZ_LINE;
        board->outgoing_count = 0u;
    }
}

float fuzz_reference(fuzz_t *self)
{
    const uint32_t k = self->k;
    const float middle = 0.5f * (MODEL_Y_MIN_UM + MODEL_Y_MAX_UM);
    const float slope = (MODEL_Y_MAX_UM - MODEL_Y_MIN_UM) / 300.0f;

    switch (self->kind) {
    case 0u:
        return middle;
    case 1u:
        return middle + slope * ((float)((k % 600u < 300u) ? k % 300u : 300u - k % 300u) - 150.0f);
    case 2u:
        return ((k / 300u) % 2u != 0u) ? MODEL_Y_MIN_UM : MODEL_Y_MAX_UM;
    default:
        return any(self);
    }
}
