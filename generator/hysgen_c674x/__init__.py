"""The TI C674x without hardware: its C compiler, a simulator of the instructions the compiler emits, and cycle counts.

Steps: compile C (`toolchain`), read the ELF file (`elf`), parse its disassembly into instructions (`assembly`), decode
them to actions (`decode`), group them into execute packets (`packets`). The `interpreter` runs packets and serves as
the readable specification; `translation` turns packets into C that runs a hundred times faster with the same bits and
cycles. `machine` calls functions of a program; `cycles` bounds their cycles statically, and collects cycles, code,
stack and data of generated C; `equality` compares its bits with the host's.
"""
