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
    LearnerStatus.REJECTED: "a sample was not finite or not plausible and taught nothing",
    LearnerStatus.OUTSIDE: "a displacement lay outside the identified range and taught nothing",
    LearnerStatus.RESTING: "the input rested and taught nothing",
    LearnerStatus.OUTLIER: "an innovation was an outlier and taught nothing",
    LearnerStatus.CHANGED: "so many outliers in a row that they are none: learnt from",
    LearnerStatus.QUIET: "an innovation lay inside the dead zone and taught nothing",
    LearnerStatus.LIMITED: "a step of the parameters was shortened",
    LearnerStatus.CLAMPED: "a variance was limited",
    LearnerStatus.RESTARTED: "the shadow went back to the reference parameters and the prior",
}

LEARNER_COUNTERS = {
    "updates": Counter("updates that changed the parameters", written_by=("step",)),
    "rejected": Counter("samples that were not finite or not plausible", LearnerStatus.REJECTED),
    "outside": Counter("displacements outside the identified range", LearnerStatus.OUTSIDE),
    "resting": Counter("samples at which the input rested", LearnerStatus.RESTING),
    "outliers": Counter("innovations refused as outliers", LearnerStatus.OUTLIER),
    "changes": Counter("runs of outliers that were accepted as a change", LearnerStatus.CHANGED),
    "quiet": Counter("innovations inside the dead zone", LearnerStatus.QUIET),
    "limited": Counter("updates whose step was shortened", LearnerStatus.LIMITED, written_by=("step",)),
    "clamped": Counter("updates that limited a variance", LearnerStatus.CLAMPED),
    "restarts": Counter("returns to the reference parameters and the prior", LearnerStatus.RESTARTED),
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
    Commit.BUSY: "not done yet: call again",
    Commit.COMMITTED: "the shadow's parameters are active now",
    Commit.REFUSED_YOUNG: "too few updates since the shadow restarted",
    Commit.REFUSED_LIMIT: "a parameter is not finite or beyond its limit",
    Commit.REFUSED_GAIN: "the gain b(y) would come too close to zero or change its sign",
    Commit.REFUSED_SLOPE: "the slope |df/dy| would come too close to 1",
}
