/* c6748.cmd: the firmware in the C6748's memories, for TI's linker (EABI). c6748.ld says the same to GNU ld.
 * Not run here: cl6x cannot be had from a distribution. The first 16 KiB of L2 are the boot ROM's (SPRAB41). */
--stack_size=8192
--heap_size=0
--entry_point=_c_int00

/* The order of c6748.ld, for its reason; SPRUI04F, 4.11.7: suggestions, which act on functions in subsections of their own
 * (--gen_func_subsections) and not on what SECTIONS below names. Fill in: the model's name. */
--preferred_order=hysgen_controller_step
--preferred_order=hysgen_trim_step
--preferred_order=extended_step
--preferred_order=extended_hysteresis_apply
--preferred_order=extended_store_diagonal
--preferred_order=extended_reciprocals
--preferred_order=extended_store_regressors
--preferred_order=hysgen_main_tick
--preferred_order=hysgen_firmware_interrupt
--preferred_order=hysgen_board_displacement_um
--preferred_order=hysgen_board_reference_um
--preferred_order=hysgen_board_amplifier
--preferred_order=hysgen_board_voltage
--preferred_order=hysgen_board_line_serve
--preferred_order=hysgen_board_amplifier_enable
--preferred_order=hysgen_board_alive
--preferred_order=hysgen_board_cycles
--preferred_order=hysgen_board_overrun
--preferred_order=controller_reference
--preferred_order=controller_follow
--preferred_order=hysgen_controller_learn
--preferred_order=hysgen_controller_time
--preferred_order=hysgen_watchdog_reading
--preferred_order=hysgen_watchdog_amplifier
--preferred_order=hysgen_watchdog_follow
--preferred_order=hysgen_watchdog_time
--preferred_order=extended_factor
--preferred_order=extended_project
--preferred_order=extended_inverse
--preferred_order=extended_update_diagonal
--preferred_order=extended_innovations
--preferred_order=extended_learn
--preferred_order=extended_simulate
--preferred_order=extended_snapshot
--preferred_order=extended_commit
--preferred_order=hysgen_firmware_idle
--preferred_order=hysgen_board_line_read
--preferred_order=hysgen_firmware_status

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
