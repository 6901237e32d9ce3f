/* Results, branches and memory accesses of a packet: the rules of hysgen_c674x.interpreter in C. */
#ifndef PIPELINE_H
#define PIPELINE_H

#include "operations.h"

/* Schedules a result: register `index` gets `value` delay + 1 cycles from now. port: the unit's bit, or 0. */
void later(c674x_t *m, uint32_t delay, uint32_t index, uint32_t value, uint32_t port, int from_memory);

/* Schedules a branch: execution continues at `target` delay + 1 cycles from now. */
void branch(c674x_t *m, uint32_t delay, uint32_t target);

/* Control registers by number, and the return from an interrupt through register `number`. */
enum { AMR, CSR, IFR, ISR, ICR, IER, ISTP, IRP, NRP, TSCL, FADCR, FMCR, TSR };
enum { GIE = 1, PGIE = 2, NMI = 2, MASKABLE = 0xFFF0 };
uint32_t read_control(const c674x_t *m, uint32_t number);
void write_control(c674x_t *m, uint32_t number, uint32_t value);
void return_from(c674x_t *m, uint32_t delay, uint32_t number);

/* Kinds of accesses in the trace: numbers of hysgen_c674x.processor.AccessKind. */
enum { TRACE_FETCH, TRACE_LOAD, TRACE_STORE };

static inline void trace(c674x_t *m, uint32_t kind, uint32_t address)
{
    if (m->traced < m->trace_room)
        m->trace[m->traced] = m->cycle << 34 | (uint64_t)kind << 32 | address;
    m->traced++;
}

/* Little-endian accesses, outside the memory to the devices; a fault if the address is not a multiple of `alignment`, or is outside the
 * memory of a program without devices. */
uint64_t load(c674x_t *m, uint32_t address, uint32_t size, uint32_t alignment);
void store(c674x_t *m, uint32_t address, uint32_t size, uint32_t alignment, uint64_t value);

#endif
