"""The data of the learner's templates, one dataclass per partial, and the learner's parameter sections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from hysgen.codegen.parameters import Constant, Section, Table
from hysgen.codegen.pipeline import Turn
from hysgen.codegen.polynomials import Step, Sum, polynomial, powers
from hysgen.codegen.render import Feature
from hysgen.codegen.structs import learner_struct, rows, rule_axis
from hysgen.codegen.update_loops import (
    Element,
    StepLoops,
    UpdateLoops,
    blocks,
    denominators,
    innovations,
    parameter_elements,
    step_loops,
    update_loops,
)
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
    factors,
    learner_numbers,
)
from hysgen.float32.learner_status import LEARNER_COUNTERS, LEARNER_MEANINGS
from hysgen.float32.learner_words import LearnerWords
from hysgen.float32.struct_words import Described, Holds, Restart, Start
from hysgen.model.float32_constants import ROUNDING
from hysgen.model.model import Model
from hysgen.model.structs import Quantity

GRIDS: Final = {"regressor": REGRESSOR_GRID, "factor": FACTOR_GRID, "gain": GAIN_GRID, "step": STEP_GRID}


@dataclass(frozen=True)
class Learned:
    """Learned parameter i: C text of its member in the bank ("" for the bias) and C text of its regressor x_i."""

    i: int
    place: str
    regressor: str


@dataclass(frozen=True)
class RegressorFacts:
    """Regressors (learn_regressors.j2): learned groups, powers of r, sum of the strengths, fixed prediction.

    firing: whether consequents of the rules are learned; fixed_rules: whether `fixed` needs the sums over the rules.
    """

    groups: frozenset[str]
    firing: bool
    powers: Sequence[Step]
    weight: Sum
    fixed: str
    fixed_rules: bool


@dataclass(frozen=True)
class LearnerFacts:
    """Variables of the learner's templates.

    members, status_rows: rows of the struct and of the status bits. restart, start: C values by kind and member, of a
    restart and of the initialisation. n: parameters; factors: words of U; elements, blocks: the parameters, one by one
    and in blocks. sliding_always: whether the forgetting factor is below 1 from the first update on.
    grid: 1.5 * 2^23 steps of each grid.
    """

    members: Sequence[str]
    status_rows: Sequence[str]
    restart: Mapping[str, Mapping[str, str]]
    start: Mapping[str, Mapping[str, str]]
    counters: Sequence[str]
    update: UpdateLoops
    denominators: Sequence[Turn[list[Element]]]
    step: StepLoops
    regressors: RegressorFacts
    innovations: Sequence[Turn[list[Element]]]
    sliding_always: bool
    n: int
    factors: int
    learned: Sequence[Learned]
    elements: Sequence[Element]
    blocks: Sequence[Sequence[Element]]
    grid: Mapping[str, np.float32]


def learner_feature(model: Model, numbers: Coefficients, _certificates: object) -> Feature | None:
    """The generated learner of a model with learner settings; None for a model without."""
    if model.learner is None:
        return None
    found = learner_numbers(model, numbers)
    regressors = _regressor_facts(model, numbers, found)
    n, elements = found.size, parameter_elements(found.size)
    described = LearnerWords.described()
    facts = LearnerFacts(
        members=rows(learner_struct(model, numbers).members),
        status_rows=[
            f"#define {model.name.upper()}_LEARN_{flag.name:<9}  0x{int(flag):03x}u  /**< {meaning} */"
            for flag, meaning in LEARNER_MEANINGS.items()
        ],
        restart=_written({member: _restart(member, model.name) for member in _restarted(described)}),
        start=_written({member: _start(member) for member in described if member.start}),
        counters=list(LEARNER_COUNTERS),
        update=update_loops(n),
        denominators=denominators(n),
        step=step_loops(n),
        regressors=regressors,
        innovations=innovations(n),
        sliding_always=model.learner.forgetting < 1.0,
        n=n,
        factors=factors(n),
        learned=[_learned(i, parameter, model.name) for i, parameter in enumerate(found.parameters)],
        elements=elements,
        blocks=blocks(elements),
        grid={name: np.float32(ROUNDING * np.float32(grid)) for name, grid in GRIDS.items()},
    )
    return Feature("learn.c.j2", {"learner": facts}, _sections(found, model, firing=regressors.firing))


def _regressor_facts(model: Model, numbers: Coefficients, found: LearnerNumbers) -> RegressorFacts:
    return RegressorFacts(
        groups=frozenset(parameter.group for parameter in found.parameters),
        firing=not found.learns("bias"),
        powers=powers(numbers.rules),
        weight=polynomial("weight", [f"{model.name}_strength[{k}]" for k in range(numbers.rules)]),
        fixed=_fixed(model, found),
        fixed_rules=_fixed_sums(found) != "",
    )


def _learned(i: int, parameter: Parameter, name: str) -> Learned:
    """Bank member and regressor of parameter i as C text."""
    if parameter.group == "bias":
        return Learned(i, "", "1.0f")
    j = parameter.index
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
    if model.terms:
        parts.append(f"{model.name}_terms_sum(&self->base, &self->terms)")
    return f"{model.name}_flushed({' + '.join(parts)})" if parts else "0.0f"


def _sections(found: LearnerNumbers, model: Model, *, firing: bool) -> list[Section]:
    """The learner's numbers for `<name>_params.h`."""
    n = f"{model.name.upper()}_LEARNED"
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
        Table("learn_scale", n, found.scale, Quantity("theta per number in the bank")),
        Table("learn_per_scale", n, found.per_scale, Quantity("number in the bank per theta")),
        Table("learn_prior", n, found.prior, Quantity("D at the start")),
        Table("learn_ceiling", n, found.ceiling, Quantity("largest D")),
        Table("learn_refresh", n, found.refresh, Quantity("regressor of the sample that restores the prior")),
    ]
    if firing:
        near = Quantity("power of two nearest to each rule's strength")
        tables.append(Table("learn_firing", f"{model.name.upper()}_RULES", found.firing, near, rule_axis(model)))
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
