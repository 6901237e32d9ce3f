"""The feedback of a model: what `hysgen loop` designed, as the generated `_correct` computes it, in float32.

    f(k) = F r(k),   c(k) = c(k-1) + K/2 (f(k) + f(k-1)),   |c| <= limit

r is the reference less the reading of the same sample, within the width of the displacement range; c is added to the
reference that the inverse is asked for. c stands still while the last voltage of the inverse is at the end of its
limits that c would move it beyond (anti-windup). F is a `structure`, or 1.
"""

import math
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from hysgen.errors import ModelError
from hysgen.model.float32_arithmetic import KEPT, flushed
from hysgen.model.intervals import Interval, symmetric
from hysgen.model.path.base import Bits, Floats32, limited
from hysgen.model.path.modes_mirror import ModesMirror
from hysgen.model.path.structure import Structure
from hysgen.model.structs import Member, MirroredStruct


@dataclass(frozen=True)
class Feedback:
    """integral: K of a sample, in 0 .. 2; limit_um: largest correction. Raises ModelError if one is not."""

    integral: float
    limit_um: float
    filter: Structure | None = None

    def __post_init__(self) -> None:
        if not (0.0 < self.integral <= 2.0 and 0.0 < self.limit_um < math.inf):
            raise ModelError(
                f"feedback: integral {self.integral} is not in 0 .. 2, or limit_um {self.limit_um} not positive"
            )

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, exact."""
        notches = None if self.filter is None else self.filter.to_json()
        return {"integral": self.integral, "limit_um": self.limit_um, "filter": notches}

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> Self:
        """Inverse of to_json. Raises ModelError on malformed data."""
        try:
            notches = data["filter"]
            known = None if notches is None else Structure.from_json(notches)
            return cls(float(data["integral"]), float(data["limit_um"]), known)
        except (KeyError, TypeError, ValueError) as fault:
            raise ModelError(f"feedback: {fault}; write it with `hysgen loop MODEL -o NEW`") from fault

    @property
    def half(self) -> np.float32:
        """K/2."""
        return np.float32(0.5 * self.integral)

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the correction in float32, in um."""
        return -float(np.float32(self.limit_um)), float(np.float32(self.limit_um))

    @property
    def modes(self) -> int:
        """Number of modes of the filter."""
        return 0 if self.filter is None else len(self.filter.f_Hz)

    def members(self) -> tuple[Member, ...]:
        """What the C keeps."""
        own = (
            Member("correction_um", "float", "last correction", unit="um"),
            Member("before_um", "float", "residual behind the filter, a sample before", unit="um"),
            Member("half", "float", "half the integral of a sample; a caller may set another, 0 to 1"),
        )
        parts = ("position", "velocity")
        modes = (
            Member(part, "float", f"{part} of each mode of the filter", (self.modes,), unit="um") for part in parts
        )
        return (*own, *modes) if self.modes else own

    def box(self, reach_um: float, Ts_s: float) -> dict[str, Interval]:
        """What no call leaves, by C path, for residuals up to reach_um."""
        before = symmetric(reach_um) if self.filter is None else self.filter.box(symmetric(reach_um), Ts_s).through
        boxes = {word.path: KEPT for member in self.members() for word in member.words()}
        own = {"correction_um": symmetric(self.limit_um).outwards(), "before_um": before.outwards()}
        return boxes | own | {"half": Interval(0.0, 1.0)}


class FeedbackMirror(MirroredStruct):
    """The float32 reference over lanes; without feedback it has no word."""

    def __init__(self, feedback: Feedback | None, lanes: int, Ts_s: float) -> None:
        self._feedback = feedback
        self.members = () if feedback is None else feedback.members()
        self.correction_um, self.before_um = (np.zeros(lanes, dtype=np.float32) for _ in range(2))
        self.half = np.full(lanes, np.float32(0.0) if feedback is None else feedback.half)
        modes = 0 if feedback is None else feedback.modes
        self.position, self.velocity = ([np.zeros(lanes, dtype=np.float32)] * modes for _ in range(2))
        self._filter: ModesMirror | None = None
        if feedback is not None and feedback.filter is not None:
            self._filter = feedback.filter.mirror(self.before_um, Ts_s)

    def apply(self, residual_um: Floats32, at_top: Bits, at_bottom: Bits) -> Floats32:
        """c(k) in um; at_top, at_bottom: 1 where the voltage cannot raise or lower the displacement further."""
        assert self._feedback is not None
        moves = residual_um
        if self._filter is not None:
            moves = flushed(self._filter.direct * residual_um + self._filter.moving(self.position, self.velocity))
            self.position, self.velocity = self._filter.moved(self.position, self.velocity, residual_um)
        step = flushed(self.half * (moves + self.before_um))
        limit = np.float32(self._feedback.limit_um)
        winds = ((at_top != 0) & (step > 0.0)) | ((at_bottom != 0) & (step < 0.0))
        moved = flushed(limited(self.correction_um + step, -limit, limit))
        self.before_um, self.correction_um = moves, np.where(winds, self.correction_um, moved)
        return self.correction_um
