"""The TI C674x without hardware: its C compiler, a simulator of the instructions that compiler emits, and cycle counts.

Data take one way through: C texts are compiled (`toolchain`), the ELF file is read (`elf`), its disassembly becomes
instructions (`assembly`), actions (`decode`, by the tables `latency` and `semantics`) and execute packets (`packets`).
The `interpreter` runs packets and is written to be read; `translation` makes C of them that runs a hundred times faster
with the same bits and cycles. `machine` calls functions of a program; `cycles` bounds them without running them.
"""
