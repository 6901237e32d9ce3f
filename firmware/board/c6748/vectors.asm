; vectors.asm: the vector table for TI's assembler. start.s says the same to GNU as. Not run here.

        .ref    _c_int00
        .ref    hysgen_main_tick
        .ref    hysgen_main_panic
        .ref    __TI_STACK_END
        .def    hysgen_vectors
        .sect   ".vectors"
        .align  1024
        .nocmp

slot    .macro  target
        STW     .D2T2   B10, *B15--[2]
        MVKL    .S2     target, B10
        MVKH    .S2     target, B10
        B       .S2     B10
        LDW     .D2T2   *++B15[2], B10
        NOP     4
        NOP
        NOP
        .endm

; Like start.s: the interrupted stack may be what failed, and C code assumes AMR = 0.
broken  .macro  target
        MVKL    .S2     __TI_STACK_END - 8, B15
        MVKH    .S2     __TI_STACK_END - 8, B15
        MVKL    .S2     target, B10
        MVKH    .S2     target, B10
        B       .S2     B10
        MVK     .S2     0, B0
        MVC     .S2     B0, AMR
        NOP     3
        .endm

empty   .macro
        B       .S2     IRP
        NOP     5
        NOP
        NOP
        NOP
        NOP
        NOP
        NOP
        .endm

hysgen_vectors:
        slot    _c_int00
        broken  hysgen_main_panic  ; NMI, and exceptions
        empty                   ; reserved
        empty                   ; reserved
        slot    hysgen_main_tick   ; interrupt 4: Timer64P0
        empty
        empty
        empty
        empty
        empty
        empty
        empty
        empty
        empty
        empty
        empty
