/* link.h: commands from a line of bytes, and their answers; docs/firmware.md has the table.
 *
 * Each frame of frame.h is a command: kind, a number that the answer repeats, data. Its answer is a frame too: kind + LINK_ANSWER,
 * the number, LINK_ code, data. Words are 32 bits, the low byte first; float32 as its bits. */

#ifndef LINK_H
#define LINK_H

#include <stdint.h>

#include "frame.h"
#include "linkage.h"

LINKAGE_BEGIN

#define LINK_VERSION    6u
#define LINK_STATUS     1u  /* no data; answer: LINK_STATUS_WORDS words, see firmware.c */
#define LINK_REQUEST    2u  /* one byte: CONTROLLER_START, _STOP, _CLEAR or _RECORD */
#define LINK_REFERENCE  3u  /* a word: reference [um] from now on, in place of the board's; none: the board's again. A second
                             * word: samples without any frame until STOP */
#define LINK_IMAGE      4u  /* a word: offset in the image; then up to LINK_CHUNK bytes of it. Offset 0 begins an image */
#define LINK_IDENTIFY   5u  /* no data; answer: LINK_IDENTITY_WORDS words, then the model's name */
#define LINK_TABLE      6u  /* a word: offset in bytes; then up to LINK_CHUNK bytes of its codes, at rest. Offset 0 begins a table */
#define LINK_RECORD     7u  /* a word: offset in bytes; answer: samples played, then LINK_CHUNK bytes of codes, see play.h */
#define LINK_TRACE      8u  /* a word: offset in bytes; answer: samples traced, then LINK_CHUNK bytes of words, see trace.h */
#define LINK_KEPT       9u  /* a word: offset in bytes; answer: how many there are, then LINK_CHUNK bytes: the words of an image from
                             * IMAGE_HEADER to IMAGE_CRC, with which the next start and the next boot begin. At rest */
#define LINK_ANSWER     0x80u

#define LINK_DONE       0u
#define LINK_UNKNOWN    1u  /* no such command */
#define LINK_LENGTH     2u  /* too few or too many data */
#define LINK_VALUE      3u  /* data out of range or order */

#define LINK_CHUNK           64u
#define LINK_STATUS_WORDS    21u
#define LINK_IDENTITY_WORDS  23u

typedef struct {
    frame_t frame;
    uint8_t answer[FRAME_PAYLOAD];
    uint32_t length;         /* of the answer */
    uint8_t wire[FRAME_WIRE];
    uint32_t wire_count;     /* bytes of the answer's frame, */
    uint32_t wire_sent;      /* and how many of them are on the line */
} link_t;

void hysgen_link_init(link_t *self);

/* Begin the answer to a command. */
void hysgen_link_answer(link_t *self, uint8_t kind, uint8_t number, uint8_t code);

/* Append a word to the answer; what does not fit is left out. */
void hysgen_link_add(link_t *self, uint32_t word);

/* Append text to the answer, without its end. */
void hysgen_link_add_text(link_t *self, const char *text);

/* Make the frame of the answer. */
void hysgen_link_close(link_t *self);

LINKAGE_END

#endif
