"""The loops of the generated learner, written out: elements of U and parameters in blocks and pipelined order.

The templates only print these data.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hysgen.codegen.pipeline import Turn, pipelined
from hysgen.model.float32_constants import NEWTON_STEPS

SIDE_BY_SIDE = 6
"""Number of independent operations per block; they hide the latency of the multiplier and adder of the C674x."""

# Elements per block and pipeline stages with the fewest measured cycles on the C674x (docs/target.md). Wider blocks
# need more than its 64 registers; the spilled values then cost more cycles than the overlap saves.
PROJECT_WIDTH = 12
PROJECT_STAGES = ("load", "", "multiply", "", "add")
FACTOR_WIDTH = 3
FACTOR_STAGES = ("load", "multiply", "add", "raise", "lower", "store")

WEIGH_WIDTH = 9
WEIGH_STAGES = (
    "seed",
    "subtract",
    "improve",
    *(NEWTON_STEPS - 1) * ("multiply", "subtract", "improve"),
    "divide",
    "scale",
    "clamp",
)
INNOVATIONS_WIDTH = 2
INNOVATIONS_STAGES = ("load", "multiply", "add")
STEP_WIDTH = 3
STEP_STAGES = ("multiply", "raise", "lower", "carry", "add", "kept", "left", "store")


@dataclass(frozen=True)
class Element:
    """Row i and column j of a matrix, and the index `place` of the element in its C array."""

    i: int
    j: int
    place: int = 0


@dataclass(frozen=True)
class Part:
    """Neighbouring elements of one row or column of U; first: whether they begin the row or column."""

    elements: Sequence[Element]
    first: bool

    @property
    def i(self) -> int:
        """Row of the first element."""
        return self.elements[0].i

    @property
    def j(self) -> int:
        """Column of the first element."""
        return self.elements[0].j


@dataclass(frozen=True)
class UpdateLoops:
    """U' x and the factorisation (learn_update.j2), and U = I (learn_restart.j2).

    project: elements of U row by row, factor: column by column, both in pipelined order. clear: elements in blocks.
    """

    project: Sequence[Turn[Part]]
    factor: Sequence[Turn[Part]]
    clear: Sequence[Sequence[Element]]


@dataclass(frozen=True)
class StepLoops:
    """The step of theta (learn_step.j2). chains: parameters of each partial maximum of |k|; turns: theta + k q."""

    chains: Sequence[Sequence[Element]]
    turns: Sequence[Turn[list[Element]]]


def update_loops(n: int) -> UpdateLoops:
    """The loops over U of n parameters."""
    columns = [[Element(i, j, j * (j - 1) // 2 + i) for i in range(j)] for j in range(n)]
    rows = [[columns[j][i] for j in range(i + 1, n)] for i in range(n)]
    return UpdateLoops(
        project=pipelined(_parts(rows, PROJECT_WIDTH), PROJECT_STAGES),
        factor=pipelined(_parts(columns, FACTOR_WIDTH), FACTOR_STAGES),
        clear=[block for column in columns for block in blocks(column)],
    )


def denominators(n: int) -> list[Turn[list[Element]]]:
    """The loop of 1/alpha, l and D over n parameters (learn_diagonal.j2)."""
    return pipelined(blocks(parameter_elements(n), WEIGH_WIDTH), WEIGH_STAGES)


def step_loops(n: int) -> StepLoops:
    """The loops of the step of n parameters."""
    chains = [[Element(j - 1, j) for j in range(c, n, SIDE_BY_SIDE)] for c in range(min(SIDE_BY_SIDE, n))]
    return StepLoops(chains, pipelined(blocks(parameter_elements(n), STEP_WIDTH), STEP_STAGES))


def innovations(n: int) -> list[Turn[list[Element]]]:
    """The loop x' theta and x' reference over n parameters (learn_sample.j2)."""
    return pipelined(blocks(parameter_elements(n), INNOVATIONS_WIDTH), INNOVATIONS_STAGES)


def parameter_elements(n: int) -> list[Element]:
    """One element per parameter j < n, at row j - 1."""
    return [Element(j - 1, j) for j in range(n)]


def _parts(lines: Sequence[list[Element]], width: int) -> list[Part]:
    """Parts of up to `width` elements of each of the `lines`, rows or columns of U."""
    return [Part(line[k : k + width], k == 0) for line in lines for k in range(0, len(line), width)]


def blocks(elements: list[Element], width: int = SIDE_BY_SIDE) -> list[list[Element]]:
    return [elements[k : k + width] for k in range(0, len(elements), width)]
