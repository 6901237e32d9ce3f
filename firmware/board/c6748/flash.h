/* flash.h: the SPI flash that boots the C6748 and holds the parameter images: Winbond W25Q64JV, 8 MiB, on SPI1. */

#ifndef FLASH_H
#define FLASH_H

#include <stdint.h>

#include "linkage.h"

LINKAGE_BEGIN

/* The boot image begins at 0; the two slots are the last two sectors of 4 KiB. */
#define FLASH_SLOTS  0x007FE000u

/* 1 if a W25Q64 answers. */
uint32_t hysgen_flash_present(void);

LINKAGE_END

#endif
