"""Status bits and counters of the generated learner, and the return values of `_commit`."""

from __future__ import annotations

import enum

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
