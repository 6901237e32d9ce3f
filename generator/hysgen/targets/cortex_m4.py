"""Cortex-M4F: a model of its cycles, and nothing that ran on one.

    cycles = 140 + 0.92 operations + 3 branches

Over 21 routines (predict, simulate and inverse of 7 models, 3 to 20 rules, with and without terms and input blocks),
compiled by clang -O2, this is 0.82 to 1.11 times what the timings of Arm's manual (Cortex-M4 Technical Reference
Manual, 3.3 and 7.2) make of their instructions: 2 cycles of a load or store, 3 of a branch, 1 of the others, 1 more of
an operation that needs the one before; no wait states. For the instructions that learn executes under qemu 0.83
to 1.10, for commit with all loops unrolled 0.83 to 0.91.
"""

from hysgen.codegen.operations import Weights
from hysgen.targets import Target

TARGET = Target("cortex-m4", weights=Weights("Cortex-M4F", 140.0, 0.92, 3.0, {}))
