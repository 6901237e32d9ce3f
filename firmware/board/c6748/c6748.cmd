/* c6748.cmd: the firmware in the C6748's memories, for TI's linker (EABI). c6748.ld says the same to GNU ld.
 * Not run here: cl6x cannot be had from a distribution. The first 16 KiB of L2 are the boot ROM's (SPRAB41). */
--stack_size=8192
--heap_size=0
--entry_point=_c_int00

MEMORY
{
    L2      : origin = 0x11804000, length = 0x0003C000
    SHARED  : origin = 0x80000000, length = 0x00020000
}

SECTIONS
{
    .vectors  > 0x11804000
    .text     > L2
    .const    > L2
    .switch   > L2
    .cinit    > L2
    .init_array > L2
    .neardata > L2
    .fardata  > L2
    .rodata   > L2
    .bss      > L2
    .far      > L2
    .stack    > L2
}
