"""The data of the learner's templates: regressors, columns of U per call, pipelined loops, and parameter sections."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hysgen.codegen.parameters import Constant, Section, Table
from hysgen.codegen.pipeline import Turn, pipelined
from hysgen.codegen.polynomials import polynomial, powers
from hysgen.codegen.render import Feature
from hysgen.codegen.structs import learner_struct, rows
from hysgen.float32.coefficients import Coefficients
from hysgen.float32.learner_numbers import (
    FACTOR_GRID,
    FAST,
    GAIN_GRID,
    LEAST_VARIANCE,
    REGRESSOR_GRID,
    SLOW,
    STEP_GRID,
    LearnerNumbers,
    Parameter,
    learner_numbers,
)
from hysgen.float32.learner_status import LEARNER_COUNTERS, LEARNER_MEANINGS
from hysgen.float32.learner_words import LearnerWords
from hysgen.float32.struct_words import Described, Holds, Restart, Start
from hysgen.float32.update_schedule import COLUMNS_PER_PASS, WRITTEN_OUT, UpdateSchedule, factors
from hysgen.model.float32_constants import NEWTON_STEPS, ROUNDING
from hysgen.model.model import Model

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
class Learned:
    """Learned parameter i: C text of its member in the bank ("" for the bias) and C text of its regressor x_i."""

    i: int
    place: str
    regressor: str


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


def learner_feature(model: Model, numbers: Coefficients, _certificates: object) -> Feature | None:
    """The generated learner of a model with learner settings; None for a model without."""
    if model.learner is None:
        return None
    found = learner_numbers(model, numbers)
    n, upper = found.size, model.name.upper()
    written_out = n <= WRITTEN_OUT
    firing = any(found.learns(group) for group in ("slope", "gain", "offset"))
    ends = [Element(j - 1, j) for j in range(n)]
    every = _blocks(ends)
    described = LearnerWords.described()
    one_after_another = [Turn(stage, block) for stage in ("multiply", "add") for block in every]
    facts = {
        "n": n,
        "written_out": written_out,
        "factors": factors(n),
        "members": rows(learner_struct(model, numbers).members),
        "start": _written({member: _start(member) for member in described if member.start}),
        "restart": _written({member: _restart(member, model.name) for member in _restarted(described)}),
        "columns_per_pass": COLUMNS_PER_PASS,
        "learned": [_learned(i, parameter, model.name) for i, parameter in enumerate(found.parameters)],
        "groups": {parameter.group for parameter in found.parameters},
        "firing": firing,
        "powers": powers(numbers.rules),
        "weight": polynomial("weight", [f"{model.name}_strength[{k}]" for k in range(numbers.rules)]),
        "fixed_rules": _fixed_sums(found) != "",
        "fixed": _fixed(model, found),
        "project_slices": _slices(found.schedule.project),
        "factor_slices": _slices(found.schedule.factor),
        "clear_slices": [part for part in _slices(found.schedule.factor) if _clears(part.last, n)],
        "phases": _phases(found.schedule, n),
        "chains": [[Element(j - 1, j) for j in range(c, n, SIDE_BY_SIDE)] for c in range(min(SIDE_BY_SIDE, n))],
        "at_once": found.schedule.single_call,
        "calls": found.schedule.calls,
        "clearing": found.schedule.clearing,
        "calls_to_restart": found.schedule.phases - found.schedule.calls,
        "blocks": every,
        "innovations": pipelined(_blocks(ends, INNOVATIONS_WIDTH), INNOVATIONS_STAGES),
        "sums": pipelined(every, SUM_STAGES) if not written_out else one_after_another,
        "weigh": pipelined(
            _blocks(ends, WEIGH_WIDTH if written_out else VARIANCE_WIDTH),
            WEIGH_STAGES if written_out else VARIANCE_STAGES,
        ),
        "reciprocals": [Element(0, c) for c in range(WEIGH_WIDTH)],
        "reciprocal_passes": [] if written_out else [min(c, n - WEIGH_WIDTH) for c in range(0, n, WEIGH_WIDTH)],
        "reciprocal": "r%d" if written_out else "r[%d]",
        "denominator": "a%d" if written_out else "a[%d]",
        "step": pipelined(_blocks(ends, STEP_WIDTH), STEP_STAGES),
        "pass_columns": [Element(0, c, c * n) for c in range(COLUMNS_PER_PASS)],
        "pass_rows": pipelined(
            [[Element(i, c, c * n + i) for c in range(COLUMNS_PER_PASS)] for i in range(n)], PASS_STAGES
        ),
        "column_factor": pipelined(_blocks(ends, FACTOR_WIDTH), FACTOR_STAGES),
        "sliding_always": model.learner.forgetting < 1.0,
        "status_rows": [
            f"#define {upper}_LEARN_{flag.name:<9}  0x{int(flag):03x}u  /**< {meaning} */"
            for flag, meaning in LEARNER_MEANINGS.items()
        ],
        "counters": list(LEARNER_COUNTERS),
        "grid": {
            name: np.float32(ROUNDING * np.float32(grid))
            for name, grid in (
                ("regressor", REGRESSOR_GRID),
                ("factor", FACTOR_GRID),
                ("gain", GAIN_GRID),
                ("step", STEP_GRID),
            )
        },
    }
    return Feature("learn.c.j2", {"learner": facts}, _sections(found, upper, firing))


def _learned(i: int, parameter: Parameter, name: str) -> Learned:
    """Bank member and regressor of parameter i as C text."""
    if parameter.group == "bias":
        return Learned(i, "", "1.0f")
    j = parameter.index
    if parameter.group == "terms":
        return Learned(i, f"weight[{j}]", f"phi[{j}] * {name}_learn_per_phi[{j}]")
    share = {"slope": " * y_share", "gain": " * u_share", "offset": ""}[parameter.group]
    return Learned(i, f"{parameter.group}[{j}]", f"firing{j}{share}")


def _start(member: Described) -> str:
    """The initial value that `_learn_init` writes into `member`, as C text; "" if another function writes it."""
    zero, one = ("0.0f", "1.0f") if member.type == "float" else ("0u", "1u")
    texts = {Start.ZERO: zero, Start.ONE: one, Start.MODEL_Y: "model->y_um", Start.MODEL_U: "model->u_V"}
    return texts[member.start] if member.start else ""


def _written(values: Mapping[Described, str]) -> dict[str, dict[str, str]]:
    """The C texts by member name, grouped into vectors, numbers (float scalars) and integers."""
    kinds = {
        "vectors": (Holds.VECTOR,),
        "numbers": (Holds.NUMBER,),
        "integers": (Holds.INTEGER, Holds.FLAG),
    }
    return {
        kind: {member.name: text for member, text in values.items() if member.holds in holds}
        for kind, holds in kinds.items()
    }


def _restarted(members: Sequence[Described]) -> list[Described]:
    """Members that a restart writes: vectors in the order of `Restart`, the others in the order of the struct."""
    found = [member for member in members if member.restart]
    order = list(Restart)
    return sorted(found, key=lambda m: order.index(m.restart) if m.restart and m.holds is Holds.VECTOR else len(order))


def _restart(member: Described, name: str) -> str:
    """The value that a restart writes into `member`, as C text; {j} is the index of the parameter."""
    texts = {
        Restart.REFERENCE: "self->reference[{j}]",
        Restart.ZERO: "0.0f" if member.type == "float" else "0u",
        Restart.PRIOR: f"{name}_learn_prior[{{j}}]",
        Restart.LEVEL: f"{name.upper()}_LEARN_LEVEL_UM",
    }
    return texts[member.restart] if member.restart else ""


def _fixed_sums(found: LearnerNumbers) -> str:
    """The sums over the rules whose parameters are not learned, as C text; "" if all are learned."""
    sums = {"slope": "y * sums.slope", "offset": "sums.offset", "gain": "u * sums.gain"}
    return " + ".join(text for group, text in sums.items() if not found.learns(group))


def _fixed(model: Model, found: LearnerNumbers) -> str:
    """The part of the prediction y(k+1) whose parameters are not learned, as C text [um]."""
    sums = _fixed_sums(found)
    parts = [f"({sums}) * per_weight"] if sums else []
    if model.terms and not found.learns("terms"):
        parts.append(f"{model.name}_terms_sum(&self->base, &self->terms)")
    return f"{model.name}_settled({' + '.join(parts)})" if parts else "0.0f"


def _slices(borders: Sequence[int]) -> list[Slice]:
    """The non-empty slices between successive column `borders`."""
    pairs = enumerate(itertools.pairwise(borders))
    return [_slice(number, first, last, borders[-1]) for number, (first, last) in pairs if first < last]


def _phases(schedule: UpdateSchedule, n: int) -> list[Phase]:
    """The phases 1, 2, ... of an update of n parameters, then those of a restart."""
    found: list[Phase] = []
    for kind, borders in (("project", schedule.project), ("factor", schedule.factor), ("clear", schedule.factor)):
        for k, (first, last) in enumerate(itertools.pairwise(borders)):
            busy = first < last and (kind != "clear" or _clears(last, n))
            number = len(found) + 1
            following = 0 if number == schedule.phases else number + 1
            found.append(Phase(f"{kind}_{k}" if busy else "", number, following, kind, last=k + 2 == len(borders)))
    return found


def _clears(last: int, n: int) -> bool:
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
        begun_blocks=_blocks([Element(j - 1, j) for j in range(first)]),
        end_blocks=_blocks(ends),
        done_blocks=_blocks([Element(j - 1, j) for j in range(last)]),
        passes=[min(c, n - COLUMNS_PER_PASS) for c in range(first, last, COLUMNS_PER_PASS)],
        columns=[Column(j, _blocks(_column(j))) for j in range(first, last)],
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


def _blocks(elements: list[Element], width: int = SIDE_BY_SIDE) -> list[list[Element]]:
    return [elements[k : k + width] for k in range(0, len(elements), width)]


def _sections(found: LearnerNumbers, upper: str, firing: bool) -> list[Section]:
    """The learner's numbers for `<name>_params.h`."""
    n = f"{upper}_LEARNED"
    rules = f"{upper}_RULES"
    settings, share = found.settings, found.floor_um
    levels = [
        Constant("LEARN_Y_LOW_UM", found.y_low_um),
        Constant("LEARN_Y_HIGH_UM", found.y_high_um),
        Constant("LEARN_REST_V", found.rest_V),
        Constant("LEARN_FLOOR_UM", found.floor_um),
        Constant("LEARN_FLOOR_SQUARE", share * share),
        Constant("LEARN_LEVEL_UM", found.level_um),
        Constant("LEARN_FAST", np.float32(FAST)),
        Constant("LEARN_SLOW", np.float32(SLOW)),
    ]
    protections = [
        Constant("LEARN_GATE", found.gate_ratio),
        Constant("LEARN_GATE_FLOOR_UM", found.gate_floor_um),
        Constant("LEARN_DEAD_ZONE_UM", found.dead_zone_um),
        Constant("LEARN_WORSE", found.worse),
        Constant("LEARN_LOST", found.lost),
        Constant("LEARN_STEP_UM", found.step_um),
        Constant("LEARN_LIMIT_UM", found.limit_um),
        Constant("LEARN_LEAST_VARIANCE", np.float32(LEAST_VARIANCE)),
        Constant("LEARN_LARGEST_DENOMINATOR", found.largest_denominator),
        Constant("LEARN_OUTLIER_RUN", np.uint32(settings.outlier_run)),
        Constant("LEARN_SETTLING", np.uint32(settings.settle // 2)),
        Constant("LEARN_SETTLED", np.uint32(settings.settle)),
        Constant("LEARN_REFRESH_EVERY", np.uint32(settings.refresh)),
        Constant("LEARN_WINDOW", np.uint32(settings.window)),
        Constant("LEARN_INFLATE_FIRST", found.inflate_first),
        Constant("LEARN_INFLATE", found.inflate),
        Constant("LEARN_PER_Y", found.per_y),
        Constant("LEARN_PER_U", found.per_u),
    ]
    tables = [
        Table("learn_scale", n, found.scale),
        Table("learn_per_scale", n, found.per_scale),
        Table("learn_prior", n, found.prior),
        Table("learn_ceiling", n, found.ceiling),
        Table("learn_refresh", n, found.refresh),
    ]
    if firing:
        tables.append(Table("learn_firing", rules, found.firing))
    if len(found.per_phi):
        tables.append(Table("learn_per_phi", f"{len(found.per_phi)}", found.per_phi))
    return [
        Section("Learner: plausible displacements, rest, levels of the innovation and how fast they follow.", levels),
        Section(
            "Learner: outlier gate, dead zone, restart (ratios of mean squares), limits, updates, forgetting\n"
            "1/lambda.",
            protections,
        ),
        Section(
            "Learner, per parameter: theta per number in the bank, and back; D(0) and largest D; what puts the prior\n"
            "back; powers of two that scale the regressors.",
            tables=tables,
        ),
    ]
