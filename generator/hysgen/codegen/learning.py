"""The data of the learner's and of the commit's templates, and their parameter sections."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from hysgen.certify.certificates import Certificates
from hysgen.codegen.parameters import Constant, Section, Table, literal
from hysgen.codegen.render import Feature
from hysgen.codegen.structs import candidate_struct, learner_struct, rows, rule_axis
from hysgen.float32.coefficients import Coefficients, CommitNumbers, commit_numbers
from hysgen.float32.learner_numbers import (
    FACTOR_GRID,
    FAST,
    GAIN_GRID,
    LEAST_VARIANCE,
    REGRESSOR_GRID,
    SLOW,
    STEP_GRID,
    LearnerNumbers,
    factors,
    learner_numbers,
)
from hysgen.float32.struct_words import (
    LEARNER_COUNTERS,
    Commit,
    Described,
    Holds,
    LearnerStatus,
    LearnerWords,
    Phase,
    Restart,
    Start,
)
from hysgen.model.float32_arithmetic import ROUNDING
from hysgen.model.model import Model
from hysgen.model.structs import Axis, MeantEnum, Quantity

GRIDS: Final = {"REGRESSOR": REGRESSOR_GRID, "FACTOR": FACTOR_GRID, "GAIN": GAIN_GRID, "STEP": STEP_GRID}


@dataclass(frozen=True)
class LearnerFacts:
    """Variables of the learner's templates.

    members, status_rows, grid_rows: rows of the struct, of the status bits and of the rounding grids.
    restart, start: C values by kind and member, of a restart and of the initialisation. n: parameters; factors: words
    of U; unroll: passes of the longest loop. sliding_always: whether the forgetting factor is below 1 from the first
    update on. groups: learned groups of consequents, each with the C index of its parameter of rule l; empty for a
    bias.
    fixed: the part of the prediction that is not learned, as C text.
    """

    members: Sequence[str]
    status_rows: Sequence[str]
    grid_rows: Sequence[str]
    restart: Mapping[str, Mapping[str, str]]
    start: Mapping[str, Mapping[str, str]]
    counters: Sequence[str]
    sliding_always: bool
    n: int
    factors: int
    unroll: int
    groups: Mapping[str, str]
    fixed: str


def learner_feature(model: Model, numbers: Coefficients) -> Feature | None:
    """The generated learner of a model with learner settings; None for a model without."""
    if model.learner is None:
        return None
    settings = learner_numbers(model, numbers)
    upper = model.name.upper()
    described = LearnerWords.described()
    groups = _groups(settings)
    facts = LearnerFacts(
        members=rows(learner_struct(model, numbers).members),
        status_rows=_status_rows(upper),
        grid_rows=[
            f"#define {upper}_{name + '_GRID':<14}  {literal(np.float32(ROUNDING * np.float32(grid)))}"
            for name, grid in GRIDS.items()
            if name != "FACTOR" or factors(settings.size)
        ],
        restart=_written({member: _restart(member, model.name) for member in _restarted(described)}),
        start=_written({member: _start(member) for member in described if member.start}),
        counters=list(LEARNER_COUNTERS),
        sliding_always=model.learner.forgetting < 1.0,
        n=settings.size,
        factors=factors(settings.size),
        unroll=max(factors(settings.size), numbers.rules),
        groups=groups,
        fixed=_fixed(model, settings),
    )
    return Feature("learn.c.j2", {"learner": facts}, _sections(settings, model, firing=bool(groups)))


def _status_rows(upper: str) -> list[str]:
    return [
        f"#define {upper}_LEARN_{flag.name:<9}  0x{int(flag):03x}u  /**< {flag.meaning} */" for flag in LearnerStatus
    ]


def _groups(numbers: LearnerNumbers) -> dict[str, str]:
    """C index of the parameter of rule l in the vectors of the learner, by learned group, in the order of Eq. (9)."""
    names = [parameter.group for parameter in numbers.parameters if parameter.index == 0 and parameter.group != "bias"]
    if len(names) < 2:
        return dict.fromkeys(names, "l")
    return {name: f"{len(names)}u * l" + (f" + {place}u" if place else "") for place, name in enumerate(names)}


def _start(member: Described) -> str:
    """The initial value that `_learn_init` writes into `member`, as C text; "" if another function writes it."""
    zero, unit = ("0.0f", "1.0f") if member.type == "float" else ("0u", "1u")
    texts = {Start.ZERO: zero, Start.ONE: unit, Start.MODEL_Y: "model->y_um", Start.MODEL_U: "model->u_V"}
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
    restarted = [member for member in members if member.restart]
    order = list(Restart)
    return sorted(
        restarted, key=lambda m: order.index(m.restart) if m.restart and m.holds is Holds.VECTOR else len(order)
    )


def _restart(member: Described, name: str) -> str:
    """The value that a restart writes into `member`, as C text; j is the index of the parameter."""
    texts = {
        Restart.REFERENCE: "self->reference[j]",
        Restart.ZERO: "0.0f" if member.type == "float" else "0u",
        Restart.PRIOR: f"{name}_learn_prior[j]",
        Restart.LEVEL: f"{name.upper()}_LEARN_LEVEL_UM",
    }
    return texts[member.restart] if member.restart else ""


def _fixed_sums(numbers: LearnerNumbers) -> str:
    """The sums over the rules whose parameters are not learned, as C text; "" if all are learned."""
    sums = {"slope": "y * sums.slope", "offset": "sums.offset", "gain": "u * sums.gain"}
    return " + ".join(text for group, text in sums.items() if not numbers.learns(group))


def _fixed(model: Model, numbers: LearnerNumbers) -> str:
    """The part of the prediction y(k+1) whose parameters are not learned, as C text [um]."""
    sums = _fixed_sums(numbers)
    parts = [f"({sums}) * per_weight"] if sums else []
    if model.terms:
        parts.append(f"{model.name}_terms_sum(&self->base, &self->terms)")
    return f"{model.name}_flushed({' + '.join(parts)})" if parts else "0.0f"


def _sections(numbers: LearnerNumbers, model: Model, *, firing: bool) -> list[Section]:
    """The learner's numbers for `<name>_params.h`."""
    n = f"{model.name.upper()}_LEARNED"
    settings, share = numbers.settings, numbers.floor_um
    levels = [
        Constant("LEARN_Y_LOW_UM", numbers.y_low_um),
        Constant("LEARN_Y_HIGH_UM", numbers.y_high_um),
        Constant("LEARN_REST_V", numbers.rest_V),
        Constant("LEARN_FLOOR_UM", numbers.floor_um),
        Constant("LEARN_FLOOR_SQUARE", share * share),
        Constant("LEARN_LEVEL_UM", numbers.level_um),
        Constant("LEARN_CARRIED", numbers.carried),
        Constant("LEARN_FAST", np.float32(FAST)),
        Constant("LEARN_SLOW", np.float32(SLOW)),
    ]
    protections = [
        Constant("LEARN_GATE", numbers.gate_ratio),
        Constant("LEARN_GATE_FLOOR_UM", numbers.gate_floor_um),
        Constant("LEARN_DEAD_ZONE_UM", numbers.dead_zone_um),
        Constant("LEARN_WORSE", numbers.worse),
        Constant("LEARN_LOST", numbers.lost),
        Constant("LEARN_STEP_UM", numbers.step_um),
        Constant("LEARN_LIMIT_UM", numbers.limit_um),
        Constant("LEARN_LEAST_VARIANCE", np.float32(LEAST_VARIANCE)),
        Constant("LEARN_LARGEST_DENOMINATOR", numbers.largest_denominator),
        Constant("LEARN_OUTLIER_RUN", np.uint32(settings.outlier_run)),
        Constant("LEARN_SETTLING", np.uint32(settings.settle // 2)),
        Constant("LEARN_SETTLED", np.uint32(settings.settle)),
        Constant("LEARN_REFRESH_EVERY", np.uint32(settings.refresh)),
        Constant("LEARN_WINDOW", np.uint32(settings.window)),
        Constant("LEARN_INFLATE_FIRST", numbers.inflate_first),
        Constant("LEARN_INFLATE", numbers.inflate),
        Constant("LEARN_PER_Y", numbers.per_y),
        Constant("LEARN_PER_U", numbers.per_u),
    ]
    tables = [
        Table("learn_scale", n, numbers.scale, Quantity("theta per number in the bank")),
        Table("learn_per_scale", n, numbers.per_scale, Quantity("number in the bank per theta")),
        Table("learn_prior", n, numbers.prior, Quantity("D at the start")),
        Table("learn_ceiling", n, numbers.ceiling, Quantity("largest D")),
        Table("learn_refresh", n, numbers.refresh, Quantity("regressor of the sample that restores the prior")),
    ]
    if firing:
        near = Quantity("power of two nearest to each rule's strength")
        tables.append(Table("learn_firing", f"{model.name.upper()}_RULES", numbers.firing, near, rule_axis(model)))
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


def commit_feature(model: Model, numbers: Coefficients, certificates: Certificates) -> Feature | None:
    """The generated commit of a model with learner settings; None for a model without.

    Raises CertificateError if the parameters of the model itself violate a limit of the commit.
    """
    if model.learner is None:
        return None
    limits = commit_numbers(model, numbers, certificates)
    upper = model.name.upper()
    facts = {
        "answer_rows": _enumerators(f"{upper}_COMMIT", Commit),
        "phase_rows": _enumerators(f"{upper}_PHASE", Phase),
        "members": rows(candidate_struct(model, numbers).members),
        "bias": "bias" in model.learner.learned,
        "points_per_call": model.learner.points_per_call,
    }
    return Feature("commit.c.j2", {"commit": facts}, _commit_sections(limits, upper, rule_axis(model)))


def _enumerators(prefix: str, members: type[MeantEnum]) -> list[str]:
    """One C line per enumerator, comments in an aligned column."""
    texts = [f"{prefix}_{key.name} = {int(key)}" + "," * (key is not list(members)[-1]) for key in members]
    wide = max(len(text) for text in texts)
    return [f"{text:<{wide}}  /**< {key.meaning} */" for text, key in zip(texts, members, strict=True)]


def _commit_sections(numbers: CommitNumbers, upper: str, axis: Axis) -> list[Section]:
    constants = [
        Constant("COMMIT_MATURE", np.uint32(numbers.settings.mature)),
        Constant("COMMIT_TRIAL", np.uint32(numbers.trial)),
        Constant("COMMIT_HALF_UM", numbers.half_um),
        Constant("COMMIT_GAIN_REMAINDER", numbers.gain_remainder),
        Constant("COMMIT_SLOPE_REMAINDER_1", numbers.slope_remainder_1),
        Constant("COMMIT_SLOPE_REMAINDER_3", numbers.slope_remainder_3),
        Constant("COMMIT_SIGN", numbers.sign),
        Constant("COMMIT_GAIN_FLOOR", numbers.gain_floor),
        Constant("COMMIT_GAIN_CEILING", numbers.gain_ceiling),
        Constant("COMMIT_SLOPE_LIMIT", numbers.slope_limit),
    ]
    tables = [
        Table("commit_unfold", f"{upper}_RULES", numbers.unfold, Quantity("1 / strength of each rule"), axis),
        Table("commit_y", f"{numbers.points}", numbers.y_um, Quantity("check points", "um")),
        Table(
            "commit_table",
            f"{numbers.table.size}",
            numbers.table.ravel(),
            Quantity("memberships and their first two derivatives over the strengths, at each check point"),
        ),
    ]
    checks = Section("Commit: check points.", [Constant("COMMIT_POINTS", np.uint32(numbers.points))], public=True)
    limits = Section(
        "Commit: half the distance h of the check points; what Taylor's theorem leaves, h^2/2 times bounds of the\n"
        "memberships' second and third derivatives; limits of |b(y)| [um/V] and |df/dy|; rows of p_l, p_l', p_l''\n"
        "over the strengths w_l at each check point.",
        constants,
        tables,
    )
    return [checks, limits]
