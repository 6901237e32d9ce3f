/* The cycle loop of hysgen_c674x.interpreter.run in C; the translated program defines the packets. */
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

/* Takes the interrupt that is due, the lowest number first; whether there is one. */
static int interrupted(c674x_t *m)
{
    uint32_t *control = m->control, pending = control[IFR] & control[IER], number;
    if (pending == 0 || m->branches || !(control[IER] & NMI))
        return 0;
    if (pending & NMI) {
        number = 1;
        control[IER] &= ~(uint32_t)NMI;
        control[NRP] = m->program_counter;
    } else if (pending & MASKABLE && control[CSR] & GIE) {
        number = (uint32_t)__builtin_ctz(pending & MASKABLE);
        control[CSR] = (control[CSR] & ~(uint32_t)(GIE | PGIE)) | PGIE;
        control[IRP] = m->program_counter;
    } else {
        return 0;
    }
    control[IFR] &= ~(1u << number);
    m->program_counter = (control[ISTP] & ~0x3FFu) + 32 * number;
    m->idle = m->interrupt_overhead - 1;
    return 1;
}

void c674x_run(c674x_t *m)
{
    for (;;) {
        uint64_t just_written = land(m);
        uint32_t slot = (uint32_t)m->cycle & 7;
        if (m->branch_due[slot]) {
            m->branch_due[slot] = 0;
            m->branches--;
            m->program_counter = m->branch_target[slot];
            m->idle = 0;
        }
        if (m->program_counter == m->return_address)
            break;
        if (m->cycle >= m->cycle_limit) {
            stop(m, FAULT_CYCLE_LIMIT, (uint32_t)m->cycle_limit);
            return;
        }
        if (m->cycle >= m->next_event && m->devices) {
            uint32_t flags = m->device_events(m->devices, m->cycle, &m->next_event);
            if (flags & 1) {
                m->fault_address = m->program_counter;
                stop(m, FAULT_RESET, 0);
                return;
            }
            m->control[IFR] |= flags;
        }
        if (m->idle) {
            m->idle--;
        } else if (!interrupted(m)) {
            const packet_t *packet = packet_at(m->program_counter);
            m->fault_address = m->program_counter;
            if (packet == 0) {
                stop(m, FAULT_NO_PACKET, 0);
                return;
            }
            trace(m, TRACE_FETCH, m->program_counter);
            if (m->packets != m->skipped)
                packet->issue(m);
            if (m->fault)
                return;
            m->packets++;
            m->stalls += (packet->cross_reads & just_written) != 0;
            m->program_counter = packet->next;
            m->idle = packet->idle;
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
