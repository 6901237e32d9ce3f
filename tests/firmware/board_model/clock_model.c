/* clock_model.c: PLL0 and the power and sleep controllers of the C6748. */

#include <math.h>
#include <string.h>

#include "parts.h"

#define PLL_ENABLE 0x001u
#define PLL_POWER_DOWN 0x002u
#define PLL_RELEASED 0x008u
#define PLL_DISABLE 0x010u
#define PLL_SOURCE 0x020u

double sysclk2_ratio(const board_model_t *model)
{
    const double core_divider = (model->pll_active[1] & 31u) + 1.0, own_divider = (model->pll_active[2] & 31u) + 1.0;
    return model->core_ratio * core_divider / own_divider;
}

static uint32_t pll_locked(const board_model_t *model)
{
    const double lock = 2000.0 / sqrt(model->pll_multiplier + 1.0); /* SPRS590, PLL lock time, in periods of the crystal */
    const uint32_t ready = PLL_POWER_DOWN | PLL_DISABLE | PLL_RELEASED;
    return (uint32_t)((model->pll_control & ready) == PLL_RELEASED && model->ticks >= model->pll_lock_since + lock);
}

static void set_core_clock(board_model_t *model)
{
    model->core_ratio = 1.0;
    if ((model->pll_control & (PLL_ENABLE | PLL_SOURCE)) == PLL_ENABLE) {
        const double output = (model->pll_multiplier + 1.0) / ((model->pll_prediv & 31u) + 1.0);
        const double output_Hz = model->crystal_Hz * output;
        if (!pll_locked(model)) {
            violated(model, "PLL0 drives the core before it has locked");
        }
        if (output_Hz < 300e6 || output_Hz > 600e6) { /* Linux, drivers/clk/davinci/pll-da850.c: pllout_min_rate, pllout_max_rate */
            violated(model, "PLL0's output is not within 300 .. 600 MHz");
        }
        model->core_ratio = output / ((model->pll_postdiv & 31u) + 1.0) / ((model->pll_active[1] & 31u) + 1.0);
        if (model->core_ratio * model->crystal_Hz > 375.1e6) {
            violated(model, "the core runs above 375 MHz");
        }
        const uint32_t core = (model->pll_active[1] & 31u) + 1u;
        if ((model->pll_active[2] & 31u) + 1u != 2u * core || (model->pll_active[4] & 31u) + 1u != 4u * core) {
            violated(model, "SYSCLK2 and SYSCLK4 are not a half and a quarter of SYSCLK1");
        }
    }
}

uint32_t pll_load(const board_model_t *model, uint32_t offset)
{
    switch (offset) {
    case 0xE4u: return (model->reset_under_power == 0u) ? 1u : 2u; /* RSTYPE: POR, XWRST */
    case 0x100u: return model->pll_control;
    case 0x110u: return model->pll_multiplier;
    case 0x114u: return model->pll_prediv;
    case 0x118u: return model->pll_divider[1];
    case 0x11Cu: return model->pll_divider[2];
    case 0x120u: return model->pll_divider[3];
    case 0x128u: return model->pll_postdiv;
    case 0x13Cu: return (uint32_t)(model->ticks < model->pll_go_until);
    case 0x160u: case 0x164u: case 0x168u: case 0x16Cu: return model->pll_divider[4u + (offset - 0x160u) / 4u];
    default: return 0u;
    }
}

void pll_store(board_model_t *model, uint32_t offset, uint32_t value)
{
    if ((model->cfgchip0 & 0x10u) != 0u) {
        violated(model, "PLL0 written while CFGCHIP0 locks it");
        return;
    }
    switch (offset) {
    case 0x100u:
        if ((value & PLL_RELEASED) != 0u && (model->pll_control & PLL_RELEASED) == 0u) {
            if (model->ticks < model->pll_reset_since + seconds(model, 1e-6)) {
                violated(model, "PLL0 was in reset for less than 1 us");
            }
            model->pll_lock_since = model->ticks;
        } else if ((value & PLL_RELEASED) == 0u && (model->pll_control & PLL_RELEASED) != 0u) {
            model->pll_reset_since = model->ticks;
        }
        model->pll_control = value;
        set_core_clock(model);
        break;
    case 0x110u:
        model->pll_multiplier = value & 31u;
        model->pll_lock_since = model->ticks;
        set_core_clock(model);
        break;
    case 0x114u: model->pll_prediv = value; break;
    case 0x118u: model->pll_divider[1] = value; break;
    case 0x11Cu: model->pll_divider[2] = value; break;
    case 0x120u: model->pll_divider[3] = value; break;
    case 0x128u: model->pll_postdiv = value; break;
    case 0x138u:
        if ((value & 1u) != 0u) {
            memcpy(model->pll_active, model->pll_divider, sizeof model->pll_active);
            model->pll_go_until = (model->pll_fails != 0u) ? NEVER : model->ticks + 8.0;
            set_core_clock(model);
        }
        break;
    case 0x160u: case 0x164u: case 0x168u: case 0x16Cu: model->pll_divider[4u + (offset - 0x160u) / 4u] = value; break;
    default: violated(model, "an unknown register of PLL0 written"); break;
    }
}

uint32_t psc_load(board_model_t *model, uint32_t psc, uint32_t offset)
{
    const uint32_t busy = (uint32_t)(model->ticks < model->power_until[psc]);

    if (busy == 0u) {
        memcpy(model->power_state[psc], model->power_next[psc], sizeof model->power_state[psc]);
    }
    if (offset == 0x128u) {
        return busy;
    }
    if (offset >= 0x800u && offset < 0x880u) {
        return model->power_state[psc][(offset - 0x800u) / 4u] & 0x3Fu;
    }
    return (offset >= 0xA00u && offset < 0xA80u) ? model->power_next[psc][(offset - 0xA00u) / 4u] : 0u;
}

/* A command moves all modules to their next state. As on silicon a next state without a command changes nothing. */
void psc_store(board_model_t *model, uint32_t psc, uint32_t offset, uint32_t value)
{
    if (offset >= 0xA00u && offset < 0xA80u) {
        (void)psc_load(model, psc, 0x128u);
        model->power_next[psc][(offset - 0xA00u) / 4u] = value & 0x1Fu;
        model->power_until[psc] = NEVER;
    } else if (offset == 0x120u) {
        model->power_until[psc] = (model->power_fails != 0u) ? NEVER : model->ticks + 16.0;
    } else {
        violated(model, "an unknown register of a PSC written");
    }
}

uint32_t powered(board_model_t *model, uint32_t psc, uint32_t module)
{
    (void)psc_load(model, psc, 0x128u);
    if ((model->power_state[psc][module] & 0x1Fu) != 3u) {
        violated(model, "a device is used without power");
        return 0u;
    }
    return 1u;
}

void clock_reset(board_model_t *model)
{
    memset(model->power_next, 0, sizeof model->power_next);
    memset(model->power_state, 0, sizeof model->power_state);
    model->pll_control = PLL_SOURCE | PLL_DISABLE | PLL_POWER_DOWN; /* so that start-up has to take every step */
    model->pll_multiplier = model->pll_prediv = model->pll_postdiv = 0u;
    for (uint32_t i = 0u; i < 8u; ++i) {
        model->pll_divider[i] = model->pll_active[i] = 0u;
    }
    model->pll_reset_since = model->pll_lock_since = model->ticks;
    model->pll_go_until = model->power_until[0] = model->power_until[1] = 0.0;
    model->core_ratio = 1.0;
}
