/* console.h: text on UART2 between reset and the first interrupt, for a terminal: 115200 bit/s, 8N1. docs/firmware.md lists every line.
 *
 * The functions wait for the UART, so nothing may call them once interrupts serve the line. A zero byte ends the text: the client of
 * the link drops it as a damaged frame. */

#ifndef CONSOLE_H
#define CONSOLE_H

#include <stdint.h>

#include "linkage.h"

LINKAGE_BEGIN

void hysgen_console_text(const char *text);

/* A number in decimal digits, and as eight hexadecimal ones. */
void hysgen_console_number(uint32_t number);
void hysgen_console_word(uint32_t word);

/* End of the text. */
void hysgen_console_end(void);

LINKAGE_END

#endif
