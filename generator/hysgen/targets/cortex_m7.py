"""Cortex-M7: a model of its cycles, and nothing that ran on one.

    cycles = 107 + 0.93 operations + branches

Over 21 routines, those of `hysgen.targets.cortex_m4`, compiled by clang -O2, this is 0.83 to 1.18 times what LLVM's
model of the processor says of their instructions (llvm-mca, one pass; what it refuses, vcmp, vmrs, it, push and pop,
counts as a sum each); 0.93 to 1.18 for the instructions that learn executes under qemu, 1.02 to 1.05 for commit with
all loops unrolled. Tightly coupled memory, no cache misses.
"""

from hysgen.codegen.operations import Weights
from hysgen.targets import Target

TARGET = Target("cortex-m7", weights=Weights("Cortex-M7", 107.0, 0.93, 1.0, {}))
