/* crc32.h: the CRC-32 of Ethernet and zlib (polynomial 0x04C11DB7, reflected). It finds every single flipped bit, every
 * burst of up to 32 bits, and in images of these sizes every three flipped bits. */

#ifndef CRC32_H
#define CRC32_H

#include <stdint.h>

#include "linkage.h"

LINKAGE_BEGIN

uint32_t hysgen_crc32(const uint8_t *bytes, uint32_t count);

LINKAGE_END

#endif
