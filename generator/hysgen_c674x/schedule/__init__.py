"""Scheduled assembly of generated C functions for the C674x.

`from_c` reads the dataflow of a function out of the generated C, `selection` chooses `instructions`. For long kernels
`precedence` finds a sequence in which few values are alive, `spilling` stores values on the stack, and `pairing` makes
64-bit stores. `scheduler` places the instructions in execute packets and registers by the settings of `plans`, `folder`
writes them for the assembler. `checker` inspects the assembled packets and shares no code with the others.
"""
