/* chip_model.c: pins, timers and interrupt of the C6748, and which device an address belongs to.
 *
 * Stricter than silicon of revision 2, whose SYSCFG registers are always unlocked (SPRUH79C, 10.2.2): PINMUX needs both KICK words. */

#include <string.h>

#include "parts.h"

void violated(board_model_t *model, const char *text)
{
    uint32_t i = 0u;

    model->violations += 1u;
    while (i < 16u && model->violation[i] != 0 && strcmp(model->violation[i], text) != 0) {
        ++i;
    }
    if (i < 16u) {
        model->violation[i] = text;
    }
}

uint32_t muxed(const board_model_t *model, uint32_t pinmux, uint32_t lowest_bit, uint32_t function)
{
    return (uint32_t)((model->pinmux[pinmux] >> lowest_bit & 15u) == function);
}

double seconds(const board_model_t *model, double duration_s)
{
    return duration_s * model->crystal_Hz;
}

/* ---- pins ---- */

static const uint32_t gpio_mux_bit[5] = { 28u, 24u, 20u, 16u, 12u }; /* GP0[0] to GP0[4] in PINMUX1 */

uint32_t board_model_pin(const board_model_t *model, uint32_t pin)
{
    const uint32_t drives = (uint32_t)((model->gpio_direction >> pin & 1u) == 0u) & muxed(model, 1u, gpio_mux_bit[pin], 8u);
    return drives & model->gpio_output >> pin;
}

static uint32_t gpio_load(const board_model_t *model, uint32_t offset)
{
    const uint32_t outside = (model->input_pins & 0xFFFFu & ~8u) | adc_busy(model) << 3;

    switch (offset) {
    case 0x10u: return model->gpio_direction;
    case 0x14u: case 0x18u: case 0x1Cu: return model->gpio_output;
    case 0x20u: return (outside & model->gpio_direction) | (model->gpio_output & ~model->gpio_direction);
    default: return 0u;
    }
}

static void gpio_store(board_model_t *model, uint32_t offset, uint32_t value)
{
    switch (offset) {
    case 0x10u: model->gpio_direction = value; break;
    case 0x14u: model->gpio_output = value; break;
    case 0x18u: model->gpio_output |= value; break;
    case 0x1Cu: model->gpio_output &= ~value; break;
    default: violated(model, "an unknown register of GPIO written"); break;
    }
    adc_reset_changes(model);
}

static uint32_t syscfg_load(const board_model_t *model, uint32_t offset)
{
    if (offset >= 0x120u && offset < 0x170u) {
        return model->pinmux[(offset - 0x120u) / 4u];
    }
    return (offset == 0x38u || offset == 0x3Cu) ? model->kick[(offset - 0x38u) / 4u] : (offset == 0x17Cu) ? model->cfgchip0 : 0u;
}

static void syscfg_store(board_model_t *model, uint32_t offset, uint32_t value)
{
    if (offset == 0x38u || offset == 0x3Cu) {
        model->kick[(offset - 0x38u) / 4u] = value;
    } else if (model->kick[0] != 0x83E70B13u || model->kick[1] != 0x95A4F1E0u) {
        violated(model, "SYSCFG written while locked");
    } else if (offset >= 0x120u && offset < 0x170u) {
        model->pinmux[(offset - 0x120u) / 4u] = value;
    } else if (offset == 0x17Cu) {
        model->cfgchip0 = value;
    } else {
        violated(model, "an unknown register of SYSCFG written");
    }
}

/* ---- timers ---- */

static double timer_period(const board_model_t *model, uint32_t timer)
{
    const double high = (timer == 1u) ? 4294967296.0 * model->timer_period[1][1] : 0.0;
    return high + model->timer_period[timer][0] + 1.0;
}

static uint32_t sampling(const board_model_t *model)
{
    const uint32_t unchained = (uint32_t)((model->timer_tgcr[0] & 0x0Du) == 0x05u);
    return unchained & (uint32_t)((model->timer_tcr[0] & 0xC0u) == 0x80u);
}

