"""What the generated code reports of a sample: sticky bits of the status word, and the counters beside it."""

from __future__ import annotations

import enum


class Status(enum.IntFlag):
    """Bits of `status`; set when it happened at least once, cleared by the caller or by `_init`."""

    Y_CLAMPED = 1
    U_CLAMPED = 2
    Y_REJECTED = 4
    U_REJECTED = 8
    REFERENCE_CLAMPED = 16
    UNREACHABLE = 32
    AUX_CLAMPED = 64
    AUX_REJECTED = 128


MEANINGS = {
    Status.Y_CLAMPED: "a displacement lay outside the identified range and was limited to it",
    Status.U_CLAMPED: "a voltage lay outside the input range and was limited to it",
    Status.Y_REJECTED: "a displacement was not finite; the last good one was used",
    Status.U_REJECTED: "a voltage was not finite; the last good one was used",
    Status.REFERENCE_CLAMPED: "a reference lay more than one range away and was limited",
    Status.UNREACHABLE: "the input that would reach the reference lay beyond what can be applied",
    Status.AUX_CLAMPED: "an auxiliary channel lay outside its range and was limited to it",
    Status.AUX_REJECTED: "an auxiliary channel was not finite; its last good sample was used",
}

# Each counter of the struct, in its order, and the bit that goes with it. They stop at their largest value.
COUNTERS = {
    "y_clamped": Status.Y_CLAMPED,
    "u_clamped": Status.U_CLAMPED,
    "y_rejected": Status.Y_REJECTED,
    "u_rejected": Status.U_REJECTED,
}
