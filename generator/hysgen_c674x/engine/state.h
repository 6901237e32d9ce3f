/* Processor state of the compiled engine. Read by the C compiler and by cffi: declarations only. */

typedef struct {
    /* Set before a run. */
    uint32_t reg[64]; /* A0..A31, B0..B31 */
    uint8_t *memory;
    uint32_t memory_base, memory_size, read_only_end;
    uint32_t program_counter, return_address;
    uint64_t cycle_limit;
    uint64_t skipped; /* number of the packet, from 0, that has no effect */

    /* Devices outside the memory; 0 if there are none. device_events: bits that devices set in IFR, bit 0 for a reset of the chip, and
     * the cycle in which to ask again. */
    void *devices;
    uint64_t (*device_load)(void *devices, uint64_t cycle, uint32_t address, uint32_t size);
    void (*device_store)(void *devices, uint64_t cycle, uint32_t address, uint32_t size, uint64_t value);
    uint32_t (*device_events)(void *devices, uint64_t cycle, uint64_t *next);
    uint64_t next_event, interrupt_overhead;

    uint32_t control[13]; /* numbers of hysgen_c674x.decode.CONTROL */
    uint32_t counts;      /* TSCL counts, */
    uint64_t counter_from; /* since this cycle */

    uint64_t *trace; /* record of the accesses to memory, see hysgen_c674x.processor.Trace */
    uint64_t trace_room;

    /* Pending effects, by the cycle modulo 8 in which they take effect: no delay exceeds 6 cycles. */
    uint32_t value[8][64];     /* results, valid where a bit of `landing` is set */
    uint64_t landing[8];       /* registers that get a result */
    uint64_t landing_quick[8]; /* those of them that do not come from memory */
    uint32_t ports[8];         /* unit write ports in use */
    uint32_t branch_target[8];
    uint8_t branch_due[8];
    uint32_t branches; /* how many are due */
    uint64_t idle;     /* cycles without instructions to come */

    /* Counted. */
    uint64_t cycle, stalls, packets, denormals, nans;
    uint64_t traced; /* accesses, those beyond trace_room included */
    uint32_t lowest_stack_pointer;

    /* Reason for an early end: numbers of hysgen_c674x.processor.ProcessorFault, the packet and a detail. */
    uint32_t fault, fault_address, fault_detail;
} c674x_t;

/* One execute packet: its effects, the registers it reads over a cross path, the next packet and idle cycles. */
typedef struct {
    void (*issue)(c674x_t *m);
    uint64_t cross_reads;
    uint32_t next, idle;
} packet_t;

void c674x_run(c674x_t *m);
