"""The loops of the generated learner: elements of U in slices of columns, blocks and pipelined order.

One dataclass per template partial holds the data of its loops; the templates only print them.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

from hysgen.codegen.pipeline import Turn, pipelined
from hysgen.float32.update_schedule import COLUMNS_PER_PASS, WRITTEN_OUT, UpdateSchedule
from hysgen.model.float32_constants import NEWTON_STEPS

SIDE_BY_SIDE = 6
"""Number of independent operations per block; they hide the latency of the multiplier and adder of the C674x."""

# Elements per block and pipeline stages with the fewest measured cycles on the C674x (docs/target.md). Wider blocks
# need more than its 64 registers; the spilled values then cost more cycles than the overlap saves.
PROJECT_WIDTH = 12
PROJECT_STAGES = ("load", "", "multiply", "", "add")
FACTOR_WIDTH = 3
FACTOR_STAGES = ("load", "multiply", "add", "raise", "lower", "store")

PASS_STAGES = ("load", "", "multiply", "", "add")
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
SUM_STAGES = ("multiply", "", "add", "keep")
VARIANCE_WIDTH = 3
VARIANCE_STAGES = WEIGH_STAGES[-3:]
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
class Column:
    """The elements of U above the diagonal in column j, in blocks of SIDE_BY_SIDE."""

    j: int
    blocks: Sequence[Sequence[Element]]


@dataclass(frozen=True)
class Slice:
    """The columns first .. last - 1 of U that one call computes, in the projection or in the factorisation.

    project, factor: elements of the columns, row by row and column by column, in pipelined order.
    passes: first column of each pass of COLUMNS_PER_PASS columns of U' x. columns: the columns of the slice.
    ends: one element per column; begun_blocks, end_blocks, done_blocks: blocks of one element per column, for the
    columns 0 .. first - 1, first .. last - 1 and 0 .. last - 1.
    """

    number: int
    first: int
    last: int
    about: str
    project: Sequence[Turn[Part]]
    factor: Sequence[Turn[Part]]
    ends: Sequence[Element]
    begun_blocks: Sequence[Sequence[Element]]
    end_blocks: Sequence[Sequence[Element]]
    done_blocks: Sequence[Sequence[Element]]
    passes: Sequence[int]
    columns: Sequence[Column]


@dataclass(frozen=True)
class Phase:
    """The work of one call in an update or restart that takes several calls, and the phase that comes next.

    work: name of the generated function, "" without columns. kind: project, factor or clear. last: whether the phase is
    the last of its kind.
    """

    work: str
    number: int
    following: int
    kind: str
    last: bool


@dataclass(frozen=True)
class UpdateLoops:
    """U' x and the factorisation (learn_written_out.j2, learn_looped.j2).

    The slices are those of the calls. The other fields are used above WRITTEN_OUT parameters: pass_rows, pass_columns:
    a pass over the rows of columns_per_pass columns of U' x; column: the update of one column of U.
    """

    project_slices: Sequence[Slice]
    factor_slices: Sequence[Slice]
    columns_per_pass: int
    pass_columns: Sequence[Element]
    pass_rows: Sequence[Turn[list[Element]]]
    column: Sequence[Turn[list[Element]]]


@dataclass(frozen=True)
class DenominatorLoops:
    """alpha, l and D (learn_diagonal.j2).

    sums: alpha_j = alpha_(j-1) + f_j g_j. turns: the stages of reciprocals, l and D. reciprocals: elements of one pass
    of passes of reciprocals, which begin at reciprocal_passes; none up to WRITTEN_OUT parameters.
    reciprocal, denominator: formats of the C names of 1/alpha_j and alpha_j.
    """

    sums: Sequence[Turn[list[Element]]]
    turns: Sequence[Turn[list[Element]]]
    reciprocals: Sequence[Element]
    reciprocal_passes: Sequence[int]
    reciprocal: str
    denominator: str


@dataclass(frozen=True)
class StepLoops:
    """The step of theta (learn_step.j2). chains: parameters of each partial maximum of |k|; turns: theta + k q."""

    chains: Sequence[Sequence[Element]]
    turns: Sequence[Turn[list[Element]]]


def update_loops(schedule: UpdateSchedule, n: int) -> UpdateLoops:
    """The loops over U of n parameters, divided among calls by `schedule`."""
    rows = [[Element(i, c, c * n + i) for c in range(COLUMNS_PER_PASS)] for i in range(n)]
    return UpdateLoops(
        project_slices=slices(schedule.project),
        factor_slices=slices(schedule.factor),
        columns_per_pass=COLUMNS_PER_PASS,
        pass_columns=[Element(0, c, c * n) for c in range(COLUMNS_PER_PASS)],
        pass_rows=pipelined(rows, PASS_STAGES),
        column=pipelined(blocks(parameter_elements(n), FACTOR_WIDTH), FACTOR_STAGES),
    )


def denominator_loops(n: int) -> DenominatorLoops:
    """The loops of alpha, l and D of n parameters."""
    elements, written_out = parameter_elements(n), n <= WRITTEN_OUT
    every = blocks(elements)
    in_sequence = [Turn(stage, block) for stage in ("multiply", "add") for block in every]
    width, stages = (WEIGH_WIDTH, WEIGH_STAGES) if written_out else (VARIANCE_WIDTH, VARIANCE_STAGES)
    return DenominatorLoops(
        sums=in_sequence if written_out else pipelined(every, SUM_STAGES),
        turns=pipelined(blocks(elements, width), stages),
        reciprocals=[Element(0, c) for c in range(WEIGH_WIDTH)],
        reciprocal_passes=[] if written_out else [min(c, n - WEIGH_WIDTH) for c in range(0, n, WEIGH_WIDTH)],
        reciprocal="r%d" if written_out else "r[%d]",
        denominator="a%d" if written_out else "a[%d]",
    )


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


def slices(borders: Sequence[int]) -> list[Slice]:
    """The non-empty slices between successive column `borders`."""
    pairs = enumerate(itertools.pairwise(borders))
    return [_slice(number, first, last, borders[-1]) for number, (first, last) in pairs if first < last]


def phases(schedule: UpdateSchedule, n: int) -> list[Phase]:
    """The phases 1, 2, ... of an update of n parameters, then those of a restart."""
    found: list[Phase] = []
    for kind, borders in (("project", schedule.project), ("factor", schedule.factor), ("clear", schedule.factor)):
        for k, (first, last) in enumerate(itertools.pairwise(borders)):
            busy = first < last and (kind != "clear" or clears(last, n))
            number = len(found) + 1
            following = 0 if number == schedule.phases else number + 1
            found.append(Phase(f"{kind}_{k}" if busy else "", number, following, kind, last=k + 2 == len(borders)))
    return found


def clears(last: int, n: int) -> bool:
    """Whether C stores an element of U in columns up to last - 1; packed columns have no diagonal."""
    return n > WRITTEN_OUT or last > 1


def _slice(number: int, first: int, last: int, n: int) -> Slice:
    """The slice of columns first .. last - 1 of n."""
    ends = [Element(j - 1, j) for j in range(first, last)]
    return Slice(
        number=number,
        first=first,
        last=last,
        about=_about(first, last, n),
        project=pipelined(
            [part for i in range(last) for part in _parts(_row(i, first, last), PROJECT_WIDTH)], PROJECT_STAGES
        ),
        factor=pipelined(
            [part for j in range(first, last) for part in _parts(_column(j), FACTOR_WIDTH)], FACTOR_STAGES
        ),
        ends=ends,
        begun_blocks=blocks([Element(j - 1, j) for j in range(first)]),
        end_blocks=blocks(ends),
        done_blocks=blocks([Element(j - 1, j) for j in range(last)]),
        passes=[min(c, n - COLUMNS_PER_PASS) for c in range(first, last, COLUMNS_PER_PASS)],
        columns=[Column(j, blocks(_column(j))) for j in range(first, last)],
    )


def _about(first: int, last: int, n: int) -> str:
    if last - first == n:
        return ""
    return f", column {first}" if last - first == 1 else f", columns {first} to {last - 1}"


def _row(i: int, first: int, last: int) -> list[Element]:
    return [_element(i, j) for j in range(max(first, i + 1), last)]


def _column(j: int) -> list[Element]:
    return [_element(i, j) for i in range(j)]


def _parts(elements: list[Element], width: int) -> list[Part]:
    return [Part(elements[k : k + width], k == 0) for k in range(0, len(elements), width)]


def _element(i: int, j: int) -> Element:
    return Element(i, j, j * (j - 1) // 2 + i)


def blocks(elements: list[Element], width: int = SIDE_BY_SIDE) -> list[list[Element]]:
    return [elements[k : k + width] for k in range(0, len(elements), width)]
