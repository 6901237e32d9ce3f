"""Status of the generated code: sticky bits of the status word, and the counters of the struct."""

from __future__ import annotations

import enum

from hysgen.model.structs import Counter


class Status(enum.IntFlag):
    """Bits of `status`: set at the first occurrence, cleared by the caller or by `_init`."""

    Y_CLAMPED = 1
    U_CLAMPED = 2
    Y_REJECTED = 4
    U_REJECTED = 8
    REFERENCE_CLAMPED = 16
    UNREACHABLE = 32
    AUX_CLAMPED = 64
    AUX_REJECTED = 128
    INVERSE_RESIDUAL = 256


MEANINGS = {
    Status.Y_CLAMPED: "A displacement lay outside the identified range and was limited to it.",
    Status.U_CLAMPED: "A voltage lay outside the input range and was limited to it.",
    Status.Y_REJECTED: "A displacement was not finite; the last good one was used.",
    Status.U_REJECTED: "A voltage was not finite; the last good one was used.",
    Status.REFERENCE_CLAMPED: "A reference lay more than one range away and was limited.",
    Status.UNREACHABLE: "The input that would reach the reference lay beyond what can be applied.",
    Status.AUX_CLAMPED: "An auxiliary channel lay outside its range and was limited to it.",
    Status.AUX_REJECTED: "An auxiliary channel was not finite; its last good sample was used.",
    Status.INVERSE_RESIDUAL: "The voltage leaves more than the stated tolerance of the input of the rules.",
}

COUNTERS = {
    "y_clamped": Counter(
        "number of calls with y outside its range; every counter stops at its largest value", Status.Y_CLAMPED
    ),
    "u_clamped": Counter("number of calls with u outside its range", Status.U_CLAMPED),
    "y_rejected": Counter("number of calls with y not finite", Status.Y_REJECTED),
    "u_rejected": Counter("number of calls with u not finite", Status.U_REJECTED),
}
"""The counters of the struct in its order; each stops at its largest value."""
