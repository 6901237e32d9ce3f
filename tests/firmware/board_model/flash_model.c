/* flash_model.c: SPI1 as the drivers use it, and a W25Q64JV on its chip select 0: 24-bit addresses, pages that wrap, bits that only fall, nothing
 * but the status while it is busy. */

#include "parts.h"

#define SIZE 0x800000u
#define EMPTY 0x80000000u
#define FULL 0x20000000u
#define HOLD 0x10000000u
#define PAUSE 0x04000000u
#define DESELECTED_S 50e-9 /* tSHSL of the W25Q family between a write or erase and the next instruction */

void spi_reset(board_model_t *model)
{
    model->spi_gcr0 = model->spi_gcr1 = model->spi_pc0 = model->spi_fmt0 = model->spi_delay = model->spi_def = 0u;
    model->spi_buffer = EMPTY;
    model->spi_arriving = 0u;
    model->spi_done_at = NEVER;
    model->flash_selected = model->flash_count = 0u;
}

static uint32_t busy(const board_model_t *model)
{
    return (uint32_t)(model->ticks < model->flash_busy_until);
}

static void erase_or_program(board_model_t *model)
{
    const uint32_t erases = (uint32_t)(model->flash_instruction == 0x20u);

    if (model->flash_enabled == 0u) {
        violated(model, "the flash ignores an instruction without write enable");
    } else if (erases != 0u) {
        for (uint32_t i = 0u; i < 4096u; ++i) {
            model->flash[((model->flash_address & ~4095u) + i) % SIZE] = 0xFFu;
        }
        model->flash_erased += 1u;
        model->flash_busy_until = model->ticks + seconds(model, model->erase_s);
    } else {
        for (uint32_t i = 0u; i < 256u; ++i) {
            if (model->flash_latched[i] != 0u) {
                model->flash[((model->flash_address & ~255u) + i) % SIZE] &= model->flash_page[i];
            }
        }
        model->flash_programmed += 1u;
        model->flash_busy_until = model->ticks + seconds(model, model->program_s);
    }
    model->flash_enabled = 0u;
}

/* Chip select 0 rises: what the instruction asked for happens now. */
static void deselected(board_model_t *model)
{
    const uint32_t instruction = model->flash_instruction, count = model->flash_count;

    if (model->flash_selected != 0u && count != 0u) {
        if (busy(model) && instruction != 0x05u) {
            violated(model, "the flash ignores an instruction while it is busy");
        } else if (instruction == 0x06u && count == 1u) {
            model->flash_enabled = 1u;
        } else if ((instruction == 0x20u && count == 4u) || (instruction == 0x02u && count > 4u)) {
            erase_or_program(model);
        } else if (instruction != 0x03u && instruction != 0x05u && instruction != 0x9Fu) {
            violated(model, "the flash does not know an instruction, or gets too few or too many bytes for it");
        }
    }
    model->flash_selected = 0u;
    model->flash_count = 0u;
}

static uint8_t exchanged(board_model_t *model, uint8_t byte)
{
    static const uint8_t identity[3] = { 0xEFu, 0x40u, 0x17u };
    const uint32_t at = model->flash_count, instruction = model->flash_instruction;
    uint8_t answer = 0xFFu;

    model->flash_selected = 1u;
    model->flash_count += 1u;
    if (at == 0u) {
        model->flash_instruction = byte;
        model->flash_address = 0u;
        for (uint32_t i = 0u; i < 256u; ++i) {
            model->flash_latched[i] = 0u;
        }
    } else if (instruction == 0x05u) {
        answer = (uint8_t)(busy(model) | model->flash_enabled << 1);
    } else if (busy(model)) {
        answer = 0xFFu;
    } else if (instruction == 0x9Fu) {
        answer = identity[(at - 1u) % 3u];
    } else if (at < 4u) {
        model->flash_address = (model->flash_address << 8 | byte) % SIZE;
    } else if (instruction == 0x03u) {
        answer = model->flash[(model->flash_address + at - 4u) % SIZE];
    } else if (instruction == 0x02u) {
        const uint32_t place = (model->flash_address + at - 4u) & 255u;
        model->flash_page[place] = byte;
        model->flash_latched[place] = 1u;
    }
    return answer;
}

