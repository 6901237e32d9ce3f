/* converters_model.c: the EMIFA bus, an AD7606C-16 on chip select 2 and an AD5547 on chip select 3, and the stage between them. */

#include <math.h>

#include "parts.h"

/* Shortest strobes that this model lets pass, in seconds: assumptions on the slow side, not of the parts' data sheets. */
#define READ_STROBE_S 40e-9
#define WRITE_STROBE_S 40e-9

void converters_reset(board_model_t *model)
{
    model->emifa_config[0] = model->emifa_config[1] = 0u; /* 8 bits: start-up has to set the width */
}

double board_model_output_V(const board_model_t *model)
{
    return model->dac_low_V + model->dac_code / model->dac_per_V;
}

uint32_t adc_busy(const board_model_t *model)
{
    return (uint32_t)(model->ticks < model->adc_done_at);
}

/* RESET, active high: GP0[4]. A pulse of 3 us or more is a full reset. */
void adc_reset_changes(board_model_t *model)
{
    const uint32_t high = board_model_pin(model, 4u);

    if (high != 0u && model->adc_resets == 0u) {
        model->adc_reset_since = model->ticks;
    } else if (high == 0u && model->adc_resets != 0u) {
        model->adc_ready |= (uint32_t)(model->ticks >= model->adc_reset_since + seconds(model, 3e-6));
    }
    model->adc_resets = high;
}

void convst_rises(board_model_t *model, double at)
{
    /* Switched off, the amplifier puts out 0 V. */
    const double u_V = (board_model_pin(model, 2u) != 0u) ? board_model_output_V(model) : 0.0;
    const double y_um = model->plant(model->plant_state, u_V);
    const double code = rint((y_um - model->adc_zero_um) / model->adc_step_um);

    if (model->adc_ready == 0u) {
        violated(model, "the A/D converts without a reset of 3 us after power on");
    }
    if (at < model->adc_done_at) {
        violated(model, "the A/D starts a conversion before the last one has ended");
    }
    model->adc_back = (int32_t)model->dac_code - 32768;
    model->adc_code[0] = model->adc_code[1];
    model->adc_code[1] = (int32_t)fmin(fmax(code, -32768.0), 32767.0);
    model->adc_done_at = at + seconds(model, model->conversion_s);
    model->adc_reads = 0u;
    model->conversions += 1u;
}

/* Whether the bus reaches the part on chip select 2 or 3: pins, width, and a strobe that is long enough. */
static uint32_t reaches(board_model_t *model, uint32_t select, uint32_t writes)
{
    const uint32_t config = model->emifa_config[select - 2u];
    const uint32_t data = (uint32_t)(model->pinmux[8] == 0x11111111u && model->pinmux[9] == 0x11111111u);
    const uint32_t control = muxed(model, 7u, 4u * (select - 2u), 1u) & muxed(model, 7u, (writes != 0u) ? 16u : 20u, 1u);
    const double strobe = ((writes != 0u) ? config >> 20 & 63u : config >> 7 & 63u) + 1.0;
    /* SYSCLK3, from the same source as the core. */
    const double clock_Hz = model->core_ratio * model->crystal_Hz * ((model->pll_active[1] & 31u) + 1.0) / ((model->pll_active[3] & 31u) + 1.0);

    if (strobe / clock_Hz < ((writes != 0u) ? WRITE_STROBE_S : READ_STROBE_S)) {
        violated(model, "a strobe of the bus is too short");
    }
    if ((config & 3u) != 1u) {
        violated(model, "the bus is not 16 bits wide");
    }
    return data & control & (uint32_t)((config & 3u) == 1u);
}

uint32_t bus_load(board_model_t *model, uint32_t address, uint32_t size)
{
    uint32_t word = 0xFFFFu;

    if (size != 2u) {
        violated(model, "the bus is read by another size than 16 bits");
    }
    if (address == 0x60000000u && reaches(model, 2u, 0u)) {
        /* Reads behind BUSY give V1 to V8 in turn; V2 is at the D/A, no other is connected. During a conversion: the one before. */
        const int32_t back = (model->adc_reads == 1u) ? model->adc_back : 0;
        const int32_t code = (model->adc_reads == 0u) ? model->adc_code[adc_busy(model) ? 0 : 1] : back;
        if (adc_busy(model)) {
            violated(model, "the A/D is read while it converts");
        }
        model->adc_reads += 1u;
        word = (uint32_t)code & 0xFFFFu;
    }
    return word;
}

void bus_store(board_model_t *model, uint32_t address, uint32_t size, uint32_t value)
{
    if (size != 2u) {
        violated(model, "the bus is written by another size than 16 bits");
    }
    if (address == 0x62000000u && reaches(model, 3u, 1u)) {
        model->dac_code = value & 0xFFFFu;
        model->dac_writes += 1u;
    }
}
