"""Certificates of a model over its operating range, y in [y_min, y_max] and w in the range of the input of its rules.

    simulation   |df/dy| < 1: two free runs under the same input converge, for any initial states; w is bounded
    gain         b(y) = df/dw has one sign, and |b(y)| >= 1 % of its largest value: Eq. (11) may divide by it
    inverse      the gain holds, and each block of the path that the inverse solves has a stable inverse

Without a path, w is the voltage and b is in um/V; behind a hysteresis w and b are in um and um/um. w never leaves its
range: it is limited to the response of the path to all commands of the input range (`Model.w_range`). Disturbances do
not depend on the input, so they move the inverse but cannot destabilise it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.certify.enclosure import Extremum, gain_extrema, slope, slope_extremum
from hysgen.certify.path_inverse import PathInverse, path_inverse
from hysgen.display import Displayed, Summary
from hysgen.machine.reproducible import geometric, rounded_down, rounded_up
from hysgen.model.model import Model

Floats = NDArray[np.float64]

SMALLEST_GAIN_RATIO = 0.01
"""Smallest ratio of the least |b| to the largest |b| for which the inverse is certified."""

DIGITS = 12
"""Significant digits of every bound, rounded outward, so that it remains a bound."""


@dataclass(frozen=True, repr=False)
class Certificates(Displayed):
    """The certificates of a model, with the points of their extrema.

    w_range: inputs of the rules, in w_unit ("V" or "um"). gain_lowest, gain_highest: extrema of b(y) in um per w_unit.
    slope: the largest |df/dy|. contracting: the w for which contraction holds, None if there are none inside the range.
    path: of the inverse of the blocks before the rules.
    """

    y_range_um: tuple[float, float]
    w_range: tuple[float, float]
    w_unit: str
    gain_lowest: Extremum
    gain_highest: Extremum
    slope: Extremum
    contracting: tuple[float, float] | None
    path: PathInverse

    @property
    def gain_holds(self) -> bool:
        """b(y) has one sign, and its least magnitude is above SMALLEST_GAIN_RATIO of its largest."""
        low, high = self.gain_lowest.bound, self.gain_highest.bound
        weakest, strongest = (low, high) if high > 0.0 else (-high, -low)
        return weakest > SMALLEST_GAIN_RATIO * strongest

    @property
    def contraction_holds(self) -> bool:
        """|df/dy| < 1 over the whole range."""
        return self.slope.bound < 1.0

    @property
    def inverse_holds(self) -> bool:
        """Eq. (11) has a solution, and so has every block that the inverse solves: gain and path hold."""
        return self.gain_holds and self.path.holds

    @property
    def w_name(self) -> str:
        """Symbol of the input of the rules: u without a response in the path, w behind one."""
        return "u" if self.w_unit == "V" else "w"

    def summary(self) -> Summary:
        """Content of the display."""
        answers = {"gain": self.gain_holds, "contraction": self.contraction_holds, "inverse": self.inverse_holds}
        title = "; ".join(f"{name} {'holds' if holds else 'NOT certified'}" for name, holds in answers.items())
        return Summary(f"certificates: {title}", first=self.lines())

    def lines(self) -> tuple[str, ...]:
        """One line of text per certificate."""
        return (self._gain_line(), self._contraction_line(), self._inverse_line())

    def _gain_line(self) -> str:
        low, high = self.gain_lowest, self.gain_highest
        unit = f"um/{self.w_unit}"
        at = f"gain {low.value:.4g} (y = {low.y_um:.4g} um) .. {high.value:.4g} (y = {high.y_um:.4g} um) {unit}"
        if not self.gain_holds:
            return f"{at}: NOT certified, no inverse can be emitted"
        if high.bound < 0.0:
            return f"{at}: of one sign, but negative: the model falls as {self.w_name} rises; check the record's signs"
        return f"{at}: holds"

    def _contraction_line(self) -> str:
        slope, unit = self.slope, self.w_unit
        at = f"slope at most {slope.bound:.4f} (y = {slope.y_um:.4g} um, {self.w_name} = {slope.w:.4g} {unit})"
        if self.contraction_holds:
            low, high = self.w_range
            return f"{at}: contraction holds, {self.w_name} within {low:.4g} .. {high:.4g} {unit}"
        if self.contracting is None:
            return f"{at}: contraction NOT certified at any {self.w_name}, the free run is not to be trusted"
        low, high = self.contracting
        return (
            f"{at}: contraction certified for {low:.4g} .. {high:.4g} {unit} only, no free run is to be trusted beyond"
        )

    def _inverse_line(self) -> str:
        line = "inverse: " + "; ".join(["Eq. (11)", *self.path.parts()])
        if not self.gain_holds:
            return f"{line}: NOT certified, for the gain is not"
        return f"{line}: {'holds' if self.inverse_holds else 'NOT certified, a voltage may not exist or may build up'}"

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "y_range_um": list(self.y_range_um),
            "w_range": list(self.w_range),
            "w_unit": self.w_unit,
            "gain": {
                "holds": self.gain_holds,
                "lowest": self.gain_lowest.to_json(),
                "highest": self.gain_highest.to_json(),
                "unit": f"um/{self.w_unit}",
            },
            "contraction": {
                "holds": self.contraction_holds,
                "slope": self.slope.to_json(),
                "inputs": list(self.contracting) if self.contracting else None,
            },
            "inverse": {"holds": self.inverse_holds, **self.path.to_json()},
        }


def certify(model: Model) -> Certificates:
    """Compute every certificate of `model` over its own ranges."""
    lowest, highest = gain_extrema(model)
    lowest = dataclasses.replace(lowest, bound=rounded_down(lowest.bound, DIGITS))
    highest = dataclasses.replace(highest, bound=rounded_up(highest.bound, DIGITS))
    steepest = slope_extremum(model)
    steepest = dataclasses.replace(steepest, bound=rounded_up(steepest.bound, DIGITS))
    ends = (model.w_range.low, model.w_range.high)
    return Certificates(
        y_range_um=(model.grid.y_min_um, model.grid.y_max_um),
        w_range=ends,
        w_unit=model.w_unit,
        gain_lowest=lowest,
        gain_highest=highest,
        slope=steepest,
        contracting=ends if steepest.bound < 1.0 else _contracting_inputs(model),
        path=path_inverse(model),
    )


def _contracting_inputs(model: Model) -> tuple[float, float] | None:
    """The part of the range of w over which contraction holds; None if it is empty.

    max_y |df/dy| is convex in w, so the inputs form an interval, and bounds that hold at its ends hold between them.
    """
    y = np.linspace(model.grid.y_min_um, model.grid.y_max_um, 200 * model.grid.rules)
    at_zero = slope(model, y, np.zeros_like(y))
    per_unit = slope(model, y, np.ones_like(y)) - at_zero
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.sort(np.stack([(-1.0 - at_zero) / per_unit, (1.0 - at_zero) / per_unit]), axis=0)
    flat = per_unit == 0.0
    if (np.abs(at_zero[flat]) >= 1.0).any():
        return None
    first, last = model.w_range.low, model.w_range.high
    low = max(first, float(np.max(ends[0][~flat], initial=-np.inf)))
    high = min(last, float(np.min(ends[1][~flat], initial=np.inf)))
    # The grid may miss the worst displacement: narrow the interval until the enclosure confirms it.
    for share in geometric(1e-6, 0.5, 40):
        margin = share * (last - first)
        inner = (low if low == first else low + margin, high if high == last else high - margin)
        if inner[0] >= inner[1]:
            return None
        if slope_extremum(model, inner).bound < 1.0:
            return float(inner[0]), float(inner[1])
    return None
