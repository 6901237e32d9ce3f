"""Certificates of a model over its operating range, y in [y_min, y_max] and w in the range of the input of its rules.

    simulation   |df/dy| < 1: two free runs under the same input converge, for any initial states; w is bounded
    gain         b(y) = df/dw has one sign, and |b(y)| >= 1 % of its largest value: Eq. (11) may divide by it
    inverse      the gain holds, and each block of the path that the inverse solves has a stable inverse

Without a path, w is the voltage and b is in um/V; behind a hysteresis w and b are in um and um/um. w never leaves its
range: it is limited to the response of the path to all commands of the input range (`Model.w_range`). Disturbances do
not depend on the input, so they move the inverse but cannot destabilise it.

A model as a dynamic system: time constant, steady states, and the area of its loop at low frequency.

    time constant   tau = -Ts / ln(df/dy)           in the steady state under a constant input
    DC gain         dy/du along the steady-state line y = f(y, u) + w(u)
    loop            periodic response to u = centre + A sin(2 pi f t): area = closed integral of y du,
                    filling = area / bounding box; pi/4 for an ellipse, 0 for a line

As the frequency falls, the loop of hysteresis stays open and the loop of a lag closes: this distinguishes a model with
memory from one without.
"""

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.certify.enclosure import Extremum, gain_extrema, slope, slope_extremum
from hysgen.certify.path_inverse import PathInverse, path_inverse
from hysgen.display import Displayed, Summary
from hysgen.errors import ModelError
from hysgen.machine.reproducible import geometric, rounded_down, rounded_up
from hysgen.model.disturbances import Drive
from hysgen.model.model import Model
from hysgen.model.path import applied
from hysgen.model.simulate import simulate

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


LEVELS = 8
"""Constant inputs at which the steady states are computed."""

PER_DECADE = 4
SAMPLES_PER_PERIOD = 20
"""Least samples per period of a sine: with fewer, the area of its loop is meaningless."""

MOST_SAMPLES = 4_000_000
CLOSED = 0.05
"""A loop is closed if its filling at the lowest frequency is below this part of its largest filling."""


@dataclass(frozen=True)
class SteadyState:
    """Steady state under u_V: y_um, slope df/dy, time constant tau_s (None where the slope is not in 0..1), DC gain.

    inside: whether y lies inside the grid; outside it the next y does not depend on y.
    """

    u_V: float
    y_um: float
    slope: float
    tau_s: float | None
    gain_um_per_V: float
    inside: bool


@dataclass(frozen=True)
class Loop:
    """The periodic loop under a sine of f_Hz: area in um V, filling (area over bounding box), span of y in um."""

    f_Hz: float
    area_umV: float
    filling: float
    span_um: float


@dataclass(frozen=True, repr=False)
class Dynamics(Displayed):
    """Steady states of a model, and its loops under sines of `amplitude_V` about `centre_V`."""

    model: str
    steady_states: tuple[SteadyState, ...]
    loops: tuple[Loop, ...]
    centre_V: float
    amplitude_V: float

    @property
    def has_memory(self) -> bool:
        """Whether the loop is still open at the lowest frequency."""
        largest = max(loop.filling for loop in self.loops)
        return largest > 0.0 and self.loops[0].filling > CLOSED * largest

    def summary(self) -> Summary:
        """Content of the display."""
        title, *first = self.describe().splitlines()
        return Summary(title, first=first)

    def describe(self) -> str:
        """A few lines of text."""
        taus = [state.tau_s for state in self.steady_states if state.tau_s is not None and state.inside]
        gains = [state.gain_um_per_V for state in self.steady_states if state.inside]
        first, last = self.steady_states[0], self.steady_states[-1]
        lines = [
            f"{self.model}: first-order lag, time constant {_range(taus, 's')}; DC gain {_range(gains, 'um/V')}",
            f"rest line: {first.y_um:.4g} um at {first.u_V:.4g} V .. {last.y_um:.4g} um at {last.u_V:.4g} V",
            f"loop under {self.amplitude_V:.4g} V sines about {self.centre_V:.4g} V (part of its box filled, area):",
        ]
        lines += [
            f"  {loop.f_Hz:9.4g} Hz  {100.0 * loop.filling:6.2f} %  {loop.area_umV:10.4g} um V" for loop in self.loops
        ]
        lines.append(
            "the loop stays open as the frequency falls: the model has memory"
            if self.has_memory
            else "the loop closes as the frequency falls: a lag, not hysteresis"
        )
        return "\n".join(lines)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "model": self.model,
            "rests": [vars(state) for state in self.steady_states],
            "loops": [vars(loop) for loop in self.loops],
            "centre_V": self.centre_V,
            "amplitude_V": self.amplitude_V,
            "remembers": self.has_memory,
        }


