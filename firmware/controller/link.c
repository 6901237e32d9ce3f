#include "link.h"

#include "bytes.h"

void hysgen_link_init(link_t *self)
{
    hysgen_frame_init(&self->frame);
    self->length = 0u;
    self->wire_count = 0u;
    self->wire_sent = 0u;
}

static void link_add_byte(link_t *self, uint8_t byte)
{
    if (self->length < FRAME_PAYLOAD) {
        self->answer[self->length] = byte;
        self->length += 1u;
    }
}

void hysgen_link_answer(link_t *self, uint8_t kind, uint8_t number, uint8_t code)
{
    self->length = 0u;
    link_add_byte(self, (uint8_t)(kind | LINK_ANSWER));
    link_add_byte(self, number);
    link_add_byte(self, code);
}

void hysgen_link_add(link_t *self, uint32_t word)
{
    uint8_t bytes[4];

    bytes_put(bytes, word);
    for (uint32_t i = 0u; i < 4u; ++i) {
        link_add_byte(self, bytes[i]);
    }
}

void hysgen_link_add_text(link_t *self, const char *text)
{
    for (uint32_t i = 0u; (text[i] != '\0') && (i < FRAME_PAYLOAD); ++i) {
        link_add_byte(self, (uint8_t)text[i]);
    }
}

void hysgen_link_close(link_t *self)
{
    self->wire_count = hysgen_frame_make(self->answer, self->length, self->wire);
    self->wire_sent = 0u;
}
