#include <string.h>

#include "pipeline.h"

void stop(c674x_t *m, uint32_t fault, uint32_t detail)
{
    if (m->fault == 0) {
        m->fault = fault;
        m->fault_detail = detail;
    }
}

static uint32_t flush(c674x_t *m, uint32_t image)
{
    if ((image & 0x7F800000u) == 0 && (image & 0x007FFFFFu) != 0) {
        m->denormals++;
        return image & 0x80000000u;
    }
    return image;
}

float read_single(c674x_t *m, uint32_t image)
{
    float value;
    image = flush(m, image);
    memcpy(&value, &image, sizeof value);
    return value;
}

uint32_t write_single(c674x_t *m, float value)
{
    uint32_t image;
    if (value != value) {
        m->nans++;
        return 0x7FFFFFFFu;
    }
    memcpy(&image, &value, sizeof image);
    return flush(m, image);
}

uint32_t to_integer(c674x_t *m, double value)
{
    if (value != value) {
        stop(m, FAULT_NAN_TO_INTEGER, 0);
        return 0;
    }
    if (value > 2147483647.0)
        return 0x7FFFFFFFu;
    if (value < -2147483648.0)
        return 0x80000000u;
    return (uint32_t)(int32_t)value;
}

uint32_t leftmost(uint32_t bit, uint32_t a)
{
    uint32_t sought = bit & 1 ? a : ~a, distance = 0;
    while (distance < 32 && !(sought >> (31 - distance) & 1))
        distance++;
    return distance;
}

void later(c674x_t *m, uint32_t delay, uint32_t index, uint32_t value, uint32_t port, int from_memory)
{
    uint32_t slot = (uint32_t)(m->cycle + delay + 1) & 7;
    uint64_t bit = (uint64_t)1 << index;
    if (m->landing[slot] & bit)
        stop(m, FAULT_REGISTER_CLASH, index);
    if (m->ports[slot] & port)
        stop(m, FAULT_PORT_CLASH, 0);
    m->landing[slot] |= bit;
    m->landing_quick[slot] |= from_memory ? 0 : bit;
    m->ports[slot] |= port;
    m->value[slot][index] = value;
}

void branch(c674x_t *m, uint32_t delay, uint32_t target)
{
    uint32_t slot = (uint32_t)(m->cycle + delay + 1) & 7;
    if (m->branch_due[slot])
        stop(m, FAULT_BRANCH_CLASH, 0);
    m->branch_due[slot] = 1;
    m->branches++;
    m->branch_target[slot] = target;
}

uint32_t read_control(const c674x_t *m, uint32_t number)
{
    if (number == TSCL)
        return m->counts ? (uint32_t)(m->cycle - m->counter_from) : 0;
    return m->control[number];
}

void write_control(c674x_t *m, uint32_t number, uint32_t value)
{
    if ((number == AMR || number == FADCR || number == FMCR) && value != 0) {
        stop(m, FAULT_MODE, number);
        return;
    }
    switch (number) {
    case ISR: m->control[IFR] |= value & MASKABLE; break;
    case ICR: m->control[IFR] &= ~(value & MASKABLE); break;
    case IFR: break;
    case TSCL:
        if (!m->counts) {
            m->counts = 1;
            m->counter_from = m->cycle;
        }
        break;
    default: m->control[number] = value; break;
    }
}

void return_from(c674x_t *m, uint32_t delay, uint32_t number)
{
    branch(m, delay, m->control[number]);
    if (number == IRP)
        m->control[CSR] = (m->control[CSR] & ~(uint32_t)GIE) | (m->control[CSR] >> 1 & GIE);
    else
        m->control[IER] |= NMI;
}

/* Offset of `address` in the memory; a fault, and 0, if it may not be accessed. */
static uint32_t place(c674x_t *m, uint32_t address, uint32_t size, uint32_t alignment)
{
    uint32_t offset = address - m->memory_base;
    if (address % alignment) {
        stop(m, FAULT_MISALIGNED, address);
        return 0;
    }
    if (offset > m->memory_size - size) {
        stop(m, FAULT_OUTSIDE, address);
        return 0;
    }
    return offset;
}

static int outside(const c674x_t *m, uint32_t address, uint32_t size)
{
    return m->devices != 0 && address - m->memory_base > m->memory_size - size;
}

uint64_t load(c674x_t *m, uint32_t address, uint32_t size, uint32_t alignment)
{
    if (outside(m, address, size) && address % alignment == 0) {
        trace(m, TRACE_LOAD, address);
        return m->device_load(m->devices, m->cycle, address, size);
    }
    const uint8_t *from = m->memory + place(m, address, size, alignment);
    uint64_t value = 0;
    trace(m, TRACE_LOAD, address);
    for (uint32_t i = 0; i < size; i++)
        value |= (uint64_t)from[i] << 8 * i;
    return value;
}

void store(c674x_t *m, uint32_t address, uint32_t size, uint32_t alignment, uint64_t value)
{
    if (outside(m, address, size) && address % alignment == 0) {
        trace(m, TRACE_STORE, address);
        m->device_store(m->devices, m->cycle, address, size, size < 8 ? value & ~(~(uint64_t)0 << 8 * size) : value);
        m->next_event = 0; /* a store may start a timer */
        return;
    }
    uint8_t *to = m->memory + place(m, address, size, alignment);
    trace(m, TRACE_STORE, address);
    if (m->fault == 0 && address < m->read_only_end)
        stop(m, FAULT_READ_ONLY, address);
    if (m->fault != 0)
        return;
    for (uint32_t i = 0; i < size; i++)
        to[i] = (uint8_t)(value >> 8 * i);
}
