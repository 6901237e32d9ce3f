/* uart_model.c: UART2 with its FIFOs of 16 bytes, and an adapter of 115200 bit/s at the other end. A line whose rates differ by more than 3 %
 * damages every byte. */

#include "parts.h"

#define LINE_HZ 115200.0

void uart_reset(board_model_t *model)
{
    model->uart_ier = model->uart_fcr = model->uart_lcr = model->uart_mcr = model->uart_divisor = model->uart_power = model->uart_mdr = 0u;
    model->uart_received_count = model->uart_sending_count = model->uart_overrun = 0u;
    model->uart_sent_at = model->line_next_at = 0.0;
}

/* Periods of the crystal that UART2 takes for a byte of ten bits; 0 if it is not set up. */
static double byte_ticks(const board_model_t *model)
{
    const double bits = 10.0 * 16.0 * model->uart_divisor;
    return ((model->uart_lcr & 0x7Fu) == 3u && model->uart_mdr == 0u) ? bits / sysclk2_ratio(model) : 0.0;
}

static uint8_t across(const board_model_t *model, uint8_t byte)
{
    const double own = byte_ticks(model), theirs = seconds(model, 10.0 / LINE_HZ);
    return (own > 0.97 * theirs && own < 1.03 * theirs) ? byte : (uint8_t)(byte ^ 0xA5u);
}

/* What was sent and received until now. */
static void pass(board_model_t *model)
{
    const double own = byte_ticks(model), theirs = seconds(model, 10.0 / LINE_HZ);

    while (model->uart_sending_count != 0u && own > 0.0 && (model->uart_power & 0x4000u) != 0u && model->ticks >= model->uart_sent_at) {
        if (muxed(model, 4u, 20u, 2u) && model->line_out_count < sizeof model->line_out) {
            model->line_out[model->line_out_count] = across(model, model->uart_sending[0]);
            model->line_out_count += 1u;
        }
        model->uart_sending_count -= 1u;
        for (uint32_t i = 0u; i < model->uart_sending_count; ++i) {
            model->uart_sending[i] = model->uart_sending[i + 1u];
        }
        model->uart_sent_at += own;
    }
    while (model->line_in_first != model->line_in_last && model->ticks >= model->line_next_at) {
        const uint8_t byte = model->line_in[model->line_in_first % sizeof model->line_in];
        model->line_in_first += 1u;
        model->line_next_at = ((model->line_next_at == 0.0) ? model->ticks : model->line_next_at) + theirs;
        if (own > 0.0 && (model->uart_power & 0x2000u) != 0u) {
            if (model->uart_received_count < 16u) {
                model->uart_received[model->uart_received_count] = across(model, byte);
                model->uart_received_count += 1u;
            } else {
                model->uart_overrun = 1u;
                violated(model, "UART2 has lost a byte");
            }
        }
    }
    if (model->line_in_first == model->line_in_last) {
        model->line_next_at = 0.0;
    }
}

uint32_t uart_load(board_model_t *model, uint32_t offset)
{
    uint32_t value = 0u;

    pass(model);
    switch (offset) {
    case 0x00u:
        if (model->uart_received_count != 0u) {
            value = model->uart_received[0];
            model->uart_received_count -= 1u;
            for (uint32_t i = 0u; i < model->uart_received_count; ++i) {
                model->uart_received[i] = model->uart_received[i + 1u];
            }
        }
        return value;
    case 0x04u: return model->uart_ier;
    case 0x0Cu: return model->uart_lcr;
    case 0x14u:
        value = (uint32_t)(model->uart_received_count != 0u) | model->uart_overrun << 1;
        model->uart_overrun = 0u;
        return value | ((model->uart_sending_count == 0u) ? 0x60u : 0u);
    case 0x20u: return model->uart_divisor & 0xFFu;
    case 0x24u: return model->uart_divisor >> 8;
    case 0x30u: return model->uart_power;
    default: return 0u;
    }
}

void uart_store(board_model_t *model, uint32_t offset, uint32_t value)
{
    pass(model);
    switch (offset) {
    case 0x00u:
        if (model->uart_sending_count >= (((model->uart_fcr & 1u) != 0u) ? 16u : 1u)) {
            violated(model, "a byte for UART2 finds its FIFO full");
        } else {
            if (model->uart_sending_count == 0u) {
                model->uart_sent_at = model->ticks + byte_ticks(model);
            }
            model->uart_sending[model->uart_sending_count] = (uint8_t)value;
            model->uart_sending_count += 1u;
        }
        break;
    case 0x04u: model->uart_ier = value; break;
    case 0x08u:
        model->uart_fcr = value;
        model->uart_received_count = ((value & 2u) != 0u) ? 0u : model->uart_received_count;
        model->uart_sending_count = ((value & 4u) != 0u) ? 0u : model->uart_sending_count;
        break;
    case 0x0Cu: model->uart_lcr = value; break;
    case 0x10u: model->uart_mcr = value; break;
    case 0x20u: model->uart_divisor = (model->uart_divisor & 0xFF00u) | (value & 0xFFu); break;
    case 0x24u: model->uart_divisor = (model->uart_divisor & 0xFFu) | (value & 0xFFu) << 8; break;
    case 0x30u: model->uart_power = value; break;
    case 0x34u: model->uart_mdr = value; break;
    default: violated(model, "an unknown register of UART2 written"); break;
    }
}
