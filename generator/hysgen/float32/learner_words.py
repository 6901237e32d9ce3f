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
from hysgen.model.disturbances import Mirror
from hysgen.model.path.chain import ChainMirror
from hysgen.model.structs import Counter


class LearnerWords(StructWords):
    """State of `lanes` learners of n parameters: matrices (n, n, lanes), vectors (n, lanes), scalars (lanes,)."""

    COUNTERS: ClassVar[Mapping[str, Counter]] = LEARNER_COUNTERS

    d: Annotated[
        Floats32, vector("diagonal of D in P = U D U', every element positive", restart=Restart.PRIOR, any_bits=True)
    ]
    x: Annotated[Floats32, vector("regressors x = phi / scale of the previous sample", start=Start.ZERO)]
    theta: Annotated[
        Floats32,
        vector(
            "parameters theta of the shadow, scaled",
            unit="um",
            restart=Restart.REFERENCE,
            parameter=True,
            written_by=("step",),
        ),
    ]
    theta_low: Annotated[
        Floats32,
        vector(
            "rounding error of theta, added to the next step",
            unit="um",
            restart=Restart.ZERO,
            any_bits=True,
            written_by=("step",),
        ),
    ]
    reference: Annotated[
        Floats32,
        vector("parameters of the last commit, before it those of the model, scaled", unit="um", parameter=True),
    ]
    f: Annotated[
        Floats32, vector("vector f = U' x of this update", start=Start.ZERO, any_bits=True, written_by=("project",))
    ]
    g: Annotated[
        Floats32, vector("vector g = D f of this update", start=Start.ZERO, any_bits=True, written_by=("project",))
    ]
    l: Annotated[Floats32, vector("vector of l_j = -f_j / alpha_(j-1) of this update", start=Start.ZERO, any_bits=True)]  # noqa: E741
    k: Annotated[
        Floats32, vector("vector k = P x of this update", start=Start.ZERO, any_bits=True, written_by=("factor",))
    ]
    per_alpha: Annotated[
        Floats32, number("reciprocal of alpha = 1 + x' P x of this update", start=Start.ONE, any_bits=True)
    ]
    inflate: Annotated[Floats32, number("reciprocal of the forgetting factor lambda of this update", start=Start.ONE)]
    innovation_um: Annotated[Floats32, number("innovation y - x' theta of this update", unit="um", start=Start.ZERO)]
    fixed_um: Annotated[
        Floats32, number("part of the prediction from parameters that are not learned", unit="um", start=Start.ZERO)
    ]
    y_um: Annotated[Floats32, number("last accepted displacement", unit="um", start=Start.MODEL_Y)]
    u_V: Annotated[Floats32, number("last accepted input", unit="V", start=Start.MODEL_U)]
    mean_u_V: Annotated[
        Floats32,
        number("running mean of the input", unit="V", remark="; an input near it is at rest", start=Start.MODEL_U),
    ]
    scale_um: Annotated[
        Floats32, number("running mean of |innovation|, with outliers limited", unit="um", restart=Restart.LEVEL)
    ]
    moving_um: Annotated[Floats32, number("running mean of |y(k) - y(k-1)|", unit="um", restart=Restart.LEVEL)]
    error: Annotated[Floats32, number("mean square innovation of the shadow", unit="um^2", restart=Restart.ZERO)]
    reference_error: Annotated[
        Floats32, number("mean square innovation of the reference parameters", unit="um^2", restart=Restart.ZERO)
    ]
    step_error: Annotated[Floats32, number("mean square of y(k) - y(k-1)", unit="um^2", restart=Restart.ZERO)]
    fresh: Annotated[
        Words, flag("1 if the regressors belong to the previous sample, 0 if it was not usable", start=Start.ZERO)
    ]
    rested: Annotated[Words, flag("1 if the input was at rest at the previous sample", start=Start.ZERO)]
    measuring: Annotated[
        Words, flag("1 if this update uses a sample, 0 if it restores the prior of a parameter", start=Start.ZERO)
    ]
    since_refresh: Annotated[
        Words, integer("number of updates since the prior of a parameter was restored", start=Start.ZERO)
    ]
    turn: Annotated[Words, integer("index of the parameter whose prior is restored next", start=Start.ZERO)]
    run: Annotated[Words, integer("number of consecutive outliers", restart=Restart.ZERO)]
    age: Annotated[
        Words, integer("number of updates since the last restart", restart=Restart.ZERO, written_by=("step",))
    ]
    status: Annotated[
        Words,
        integer(
            "bits {NAME}_LEARN_..., set by events and cleared by the caller", start=Start.ZERO, written_by=("step",)
        ),
    ]
    counters: Annotated[dict[str, Words], COUNTERS_OF]
    inputs: Annotated[ChainMirror, INPUTS_OF]
    terms: Annotated[list[Mirror], TERMS_OF]
    u: Annotated[
        Floats32,
        matrix("columns of U above its diagonal, one after the other", any_bits=True, written_by=("factor", "clear")),
    ]
