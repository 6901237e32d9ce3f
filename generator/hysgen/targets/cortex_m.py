"""Cortex-M4F and Cortex-M7: models of their cycles, and nothing that ran on one.

    cycles = 140 + 0.92 operations + 3 branches          Cortex-M4F
    cycles = 107 + 0.93 operations + branches            Cortex-M7

Over 21 routines (predict, simulate and inverse of 7 models, 3 to 20 rules, with and without terms and input blocks),
compiled by clang -O2, the first is 0.82 to 1.11 times what the timings of Arm's manual (Cortex-M4 Technical Reference
Manual, 3.3 and 7.2) make of their instructions: 2 cycles of a load or store, 3 of a branch, 1 of the others, 1 more of
an operation that needs the one before; no wait states. For the instructions that learn executes under qemu 0.83
to 1.10, for commit with all loops unrolled 0.83 to 0.91.

The second is 0.83 to 1.18 times what LLVM's model of the processor says of the instructions of these routines
(llvm-mca, one pass; what it refuses, vcmp, vmrs, it, push and pop, counts as a sum each); 0.93 to 1.18 for the
instructions that learn executes under qemu, 1.02 to 1.05 for commit with all loops unrolled. Tightly coupled memory,
no cache misses.
"""

from hysgen.codegen.operations import Weights
from hysgen.targets import Target

CORTEX_M4 = Target("cortex-m4", weights=Weights("Cortex-M4F", 140.0, 0.92, 3.0, {}))


CORTEX_M7 = Target("cortex-m7", weights=Weights("Cortex-M7", 107.0, 0.93, 1.0, {}))
