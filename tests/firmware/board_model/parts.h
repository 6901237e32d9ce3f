/* Functions among the files of the model. */
#ifndef MODEL_OF_BOARD_H
#define MODEL_OF_BOARD_H

#include <stdint.h>

#include "board_model.h"

#define NEVER 1e300

void violated(board_model_t *model, const char *text);
uint32_t muxed(const board_model_t *model, uint32_t pinmux, uint32_t lowest_bit, uint32_t function);
double seconds(const board_model_t *model, double duration_s);  /* in periods of the crystal */
double sysclk2_ratio(const board_model_t *model);               /* periods of SYSCLK2 per period of the crystal */
void pass_time(board_model_t *model, uint64_t cycle);

void clock_reset(board_model_t *model);
uint32_t pll_load(const board_model_t *model, uint32_t offset);
void pll_store(board_model_t *model, uint32_t offset, uint32_t value);
uint32_t psc_load(board_model_t *model, uint32_t psc, uint32_t offset);
void psc_store(board_model_t *model, uint32_t psc, uint32_t offset, uint32_t value);
uint32_t powered(board_model_t *model, uint32_t psc, uint32_t module);

void uart_reset(board_model_t *model);
uint32_t uart_load(board_model_t *model, uint32_t offset);
void uart_store(board_model_t *model, uint32_t offset, uint32_t value);

void spi_reset(board_model_t *model);
uint32_t spi_load(board_model_t *model, uint32_t offset);
void spi_store(board_model_t *model, uint32_t offset, uint32_t value);

void converters_reset(board_model_t *model);
void adc_reset_changes(board_model_t *model);
void convst_rises(board_model_t *model, double at);
uint32_t adc_busy(const board_model_t *model);
uint32_t bus_load(board_model_t *model, uint32_t address, uint32_t size);
void bus_store(board_model_t *model, uint32_t address, uint32_t size, uint32_t value);

#endif