static uint32_t timer_load(const board_model_t *model, uint32_t timer, uint32_t offset)
{
    switch (offset) {
    case 0x10u: return (uint32_t)(model->ticks - model->timer_from[timer]);
    case 0x18u: case 0x1Cu: return model->timer_period[timer][(offset - 0x18u) / 4u];
    case 0x20u: return model->timer_tcr[timer];
    case 0x24u: return model->timer_tgcr[timer];
    default: return 0u;
    }
}

static void watchdog_word(board_model_t *model, uint32_t value)
{
    const uint32_t key = value >> 16;

    if ((value & 0x4000u) == 0u || (model->timer_tgcr[1] & 0x0Fu) != 0x0Bu) {
        violated(model, "a word for the watchdog without WDEN or outside watchdog mode");
    } else if (key == 0xA5C6u) {
        model->dog |= 1u;
    } else if (key == 0xDA7Eu && (model->dog & 1u) != 0u) {
        model->dog_served += (uint64_t)(model->dog == 3u);
        model->dog = 2u;
        model->timer_from[1] = model->ticks;
    } else if ((model->dog & 2u) != 0u) {
        model->dog_bitten = 1u;
    } else {
        model->dog = 0u;
    }
}

static void timer_store(board_model_t *model, uint32_t timer, uint32_t offset, uint32_t value)
{
    if (timer == 1u && offset == 0x28u) {
        watchdog_word(model, value);
        return;
    }
    if (timer == 1u && model->dog >= 2u) {
        violated(model, "the timer of an active watchdog written");
        return;
    }
    switch (offset) {
    case 0x10u: case 0x14u: model->timer_from[timer] = model->ticks - value; break;
    case 0x18u: case 0x1Cu: model->timer_period[timer][(offset - 0x18u) / 4u] = value; break;
    case 0x20u:
        model->timer_tcr[timer] = value;
        model->timer_from[timer] = model->ticks;
        break;
    case 0x24u: model->timer_tgcr[timer] = value; break;
    case 0x44u: model->timer_intctl = (timer == 0u) ? value : model->timer_intctl; break;
    default: violated(model, "an unknown register of a timer written"); break;
    }
}

uint32_t device_events(void *devices, uint64_t cycle, uint64_t *next)
{
    board_model_t *model = devices;
    uint32_t flags = 0u;
    double due = model->ticks + 25000.0;

    pass_time(model, cycle);
    if (sampling(model)) {
        const double period = timer_period(model, 0u);
        if (model->ticks >= model->timer_from[0] + period) {
            model->timer_from[0] += period;
            model->timer_level ^= 1u;
            model->interrupts += 1u;
            flags |= ((model->intmux1 & 0x7Fu) == 4u && (model->timer_intctl & 1u) != 0u) ? 0x10u : 0u; /* T64P0_TINT12 is event 4 */
            /* In pulse mode the pin rises at each match, in clock mode at every second one. */
            if (muxed(model, 4u, 0u, 2u) && ((model->timer_tcr[0] & 8u) == 0u || model->timer_level != 0u)) {
                convst_rises(model, model->timer_from[0]);
            }
        }
        due = model->timer_from[0] + period;
    }
    if (model->dog >= 2u) {
        const double bites = model->timer_from[1] + timer_period(model, 1u);
        model->dog_bitten |= (uint32_t)(model->ticks >= bites);
        due = (bites < due) ? bites : due;
    }
    *next = cycle + 1u + (uint64_t)(((due > model->ticks) ? due - model->ticks : 0.0) * model->core_ratio);
    return flags | model->dog_bitten;
}

/* ---- addresses ---- */

void pass_time(board_model_t *model, uint64_t cycle)
{
    model->ticks += (double)(cycle - model->cycle) / model->core_ratio;
    model->cycle = cycle;
}