def dynamics(model: Model, f_Hz: Sequence[float] | None = None, amplitude_V: float | None = None) -> Dynamics:
    """Steady states and loops of a model over its input range.

    f_Hz: rising frequencies of the sines; default: from a thousandth of the corner frequency of the slowest lag on.
    amplitude_V: default 0.45 of the input range. Raises ModelError if a frequency is above a 20th of the sampling rate.
    """
    states = steady_states(model, np.linspace(model.u_min_V, model.u_max_V, LEVELS))
    centre = 0.5 * (model.u_min_V + model.u_max_V)
    amplitude = 0.45 * (model.u_max_V - model.u_min_V) if amplitude_V is None else amplitude_V
    chosen = default_frequencies(model, states) if f_Hz is None else list(f_Hz)
    return Dynamics(model.name, states, tuple(loop(model, f, centre, amplitude) for f in chosen), centre, amplitude)


def steady_states(model: Model, u_V: Floats) -> tuple[SteadyState, ...]:
    """The steady state of rules and terms under each of the constant inputs u_V, (n,)."""
    step = 1e-4 * (model.u_max_V - model.u_min_V)
    states = []
    for u in u_V:
        low, high = max(u - step, model.u_min_V), min(u + step, model.u_max_V)
        y, y_low, y_high = (_steady_displacement(model, float(level)) for level in (u, low, high))
        inside = model.grid.y_min_um <= y <= model.grid.y_max_um
        w = applied(model.blocks, np.array([u]), model.Ts_s, model.w_range)
        a = float(slope(model, np.array([y]), w)[0]) if inside else 0.0
        tau = -model.Ts_s / math.log(a) if 0.0 < a < 1.0 else None
        states.append(SteadyState(float(u), y, a, tau, float((y_high - y_low) / (high - low)), inside))
    return tuple(states)


def loop(model: Model, f_Hz: float, centre_V: float, amplitude_V: float) -> Loop:
    """The loop of the model under a sine, after the transients of its lag have decayed.

    Raises ModelError if the frequency is above a 20th of the sampling rate, or if the simulation would take too long.
    """
    per_period = 1.0 / (f_Hz * model.Ts_s)
    if per_period < SAMPLES_PER_PERIOD:
        raise ModelError(f"{model.name}: {f_Hz:g} Hz is above a {SAMPLES_PER_PERIOD}th of its rate; choose less")
    # The nearest frequency with a whole number of samples per period, so that the loop closes on a sample.
    period = round(per_period)
    if 3 * period > MOST_SAMPLES:
        raise ModelError(f"{model.name}: {f_Hz:g} Hz takes {3 * period} samples; choose a higher frequency")
    periods = 3 + math.ceil(_transient_samples(model) / period)
    k = np.arange(periods * period + 1)
    u = centre_V + amplitude_V * np.sin(2.0 * np.pi * k / period)
    run = simulate(model, _drive(model, u), _steady_displacement(model, centre_V))
    y, u = run.y_um[-period - 1 :], u[-period - 1 :]
    area = abs(float(np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(u))))
    span = float(np.ptp(y))
    box = span * float(np.ptp(u))
    return Loop(1.0 / (period * model.Ts_s), area, area / box if box > 0.0 else 0.0, span)


def default_frequencies(model: Model, steady_states: Sequence[SteadyState]) -> list[float]:
    """Log-spaced from a thousandth of the corner frequency of the slowest lag to a 20th of the sampling rate."""
    taus = [state.tau_s for state in steady_states if state.tau_s is not None]
    highest = 1.0 / (SAMPLES_PER_PERIOD * model.Ts_s)
    slowest = max(taus, default=10.0 * model.Ts_s)
    lowest = max(1e-3 / (2.0 * math.pi * slowest), 3.0 / (MOST_SAMPLES * model.Ts_s) * 1.01)
    count = max(2, 1 + round(PER_DECADE * math.log10(highest / lowest)))
    return [float(f) for f in np.geomspace(lowest, highest, count)]


def _steady_displacement(model: Model, u_V: float) -> float:
    """Steady y in um under a constant input, or y after 100 000 samples if the simulation does not converge."""
    y = 0.5 * (model.grid.y_min_um + model.grid.y_max_um)
    for samples in (1_000, 10_000, 100_000):
        last = simulate(model, _drive(model, np.full(samples, u_V)), y).y_um
        y = float(last[-1])
        if abs(y - last[-2]) < 1e-13 * max(1.0, abs(y)):
            break
    return y


def _transient_samples(model: Model) -> float:
    """Samples until the initial state has decayed by exp(-10), for the largest |df/dy| at mid-input."""
    y = np.linspace(model.grid.y_min_um, model.grid.y_max_um, 4 * model.grid.rules)
    middle = np.full_like(y, 0.5 * (model.w_range.low + model.w_range.high))
    steepest = min(float(np.abs(slope(model, y, middle)).max()), 0.9999)
    return 10.0 / (1.0 - steepest)


def _drive(model: Model, u_V: Floats) -> Drive:
    """An input with all auxiliary channels at zero."""
    channels = {name: np.zeros(u_V.size) for term in model.terms for name in term.channels}
    return Drive(u_V, model.Ts_s, channels)


def _range(values: Sequence[float], unit: str) -> str:
    """'low .. high unit', one number if both are written the same, or 'none' without values."""
    ends = list(dict.fromkeys(f"{end:.3g}" for end in (min(values), max(values)))) if values else []
    return f"{' .. '.join(ends)} {unit}" if ends else "none"