/* The byte that is on its way arrives when its last bit has passed. */
static void arrive(board_model_t *model)
{
    if (model->ticks >= model->spi_done_at) {
        model->spi_buffer = model->spi_arriving;
        model->spi_done_at = NEVER;
    }
}

static void sent(board_model_t *model, uint32_t value)
{
    const uint32_t wired = muxed(model, 5u, 20u, 1u) & muxed(model, 5u, 16u, 1u) & muxed(model, 5u, 8u, 1u) & muxed(model, 5u, 4u, 1u);
    const uint32_t prescale = model->spi_fmt0 >> 8 & 0xFFu;
    const uint32_t set_up = (uint32_t)(model->spi_gcr0 == 1u && model->spi_gcr1 == 0x01000003u && model->spi_pc0 == 0xE01u);
    /* Mode 0: data valid at the first edge (PHASE 1), clock low at rest; 8 bits, the most significant first; select low when active. */
    const uint32_t format = (uint32_t)((model->spi_fmt0 & 0x0033001Fu) == 0x00010008u && (model->spi_def & 1u) == 1u && (value >> 16 & 1u) == 0u);

    if (set_up == 0u) {
        violated(model, "SPI1 is used before it is set up");
        return;
    }
    if (model->spi_done_at != NEVER) {
        violated(model, "SPI1 gets a byte while it sends another");
    }
    if (sysclk2_ratio(model) * model->crystal_Hz / (prescale + 1.0) > 50e6) {
        violated(model, "SPI1 is faster than the flash reads");
    }
    /* Behind a byte without HOLD the select is high for two clocks of the module, and FMT0's WDELAY more with WDEL. */
    if ((value & HOLD) == 0u
        && (2.0 + (((value & PAUSE) != 0u) ? model->spi_fmt0 >> 24 & 63u : 0u)) / (sysclk2_ratio(model) * model->crystal_Hz) < DESELECTED_S) {
        violated(model, "the flash is deselected for less than 50 ns");
    }
    model->spi_arriving = 0xFFu;
    if (wired != 0u && format != 0u && model->flash_absent == 0u) {
        model->spi_arriving = exchanged(model, (uint8_t)value);
        if ((value & HOLD) == 0u) {
            deselected(model);
        }
    }
    model->spi_done_at = model->ticks + 8.0 * (prescale + 1.0) / sysclk2_ratio(model);
    model->spi_buffer = EMPTY | FULL;
}

uint32_t spi_load(board_model_t *model, uint32_t offset)
{
    uint32_t value = 0u;

    arrive(model);
    switch (offset) {
    case 0x00u: return model->spi_gcr0;
    case 0x04u: return model->spi_gcr1;
    case 0x14u: return model->spi_pc0;
    case 0x40u:
        value = model->spi_buffer;
        model->spi_buffer = EMPTY | (value & FULL);
        return value;
    case 0x4Cu: return model->spi_def;
    case 0x50u: return model->spi_fmt0;
    default: return 0u;
    }
}

void spi_store(board_model_t *model, uint32_t offset, uint32_t value)
{
    arrive(model);
    switch (offset) {
    case 0x00u: model->spi_gcr0 = value; break;
    case 0x04u: model->spi_gcr1 = value; break;
    case 0x14u: model->spi_pc0 = value; break;
    case 0x3Cu: sent(model, value); break;
    case 0x48u: model->spi_delay = value; break;
    case 0x4Cu: model->spi_def = value; break;
    case 0x50u: model->spi_fmt0 = value; break;
    default: violated(model, "an unknown register of SPI1 written"); break;
    }
}