uint64_t device_load(void *devices, uint64_t cycle, uint32_t address, uint32_t size)
{
    board_model_t *model = devices;
    const uint32_t offset = address & 0xFFFu;

    pass_time(model, cycle);
    if (address >> 28 == 6u) {
        return powered(model, 0u, 3u) ? ((address >> 24 == 0x68u) ? model->emifa_config[(offset >> 2 & 1u)] : bus_load(model, address, size)) : 0u;
    }
    if (address >> 17 == 0x4000u && size == 2u) {
        return model->shared[(address & 0x1FFFFu) >> 1];
    }
    if (size != 4u) {
        violated(model, "a register read by another size than 32 bits");
    }
    switch (address >> 12) {
    case 0x01C14u: return syscfg_load(model, offset);
    case 0x01C11u: return pll_load(model, offset);
    case 0x01C10u: return psc_load(model, 0u, offset);
    case 0x01E27u: return psc_load(model, 1u, offset);
    case 0x01E26u: return powered(model, 1u, 3u) ? gpio_load(model, offset) : 0u;
    case 0x01D0Du: return powered(model, 1u, 13u) ? uart_load(model, offset) : 0u;
    case 0x01F0Eu: return powered(model, 1u, 10u) ? spi_load(model, offset) : 0u;
    case 0x01C20u: case 0x01C21u: return timer_load(model, address >> 12 & 1u, offset);
    case 0x01800u: return (offset == 0x104u) ? model->intmux1 : 0u;
    default: violated(model, "an address without a device read"); return 0u;
    }
}

void device_store(void *devices, uint64_t cycle, uint32_t address, uint32_t size, uint64_t wide)
{
    board_model_t *model = devices;
    const uint32_t offset = address & 0xFFFu, value = (uint32_t)wide;

    pass_time(model, cycle);
    if (address >> 28 == 6u) {
        if (powered(model, 0u, 3u)) {
            if (address >> 24 == 0x68u) {
                model->emifa_config[offset >> 2 & 1u] = value;
            } else {
                bus_store(model, address, size, value);
            }
        }
        return;
    }
    if (address >> 17 == 0x4000u && size == 2u) {
        model->shared[(address & 0x1FFFFu) >> 1] = (uint16_t)value;
        return;
    }
    if (size != 4u) {
        violated(model, "a register written by another size than 32 bits");
    }
    switch (address >> 12) {
    case 0x01C14u: syscfg_store(model, offset, value); break;
    case 0x01C11u: pll_store(model, offset, value); break;
    case 0x01C10u: psc_store(model, 0u, offset, value); break;
    case 0x01E27u: psc_store(model, 1u, offset, value); break;
    case 0x01E26u: if (powered(model, 1u, 3u)) { gpio_store(model, offset, value); } break;
    case 0x01D0Du: if (powered(model, 1u, 13u)) { uart_store(model, offset, value); } break;
    case 0x01F0Eu: if (powered(model, 1u, 10u)) { spi_store(model, offset, value); } break;
    case 0x01C20u: case 0x01C21u: timer_store(model, address >> 12 & 1u, offset, value); break;
    case 0x01800u:
        model->intmux1 = (offset == 0x104u) ? value : model->intmux1;
        model->expmask3 = (offset == 0x0CCu) ? value : model->expmask3;
        break;
    default: violated(model, "an address without a device written"); break;
    }
}

void board_model_reset(board_model_t *model)
{
    model->reset_under_power += (uint32_t)(model->cycle != 0u);
    model->cycle = 0u;
    memset(model->kick, 0, sizeof model->kick);
    memset(model->pinmux, 0, sizeof model->pinmux);
    memset(model->timer_tgcr, 0, sizeof model->timer_tgcr);
    memset(model->timer_tcr, 0, sizeof model->timer_tcr);
    memset(model->timer_period, 0, sizeof model->timer_period);
    model->cfgchip0 = 0u;
    clock_reset(model);
    model->gpio_direction = 0xFFFFFFFFu;
    model->gpio_output = model->intmux1 = model->timer_intctl = model->dog = model->dog_bitten = 0u;
    model->timer_from[0] = model->timer_from[1] = model->ticks;
    adc_reset_changes(model);
    uart_reset(model);
    spi_reset(model);
    converters_reset(model);
}
