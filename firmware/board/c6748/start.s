; start.s: vectors, reset and the 50 kHz interrupt, for the GNU assembler. With TI's tools boot.asm of its run-time
; library does the start, and `interrupt` in main.c the saving of registers.

        .nocmp
        .section .vectors, "ax"
        .align  10
        .global hysgen_vectors
hysgen_vectors:
        b       .S2     _c_int00        ; reset
        nop     5
        .align  5                       ; one fetch packet of 32 bytes each
        b       .S2     hysgen_panic    ; NMI, and exceptions
        nop     5
        .align  7                       ; two reserved
        b       .S2     tick            ; interrupt 4: Timer64P0
        nop     5
        .align  9

        .text
        .global _c_int00
_c_int00:
        mvkl    .S2     hysgen_stack_top, B15
        mvkh    .S2     hysgen_stack_top, B15
        mvkl    .S2     hysgen_vectors, B0
        mvkh    .S2     hysgen_vectors, B0
        mvc     .S2     B0, ISTP
        mvk     .S2     0, B0           ; as boot.asm of TI's library: linear addressing, rounding to nearest
        mvc     .S2     B0, AMR
        mvc     .S2     B0, FADCR
        mvc     .S2     B0, FMCR
        mvk     .S2     12, B0          ; TSR.GEE, TSR.XEN: exceptions, internal and of the events that chip.c lets through, go to the NMI slot
        mvc     .S2     B0, TSR
        callp   .S2     hysgen_start, B3
stay:   b       .S2     stay
        nop     5

; The interrupted stack may be what failed: a new one, above all data. hysgen_main_panic does not return; the watchdog resets the chip.
        .global hysgen_panic
hysgen_panic:
        mvkl    .S2     hysgen_stack_top, B15
        mvkh    .S2     hysgen_stack_top, B15
        mvk     .S2     0, B0
        mvc     .S2     B0, AMR
        callp   .S2     hysgen_main_panic, B3
halt:   b       .S2     halt
        nop     5

        .section .text.tick, "ax"
        .align  5
; Save what a C function may change, call it, restore, return: A0-A9, A16-A31, B0-B9, B16-B31. Interrupts stay off.
; The interrupted function may keep an argument at SP+4, so the first push goes below SP. C code assumes AMR = 0.
tick:
        addk    .S2     -8, B15
        stdw    .D2T1   A1:A0, *B15--[1]
        stdw    .D2T1   A3:A2, *B15--[1]
        stdw    .D2T1   A5:A4, *B15--[1]
        stdw    .D2T1   A7:A6, *B15--[1]
        stdw    .D2T1   A9:A8, *B15--[1]
        stdw    .D2T1   A17:A16, *B15--[1]
        stdw    .D2T1   A19:A18, *B15--[1]
        stdw    .D2T1   A21:A20, *B15--[1]
        stdw    .D2T1   A23:A22, *B15--[1]
        stdw    .D2T1   A25:A24, *B15--[1]
        stdw    .D2T1   A27:A26, *B15--[1]
        stdw    .D2T1   A29:A28, *B15--[1]
        stdw    .D2T1   A31:A30, *B15--[1]
        stdw    .D2T2   B1:B0, *B15--[1]
        stdw    .D2T2   B3:B2, *B15--[1]
        stdw    .D2T2   B5:B4, *B15--[1]
        stdw    .D2T2   B7:B6, *B15--[1]
        stdw    .D2T2   B9:B8, *B15--[1]
        stdw    .D2T2   B17:B16, *B15--[1]
        stdw    .D2T2   B19:B18, *B15--[1]
        stdw    .D2T2   B21:B20, *B15--[1]
        stdw    .D2T2   B23:B22, *B15--[1]
        stdw    .D2T2   B25:B24, *B15--[1]
        stdw    .D2T2   B27:B26, *B15--[1]
        stdw    .D2T2   B29:B28, *B15--[1]
        stdw    .D2T2   B31:B30, *B15--[1]
        mvc     .S2     AMR, B0
        mvk     .S2     0, B1
        mvc     .S2     B1, AMR
        stdw    .D2T2   B1:B0, *B15--[1]
        callp   .S2     hysgen_main_tick, B3
        lddw    .D2T2   *++B15[1], B1:B0
        nop     4
        mvc     .S2     B0, AMR
        lddw    .D2T2   *++B15[1], B31:B30
        lddw    .D2T2   *++B15[1], B29:B28
        lddw    .D2T2   *++B15[1], B27:B26
        lddw    .D2T2   *++B15[1], B25:B24
        lddw    .D2T2   *++B15[1], B23:B22
        lddw    .D2T2   *++B15[1], B21:B20
        lddw    .D2T2   *++B15[1], B19:B18
        lddw    .D2T2   *++B15[1], B17:B16
        lddw    .D2T2   *++B15[1], B9:B8
        lddw    .D2T2   *++B15[1], B7:B6
        lddw    .D2T2   *++B15[1], B5:B4
        lddw    .D2T2   *++B15[1], B3:B2
        lddw    .D2T2   *++B15[1], B1:B0
        lddw    .D2T1   *++B15[1], A31:A30
        lddw    .D2T1   *++B15[1], A29:A28
        lddw    .D2T1   *++B15[1], A27:A26
        lddw    .D2T1   *++B15[1], A25:A24
        lddw    .D2T1   *++B15[1], A23:A22
        lddw    .D2T1   *++B15[1], A21:A20
        lddw    .D2T1   *++B15[1], A19:A18
        lddw    .D2T1   *++B15[1], A17:A16
        lddw    .D2T1   *++B15[1], A9:A8
        lddw    .D2T1   *++B15[1], A7:A6
        lddw    .D2T1   *++B15[1], A5:A4
        lddw    .D2T1   *++B15[1], A3:A2
        lddw    .D2T1   *++B15[1], A1:A0
        addk    .S2     8, B15
        nop     3
        b       .S2     IRP
        nop     5
