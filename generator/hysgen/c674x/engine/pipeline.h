/* Results, branches and memory accesses of a packet: the rules of hysgen.c674x.interpreter in C. */
#ifndef PIPELINE_H
#define PIPELINE_H

#include "operations.h"

/* Schedules a result: register `index` gets `value` delay + 1 cycles from now. port: the unit's bit, or 0. */
void later(c674x_t *m, uint32_t delay, uint32_t index, uint32_t value, uint32_t port, int from_memory);

/* Schedules a branch: execution continues at `target` delay + 1 cycles from now. */
void branch(c674x_t *m, uint32_t delay, uint32_t target);

/* Kinds of accesses in the trace: numbers of hysgen.c674x.processor.AccessKind. */
enum { TRACE_FETCH, TRACE_LOAD, TRACE_STORE };

static inline void trace(c674x_t *m, uint32_t kind, uint32_t address)
{
    if (m->traced < m->trace_room)
        m->trace[m->traced] = m->cycle << 34 | (uint64_t)kind << 32 | address;
    m->traced++;
}

/* Little-endian accesses; a fault if the address is not a multiple of `alignment` or not in the memory. */
uint64_t load(c674x_t *m, uint32_t address, uint32_t size, uint32_t alignment);
void store(c674x_t *m, uint32_t address, uint32_t size, uint32_t alignment, uint64_t value);

#endif
