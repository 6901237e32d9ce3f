"""The learner as its templates see it: regressors, the columns of U in slices, and its numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hysgen.coefficients import Coefficients
from hysgen.emit.concerns import Concern
from hysgen.emit.parameters import Constant, Section, Table
from hysgen.learner_numbers import (
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
from hysgen.model import Model
from hysgen.status import LEARNER_COUNTERS, LEARNER_MEANINGS

WRITTEN_OUT = 24
"""Up to this many parameters every element of U has its own lines; above, columns run in a loop to keep the code small."""

SIDE_BY_SIDE = 6
"""Independent chains that stand side by side: they hide the latency of the C674x's multiplier and adder."""

COLUMNS_PER_PASS = 4


@dataclass(frozen=True)
class Learned:
    """Parameter i: its place in a bank, and its regressor before scaling."""

    i: int
    place: str
    regressor: str
    value: str


@dataclass(frozen=True)
class Element:
    """U_ij at its place in the packed array."""

    i: int
    j: int
    place: int


@dataclass(frozen=True)
class Row:
    """Row i of U in a slice of columns: blocks of elements; `ends`: column i, complete once x_i is added."""

    i: int
    blocks: Sequence[Sequence[Element]]
    ends: bool


@dataclass(frozen=True)
class Column:
    """Column j of U above the diagonal, in blocks of elements."""

    j: int
    blocks: Sequence[Sequence[Element]]


@dataclass(frozen=True)
class Slice:
    """Columns first .. last - 1: what one call works off."""

    number: int
    first: int
    last: int
    rows: Sequence[Row]
    columns: Sequence[Column]


def learner_concern(model: Model, numbers: Coefficients, _options: object) -> Concern | None:
    """What a model with learner settings adds to the generated files; None for one without."""
    if model.learner is None:
        return None
    found = learner_numbers(model, numbers)
    n = found.size
    written_out = n <= WRITTEN_OUT
    passes = 1 if model.learner.calls_per_update == 1 else model.learner.calls_per_update // 2
    rows = [
        f"#define {model.name.upper()}_LEARN_{flag.name:<10}  0x{int(flag):03x}u  /* {meaning} */"
        for flag, meaning in LEARNER_MEANINGS.items()
    ]
    facts = {
        "written_out": written_out,
        "n": n,
        "padded": n if written_out else -(-n // COLUMNS_PER_PASS) * COLUMNS_PER_PASS,
        "factors": n * (n - 1) // 2 if written_out else n * (-(-n // COLUMNS_PER_PASS) * COLUMNS_PER_PASS),
        "side_by_side": SIDE_BY_SIDE,
        "columns_per_pass": COLUMNS_PER_PASS,
        "learned": [_learned(i, parameter, found) for i, parameter in enumerate(found.parameters)],
        "bias": found.learns("bias"),
        "groups": found.settings.learned,
        "sliding_always": model.learner.forgetting < 1.0,
        "refresh_every": model.learner.refresh,
        "outlier_run": model.learner.outlier_run,
        "settle": model.learner.settle,
        "window_updates": model.learner.window,
        "slices": _slices(n, passes, 1 if written_out else COLUMNS_PER_PASS),
        "weighed": [range(k, min(k + SIDE_BY_SIDE, n)) for k in range(0, n, SIDE_BY_SIDE)],
        "status_rows": rows,
        "counters": list(LEARNER_COUNTERS),
        "grid": {
            "regressor": np.float32(1.5 * 2**23 * REGRESSOR_GRID),
            "factor": np.float32(1.5 * 2**23 * FACTOR_GRID),
            "gain": np.float32(1.5 * 2**23 * GAIN_GRID),
            "step": np.float32(1.5 * 2**23 * STEP_GRID),
        },
    }
    return Concern("learn.c.j2", {"learner": facts}, _sections(found, model.name.upper()))


def _learned(i: int, parameter: Parameter, found: LearnerNumbers) -> Learned:
    """The C texts of parameter i."""
    if parameter.group == "bias":
        return Learned(i, "", "1.0f", "")
    if parameter.group == "terms":
        phi = sum(1 for other in found.parameters[:i] if other.group == "terms")
        return Learned(i, f"weight[{parameter.index}]", f"phi[{parameter.index}]", f"learn_per_phi[{phi}]")
    share = {"slope": " * y_share", "gain": " * u_share", "offset": ""}[parameter.group]
    return Learned(i, f"{parameter.group}[{parameter.index}]", f"firing{parameter.index}{share}", "")


def _slices(n: int, passes: int, grain: int) -> list[Slice]:
    """The columns 0 .. n - 1 in `passes` slices of about equal work; borders are multiples of `grain`."""
    work = np.cumsum(np.arange(1, n + 1))
    borders = [0]
    for number in range(1, passes):
        border = int(np.searchsorted(work, work[-1] * number / passes)) + 1
        borders.append(min(max(-(-border // grain) * grain, borders[-1]), n))
    borders.append(n)
    return [
        Slice(number, first, last, _rows(first, last), _columns(first, last))
        for number, (first, last) in enumerate(zip(borders, borders[1:], strict=False))
    ]


def _rows(first: int, last: int) -> list[Row]:
    rows = []
    for i in range(last):
        elements = [_element(i, j) for j in range(max(first, i + 1), last)]
        rows.append(Row(i, _blocks(elements), first <= i))
    return rows


def _columns(first: int, last: int) -> list[Column]:
    return [Column(j, _blocks([_element(i, j) for i in range(j)])) for j in range(first, last)]


def _element(i: int, j: int) -> Element:
    return Element(i, j, j * (j - 1) // 2 + i)


def _blocks(elements: list[Element]) -> list[list[Element]]:
    return [elements[k : k + SIDE_BY_SIDE] for k in range(0, len(elements), SIDE_BY_SIDE)]


def _sections(found: LearnerNumbers, upper: str) -> list[Section]:
    """The learner's numbers for `<name>_params.h`."""
    n = f"{upper}_LEARNED"
    rules = f"{upper}_RULES"
    share = np.float32(found.floor_um)
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
    if found.settings.learned[0] != "bias":
        tables.append(Table("learn_firing", rules, found.firing))
    if len(found.per_phi):
        tables.append(Table("learn_per_phi", f"{len(found.per_phi)}", found.per_phi))
    return [
        Section("Learner: plausible displacements, rest, levels of the innovation and how fast they follow.", levels),
        Section(
            "Learner: outlier gate, dead zone, restart (ratios of mean squares), limits, forgetting 1/lambda.",
            protections,
        ),
        Section(
            "Learner, per parameter: theta per number in the bank, and back; D(0) and largest D; what puts the prior\n"
            "back; powers of two that scale the regressors.",
            tables=tables,
        ),
    ]
