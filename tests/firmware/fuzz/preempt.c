/* preempt.c: interrupts inside the idle loop, before any of its accesses to memory.
 *
 * The compiler's -fsanitize=thread calls a function of the list below before every access to memory that another thread may see. Here
 * these functions count the accesses of hysgen_firmware_idle, and call the interrupt before a random one. Accesses of the interrupt itself,
 * of the stage and of the fuzzer are not counted. */

#include <string.h>

#include "case.h"

#define PLAIN __attribute__((no_sanitize("thread")))

#define PLACES 65536u

static fuzz_t *preempt_case;
static void (*preempt_interrupt)(fuzz_t *self);
static uint32_t preempt_counting;   /* 1: inside hysgen_firmware_idle */
static uint32_t preempt_left;       /* accesses until the next interrupt */
static uint32_t preempt_scale;
static uint64_t preempt_count;
static uintptr_t preempt_place[PLACES];
static uint32_t preempt_places;

/* Marks an instruction; a hash table with open addressing. */
static PLAIN void place(uintptr_t address)
{
    uint32_t at = (uint32_t)((address * 0x9E3779B97F4A7C15u) >> 48);

    while ((preempt_place[at] != 0u) && (preempt_place[at] != address)) {
        at = (at + 1u) % PLACES;
    }
    if ((preempt_place[at] == 0u) && (preempt_places < PLACES / 2u)) {
        preempt_place[at] = address;
        preempt_places += 1u;
    }
}

static PLAIN void accessed(uintptr_t from)
{
    if (preempt_counting == 0u) {
        return;
    }
    preempt_left -= 1u;
    if (preempt_left == 0u) {
        preempt_counting = 0u;
        preempt_count += 1u;
        place(from);
        /* As from a push-button of the board. */
        if (fuzz_below(preempt_case, 512u * preempt_case->calm) == 0u) {
            preempt_case->firmware.controller.request = fuzz_below(preempt_case, 4u);
        }
        preempt_interrupt(preempt_case);
        preempt_left = 1u + fuzz_below(preempt_case, preempt_scale);
        preempt_counting = 1u;
    }
}

/* The board of the host calls this from inside its store. */
static void from_store(void *with)
{
    fuzz_t *self = with;
    const uint32_t counting = preempt_counting;

    preempt_counting = 0u;
    preempt_interrupt(self);
    preempt_counting = counting;
}

void fuzz_preempted_idle(fuzz_t *self, void (*interrupt)(fuzz_t *self))
{
    preempt_case = self;
    preempt_interrupt = interrupt;
    self->board.preempt = from_store;
    self->board.preempt_with = self;
    /* A call of the idle loop makes 20 accesses where it finds nothing to do, some thousands where it commits or judges an image. */
    preempt_scale = 16u << (2u * fuzz_below(self, 5u));
    preempt_left = 1u + fuzz_below(self, preempt_scale);
    preempt_counting = 1u;
    hysgen_firmware_idle(&self->firmware, &self->board);
    preempt_counting = 0u;
}

uint64_t fuzz_preemptions(void)
{
    return preempt_count;
}

uint32_t fuzz_places(void)
{
    return preempt_places;
}

#define ACCESS(name) \
    PLAIN void __tsan_##name(void *address); \
    PLAIN void __tsan_##name(void *address) { (void)address; accessed((uintptr_t)__builtin_return_address(0)); }
#define RANGE(name) \
    PLAIN void __tsan_##name(void *address, unsigned long size); \
    PLAIN void __tsan_##name(void *address, unsigned long size) \
    { (void)address; (void)size; accessed((uintptr_t)__builtin_return_address(0)); }
#define NOTHING(name) \
    PLAIN void __tsan_##name(void); \
    PLAIN void __tsan_##name(void) { }
#define COPY(name, function) \
    PLAIN void *__tsan_##name(void *to, const void *from, unsigned long size); \
    PLAIN void *__tsan_##name(void *to, const void *from, unsigned long size) { return function(to, from, size); }

ACCESS(read1) ACCESS(read2) ACCESS(read4) ACCESS(read8) ACCESS(read16)
ACCESS(write1) ACCESS(write2) ACCESS(write4) ACCESS(write8) ACCESS(write16)
ACCESS(read1_pc) ACCESS(unaligned_read2) ACCESS(unaligned_read4) ACCESS(unaligned_read8) ACCESS(unaligned_read16)
ACCESS(unaligned_write2) ACCESS(unaligned_write4) ACCESS(unaligned_write8) ACCESS(unaligned_write16)
ACCESS(read_write1) ACCESS(read_write2) ACCESS(read_write4) ACCESS(read_write8)
RANGE(read_range) RANGE(write_range)
NOTHING(init) NOTHING(func_exit)
COPY(memcpy, memcpy) COPY(memmove, memmove)

PLAIN void *__tsan_memset(void *to, int value, unsigned long size);
PLAIN void *__tsan_memset(void *to, int value, unsigned long size)
{
    return memset(to, value, size);
}

PLAIN void __tsan_func_entry(void *caller);
PLAIN void __tsan_func_entry(void *caller)
{
    (void)caller;
}
