"""The words of `<name>_learner_t`, from which C struct, initialisation, mirror and proof are built.

The C struct ends with two members that are not words of the mirror: the bank of the parameters that are not learned,
and the candidate of a commit (`hysgen.codegen.structs`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from hysgen.float32.learner_status import LEARNER_COUNTERS
from hysgen.float32.struct_words import (
    COUNTERS_OF,
    INPUTS_OF,
    TERMS_OF,
    Floats32,
    Restart,
    Start,
    StructWords,
    Words,
    flag,
    integer,
    matrix,
    number,
    vector,
)
from hysgen.model.path.chain import ChainMirror
from hysgen.model.structs import Counter
from hysgen.model.terms import Mirror


class LearnerWords(StructWords):
    """State of `lanes` learners of n parameters: matrices (n, n, lanes), vectors (n, lanes), scalars (lanes,)."""

    COUNTERS: ClassVar[Mapping[str, Counter]] = LEARNER_COUNTERS

    d: Annotated[Floats32, vector("diagonal D of P = U D U', larger than 0", restart=Restart.PRIOR, any_bits=True)]
    x: Annotated[Floats32, vector("regressors of the sample before, scaled", start=Start.ZERO)]
    theta: Annotated[
        Floats32,
        vector("shadow parameters, scaled", unit="um", restart=Restart.REFERENCE, parameter=True, written_by=("step",)),
    ]
    theta_low: Annotated[
        Floats32,
        vector(
            "rounding error of theta, carried along",
            unit="um",
            restart=Restart.ZERO,
            any_bits=True,
            written_by=("step",),
        ),
    ]
    reference: Annotated[
        Floats32, vector("parameters last committed, at first those of the model", unit="um", parameter=True)
    ]
    f: Annotated[Floats32, vector("U' x", start=Start.ZERO, any_bits=True, written_by=("project",))]
    g: Annotated[Floats32, vector("D U' x", start=Start.ZERO, any_bits=True, written_by=("project",))]
    l: Annotated[Floats32, vector("-f_j / alpha_(j-1)", start=Start.ZERO, any_bits=True)]  # noqa: E741
    k: Annotated[Floats32, vector("P x", start=Start.ZERO, any_bits=True, written_by=("factor",))]
    per_alpha: Annotated[Floats32, number("1 / alpha_n of this update", start=Start.ONE, any_bits=True)]
    inflate: Annotated[Floats32, number("1 / lambda of this update", start=Start.ONE)]
    innovation_um: Annotated[Floats32, number("y - x' theta of this update", unit="um", start=Start.ZERO)]
    fixed_um: Annotated[Floats32, number("part of the prediction that is not learned", unit="um", start=Start.ZERO)]
    y_um: Annotated[Floats32, number("last accepted displacement", unit="um", start=Start.MODEL_Y)]
    u_V: Annotated[Floats32, number("last accepted input", unit="V", start=Start.MODEL_U)]
    mean_u_V: Annotated[
        Floats32, number("running mean of the input", unit="V", remark="; the input rests near it", start=Start.MODEL_U)
    ]
    scale_um: Annotated[
        Floats32, number("running mean of |innovation|, outliers limited", unit="um", restart=Restart.LEVEL)
    ]
    moving_um: Annotated[Floats32, number("running mean of |y(k) - y(k-1)|", unit="um", restart=Restart.LEVEL)]
    error: Annotated[Floats32, number("mean square innovation of the shadow", unit="um^2", restart=Restart.ZERO)]
    reference_error: Annotated[
        Floats32, number("mean square innovation of the reference parameters", unit="um^2", restart=Restart.ZERO)
    ]
    step_error: Annotated[Floats32, number("mean square of y(k) - y(k-1)", unit="um^2", restart=Restart.ZERO)]
    fresh: Annotated[Words, flag("1: the regressors belong to the sample before", start=Start.ZERO)]
    rested: Annotated[Words, flag("1: the input rested at the sample before", start=Start.ZERO)]
    measuring: Annotated[Words, flag("1: this update learns from a sample, 0: it restores a prior", start=Start.ZERO)]
    since_refresh: Annotated[Words, integer("updates since a prior was restored", start=Start.ZERO)]
    turn: Annotated[Words, integer("parameter whose prior is restored next", start=Start.ZERO)]
    run: Annotated[Words, integer("outliers in a row", restart=Restart.ZERO)]
    age: Annotated[Words, integer("updates since the last restart", restart=Restart.ZERO, written_by=("step",))]
    status: Annotated[Words, integer("bits {NAME}_LEARN_..., sticky", start=Start.ZERO, written_by=("step",))]
    counters: Annotated[dict[str, Words], COUNTERS_OF]
    inputs: Annotated[ChainMirror, INPUTS_OF]
    terms: Annotated[list[Mirror], TERMS_OF]
    u: Annotated[Floats32, matrix("U above its diagonal", any_bits=True, written_by=("factor", "clear"))]
