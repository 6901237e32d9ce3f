/* The cycle loop of hysgen.c674x.interpreter.run in C; the translated program defines the packets. */
#include "pipeline.h"

#define STACK_POINTER (32 + 15)

extern const packet_t program[];
extern const uint32_t program_start, program_words;

static uint64_t land(c674x_t *m)
{
    uint32_t slot = (uint32_t)m->cycle & 7;
    uint64_t left = m->landing[slot], quick = m->landing_quick[slot];
    while (left) {
        int index = __builtin_ctzll(left);
        m->reg[index] = m->value[slot][index];
        left &= left - 1;
    }
    if (m->landing[slot] >> STACK_POINTER & 1 && m->reg[STACK_POINTER] < m->lowest_stack_pointer)
        m->lowest_stack_pointer = m->reg[STACK_POINTER];
    m->landing[slot] = 0;
    m->landing_quick[slot] = 0;
    m->ports[slot] = 0;
    return quick;
}

static const packet_t *packet_at(uint32_t address)
{
    uint32_t word = (address - program_start) / 4;
    if ((address - program_start) % 4 || word >= program_words || program[word].issue == 0)
        return 0;
    return &program[word];
}

void c674x_run(c674x_t *m)
{
    uint32_t idle = 0;
    for (;;) {
        uint64_t just_written = land(m);
        uint32_t slot = (uint32_t)m->cycle & 7;
        if (m->branch_due[slot]) {
            m->branch_due[slot] = 0;
            m->program_counter = m->branch_target[slot];
            idle = 0;
        }
        if (m->program_counter == m->return_address)
            break;
        if (m->cycle >= m->cycle_limit) {
            stop(m, FAULT_CYCLE_LIMIT, (uint32_t)m->cycle_limit);
            return;
        }
        if (idle) {
            idle--;
        } else {
            const packet_t *packet = packet_at(m->program_counter);
            m->fault_address = m->program_counter;
            if (packet == 0) {
                stop(m, FAULT_NO_PACKET, 0);
                return;
            }
            trace(m, TRACE_FETCH, m->program_counter);
            packet->issue(m);
            if (m->fault)
                return;
            m->packets++;
            m->stalls += (packet->cross_reads & just_written) != 0;
            m->program_counter = packet->next;
            idle = packet->idle;
        }
        m->cycle++;
    }
    uint64_t cycles = m->cycle;
    for (int i = 0; i < 8; i++) {
        m->cycle++;
        land(m);
    }
    m->cycle = cycles;
}
