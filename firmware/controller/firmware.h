/* firmware.h: the image as a whole: boot, interrupt, idle loop. main owns the one instance. */

#ifndef FIRMWARE_H
#define FIRMWARE_H

#include <stdint.h>

#include "board.h"
#include "controller.h"
#include "integrity.h"
#include "link.h"
#include "linkage.h"
#include "store.h"

LINKAGE_BEGIN

typedef struct {
    controller_t controller;
    store_t store;
    image_bench_t bench;
    link_t link;
    integrity_t integrity;
    const settings_t *built_in;  /* settings that the firmware was built with, */
    settings_t settings;         /* those in use since boot, of the image or built in, */
    settings_t next;             /* and those of the next boot */
    volatile float asked_um;         /* reference from the link [um], */
    uint32_t lease;              /* samples without a frame until STOP, 0: none; */
    uint32_t heard;              /* sample of the last frame */
    volatile uint32_t asks;          /* 1: in place of the board's; only the idle loop writes both */
    uint8_t incoming[IMAGE_BYTES];
    uint32_t received;           /* bytes of the image that arrived last */
    uint32_t image_arrives;      /* an image has begun and is not complete */
    volatile uint32_t image_status;  /* STATUS_IMAGE_ bits, sticky until CLEAR; only the idle loop writes them */
    uint32_t cleared;            /* CLEARs that image_status has taken */
    uint32_t image_answer;       /* of the image that arrived last */
    uint32_t image_pending;      /* bytes in `incoming` wait until the controller is off */
    uint32_t commit_answer;      /* of the commit that was finished last */
    uint32_t commits;            /* that made a shadow active */
    uint32_t committing;         /* an attempt is under way, over several calls of hysgen_firmware_idle */
    uint32_t ticked;             /* sample after which hysgen_firmware_idle worked last */
    uint32_t entered;            /* cycle counter at the last interrupt */
    uint32_t cycles_last;        /* of the interrupt */
    uint32_t cycles_most;
    const char *settings_wrong;  /* field that hysgen_settings_check refused at boot, or a null pointer */
    uint32_t selftest;           /* mismatches at boot; 0: this processor computes what was verified */
} firmware_t;

/* Self-test, parameters and settings from the store, everything off. `settings`: where the store has none. The interrupt may be enabled afterwards. */
void hysgen_firmware_boot(firmware_t *self, board_t *board, const settings_t *settings, const image_owner_t *owner);

/* Every 20 us. */
void hysgen_firmware_interrupt(firmware_t *self, board_t *board);

/* STATUS_ bits of the controller and of the parameter images. */
uint32_t hysgen_firmware_status(const firmware_t *self);

/* One pass of the idle loop: executes commands of the link, takes parameter images, calls the model's commit. */
void hysgen_firmware_idle(firmware_t *self, board_t *board);

/* For the handler of exceptions and NMI: amplifier off, at any time. The D/A keeps its voltage: in one step to another a stage rings. */
void hysgen_firmware_panic(const firmware_t *self, board_t *board);

LINKAGE_END

#endif
