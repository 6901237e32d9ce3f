#include "frame.h"

#include "bytes.h"
#include "crc32.h"

#define FRAME_CRC 4u

void hysgen_frame_init(frame_t *self)
{
    self->count = 0u;
    self->left = 0u;
    self->zero = 0u;
    self->broken = 0u;
}

static void frame_put(frame_t *self, uint8_t byte)
{
    if (self->count < FRAME_BYTES) {
        self->bytes[self->count] = byte;
        self->count += 1u;
    } else {
        self->broken = 1u;
    }
}

/* Length of the payload of the frame that has ended, 0 if it is not good. */
static uint32_t frame_ended(const frame_t *self)
{
    uint32_t count = 0u;

    if ((self->broken == 0u) && (self->left == 0u) && (self->count > FRAME_CRC)) {
        const uint32_t length = self->count - FRAME_CRC;

        if (bytes_word(&self->bytes[length]) == hysgen_crc32(self->bytes, length)) {
            count = length;
        }
    }
    return count;
}

uint32_t hysgen_frame_take(frame_t *self, uint8_t byte)
{
    uint32_t count = 0u;

    if (byte == 0u) {
        count = frame_ended(self);
        hysgen_frame_init(self);
    } else if (self->left == 0u) {
        if (self->zero != 0u) {
            frame_put(self, 0u);
        }
        self->left = (uint32_t)byte - 1u;
        /* A code byte of 255 would stand for none, but its block is longer than a frame. */
        self->zero = 1u;
    } else {
        frame_put(self, byte);
        self->left -= 1u;
    }
    return count;
}

uint32_t hysgen_frame_make(const uint8_t *payload, uint32_t count, uint8_t wire[FRAME_WIRE])
{
    const uint32_t length = (count < FRAME_PAYLOAD) ? count : FRAME_PAYLOAD;
    uint8_t crc[FRAME_CRC];
    uint32_t code_at = 0u;
    uint32_t code = 1u;
    uint32_t end = 1u;

    bytes_put(crc, hysgen_crc32(payload, length));
    for (uint32_t i = 0u; i < length + FRAME_CRC; ++i) {
        const uint8_t byte = (i < length) ? payload[i] : crc[i - length];

        if (byte == 0u) {
            wire[code_at] = (uint8_t)code;
            code_at = end;
            code = 1u;
        } else {
            wire[end] = byte;
            code += 1u;
        }
        end += 1u;
    }
    wire[code_at] = (uint8_t)code;
    wire[end] = 0u;
    return end + 1u;
}
