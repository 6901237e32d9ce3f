"""Scheduled assembly of generated C functions for the C674x.

`from_c` reads the dataflow of a function out of the generated C, `selection` chooses instructions, `scheduler` places
them in execute packets and registers, `emit` writes them for the assembler. `checker` inspects the assembled packets
and shares no code with the others.
"""
