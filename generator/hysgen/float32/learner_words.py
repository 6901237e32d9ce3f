"""The words of `<name>_learner_t`, its status bits and counters, and the return values of `_commit`.

The C struct ends with two members that are not words of the mirror: the bank of the parameters that are not learned,
and the candidate of a commit (`hysgen.codegen.structs`).
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from typing import Annotated, ClassVar

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


class LearnerStatus(enum.IntFlag):
    """Bits of a learner's `status`; an event sets its bit, the caller or `_learn_init` clears it."""

    REJECTED = 1
    OUTSIDE = 2
    RESTING = 4
    OUTLIER = 8
    CHANGED = 16
    QUIET = 32
    LIMITED = 64
    CLAMPED = 128
    RESTARTED = 256


LEARNER_MEANINGS = {
    LearnerStatus.REJECTED: "A sample was not finite or not plausible and was ignored.",
    LearnerStatus.OUTSIDE: "A displacement was outside the identified range; no update used it.",
    LearnerStatus.RESTING: "The input was at rest; no update used the sample.",
    LearnerStatus.OUTLIER: "An innovation was an outlier; no update used it.",
    LearnerStatus.CHANGED: "Enough outliers in a row were taken for a change of the plant; updates resumed.",
    LearnerStatus.QUIET: "An innovation was inside the dead zone; no update used it.",
    LearnerStatus.LIMITED: "A step of the parameters was reduced.",
    LearnerStatus.CLAMPED: "An element of D was limited.",
    LearnerStatus.RESTARTED: "The shadow was reset to the reference parameters and the prior.",
}

LEARNER_COUNTERS = {
    "updates": Counter("number of updates that changed the parameters", written_by=("step",)),
    "rejected": Counter("number of samples that were not finite or not plausible", LearnerStatus.REJECTED),
    "outside": Counter("number of displacements outside the identified range", LearnerStatus.OUTSIDE),
    "resting": Counter("number of samples with the input at rest", LearnerStatus.RESTING),
    "outliers": Counter("number of innovations rejected as outliers", LearnerStatus.OUTLIER),
    "changes": Counter("number of runs of outliers that were taken for a change", LearnerStatus.CHANGED),
    "quiet": Counter("number of innovations inside the dead zone", LearnerStatus.QUIET),
    "limited": Counter("number of updates whose step was reduced", LearnerStatus.LIMITED, written_by=("step",)),
    "clamped": Counter("number of updates that limited an element of D", LearnerStatus.CLAMPED),
    "restarts": Counter("number of restarts of the shadow", LearnerStatus.RESTARTED),
}
"""The counters in the order of the struct; each stops at 2^32 - 1."""


class Commit(enum.IntEnum):
    """Return values of `_commit`."""

    BUSY = 0
    COMMITTED = 1
    REFUSED_YOUNG = 2
    REFUSED_LIMIT = 3
    REFUSED_GAIN = 4
    REFUSED_SLOPE = 5


COMMIT_MEANINGS = {
    Commit.BUSY: "The commit is not finished; call again.",
    Commit.COMMITTED: "The shadow's parameters are active.",
    Commit.REFUSED_YOUNG: "The shadow has had too few updates since its restart.",
    Commit.REFUSED_LIMIT: "A parameter is not finite or beyond its limit.",
    Commit.REFUSED_GAIN: "The gain b(y) would come too close to zero or change its sign.",
    Commit.REFUSED_SLOPE: "The slope |df/dy| would come too close to 1.",
}


class Phase(enum.IntEnum):
    """Phases of a commit: the member `phase` of a candidate."""

    IDLE = 0
    CHECK = 1
    WRITE = 2
    SWITCH = 3


PHASE_MEANINGS = {
    Phase.IDLE: "No commit is under way; the next call copies the shadow.",
    Phase.CHECK: "The next call examines check points.",
    Phase.WRITE: "The next call writes the candidate into the idle bank.",
    Phase.SWITCH: "The next call makes the written bank active.",
}


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
