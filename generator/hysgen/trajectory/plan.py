"""The voltage for a reference: exact where the stage can follow, of least largest error inside the limits elsewhere."""

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.display import Displayed, Summary
from hysgen.errors import ModelError
from hysgen.model.model import Model
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.trajectory.inverse import (
    CORRECTIONS,
    corrected_inverse,
    in_whole_samples,
    inverse,
    own_response,
    preview_samples,
    rest_voltage,
    without_unstable,
)
from hysgen.trajectory.limits import MEAN_SQUARE, MOVED, REACHED, Limits, best_within, clipped, limits_of
from hysgen.trajectory.reference import Sampled

Floats = NDArray[np.float64]

SETTLED, MOST_SAMPLES, RUN_IN = 1e-7, 100_000, 20
"""Share of a slow state that a steady state may still lack, samples until then at most, periods at least."""

LOOP_SAMPLES, AHEAD = 2000, 400
"""Least samples of each stroke of a loop before the reference: slow beside the modes and lags of a stage; and those of
its end that limits may move."""

PROBABLE = 1.96
"""Standard deviations within which 95 % of normal errors lie."""


@dataclass(frozen=True)
class Learning:
    """What the repeats so far teach. rms_um: error of each voltage that was played, over the mean of its plays.

    noise_um: rms of what does not repeat. base: the voltage, from 1, that the next one starts from. highest_Hz: up to
    where the next one learns, None where nothing is. leaves: largest share of the rms of what it learns that the next
    one leaves, in 95 % of what the stage may be. stays_um: rms of what repeats at frequencies that it does not learn.
    """

    rms_um: tuple[float, ...]
    noise_um: float
    base: int
    highest_Hz: float | None
    leaves: float
    stays_um: float

    @property
    def predicted_um(self) -> float:
        """Rms error of the next repeat at most: noise, what is not learnt, and what learning may leave of the rest."""
        known = self.noise_um**2 + self.stays_um**2
        return math.sqrt(known + self.leaves**2 * max(self.rms_um[self.base - 1] ** 2 - known, 0.0))

    @property
    def diverges(self) -> bool:
        """Whether the last repeat was worse than one before it, or the model is too wrong to learn with."""
        return self.base < len(self.rms_um) or self.leaves >= 1.0

    def lines(self) -> list[str]:
        """Errors of the repeats, and what the next one does."""
        errors = "; ".join(f"{rms_um:.4g} um" for rms_um in self.rms_um)
        lines = [f"repeats so far: {errors} rms; what does not repeat: {self.noise_um:.3g} um"]
        if self.base < len(self.rms_um):
            lines.append(
                f"the last repeat is WORSE: repeat {self.base} is the base; where errors grew, nothing is learnt"
            )
        if self.stays_um > 0.0:
            lines.append(
                f"not learnt: {self.stays_um:.3g} um rms, near the noise or where the stage is not known enough"
            )
        if self.leaves >= 1.0:
            return [*lines, "NOT learnt: the model is wrong by most of what the stage moves; refit it with the repeat"]
        if self.highest_Hz is None:
            return [*lines, "at the noise: nothing that repeats is left to learn"]
        return [
            *lines,
            f"learns up to {self.highest_Hz:.4g} Hz; at most {100 * self.leaves:.2g} % of what it learns is left",
        ]


@dataclass(frozen=True, eq=False, repr=False)
class Waveform(Displayed):
    """u_V: (n,) voltages from start_s on, every Ts_s; the reference, (m,), begins `lead` samples later.

    asked_um: (n,) the reference of a loop around the emitted inverse (`without_unstable`). y_um: (m,) displacement that
    the model answers. largest_um: the largest error that the limits leave; clipped_um: that of the exact voltage cut at
    its limits, None where nothing is cut. spans_s: from .. to where the error is above REACHED. broken: names of the
    limits that the exact voltage exceeds. model_rms_um, model_largest_um: errors of the model on the record that
    identified it, None if its file does not say. periodic: u_V is one period.
    """

    model: str
    reference: Sampled
    u_V: Floats
    asked_um: Floats
    y_um: Floats
    Ts_s: float
    lead: int
    limits: Limits
    broken: tuple[str, ...]
    largest_um: float
    clipped_um: float | None
    spans_s: tuple[tuple[float, float], ...]
    model_rms_um: float | None
    model_largest_um: float | None
    periodic: bool
    remarks: tuple[str, ...]
    learning: Learning | None = None

    @property
    def holds(self) -> bool:
        """Whether the reference is reached, and no repeat was worse than one before it."""
        return self.reached and not (self.learning is not None and self.learning.diverges)

    @property
    def reached(self) -> bool:
        """Whether the model follows the reference within REACHED."""
        return not self.spans_s

    @property
    def start_s(self) -> float:
        """Time of the first voltage."""
        return self.reference.start_s - self.lead * self.Ts_s

    @property
    def time_s(self) -> Floats:
        """(n,) times of the voltages."""
        return self.start_s + self.Ts_s * np.arange(self.u_V.size, dtype=np.float64)

    @property
    def rms_um(self) -> float:
        """Rms of what the limits leave."""
        return float(np.sqrt(np.mean((self.y_um - self.reference.values) ** 2)))

    @property
    def beside_um(self) -> float | None:
        """Predicted rms error beside that by limits: of the model on its record or, which says more, of repeats."""
        return self.model_rms_um if self.learning is None else self.learning.predicted_um

    @property
    def predicted_um(self) -> float | None:
        """Predicted rms error of the stage: what the limits leave, and what is beside it, as independent errors."""
        return None if self.beside_um is None else math.hypot(self.rms_um, self.beside_um)

    def summary(self) -> Summary:
        """What is reached, where not and why, and the predicted error."""
        lines = [*([] if self.learning is None else self.learning.lines()), *self.remarks]
        u_V = f"{self.u_V.min():.4g} .. {self.u_V.max():.4g} V"
        ahead = "one period" if self.periodic else f"begins {1e3 * self.lead * self.Ts_s:.4g} ms before the reference"
        lines.append(f"voltage: {u_V}, {self.u_V.size} samples every {1e6 * self.Ts_s:.6g} us, {ahead}")
        if self.beside_um is None:
            lines.append("predicted error of the stage: unknown, for the model file holds no score; --learn a play")
        else:
            within_um = self.largest_um + PROBABLE * self.beside_um
            own_um = self.model_largest_um
            own = "" if own_um is None else f"; the largest of the model on its own record is {own_um:.4g} um"
            total = f"{self.predicted_um:.4g} um rms, 95 % of it within +-{within_um:.4g} um{own}"
            lines.append(f"predicted error of the stage: {total}")
        return Summary(f"{self.reference.source}: {self._verdict()}", first=lines)

    def _verdict(self) -> str:
        if self.reached:
            return f"reached within {self.largest_um:.2g} um"
        first = "; ".join(f"{a:.6g} .. {b:.6g} s" for a, b in self.spans_s[:3])
        more = f" and {len(self.spans_s) - 3} more spans" if len(self.spans_s) > 3 else ""
        why = f" for the limit of {' and '.join(self.broken)}" if self.broken else " by the inverse of this model"
        cut_um = self.clipped_um
        cut = "" if cut_um is None else f"; cut at the limits, the voltage would miss it by {cut_um:.4g} um"
        return f"CANNOT be reached{why}: missed by up to {self.largest_um:.4g} um at {first}{more}{cut}"

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        limits = self.limits
        return {
            "model": self.model,
            "reference": self.reference.source,
            "samples": int(self.u_V.size),
            "Ts_s": self.Ts_s,
            "start_s": self.start_s,
            "periodic": self.periodic,
            "voltage_V": [float(self.u_V.min()), float(self.u_V.max())],
            "limits": {
                "voltage_V": [limits.low_V, limits.high_V],
                "slew_V_s": limits.slew_V_s,
                "acceleration_V_s2": limits.acceleration_V_s2,
                "exceeded": list(self.broken),
            },
            "reached": self.reached,
            "largest_um": self.largest_um,
            "rms_um": self.rms_um,
            "clipped_um": self.clipped_um,
            "spans_s": [list(span) for span in self.spans_s],
            "predicted": {
                "rms_um": self.predicted_um,
                "model_rms_um": self.model_rms_um,
                "model_largest_um": self.model_largest_um,
            },
            "remarks": list(self.remarks),
            "learning": None if self.learning is None else asdict(self.learning) | {"diverges": self.learning.diverges},
        }


def plan(
    model: Model,
    reference: Sampled,
    given: Limits | None = None,
    periodic: bool = False,
    loop: bool = False,
    last_V: Floats | None = None,
) -> Waveform:
    """The voltage for a reference from rest at its first value, or one period of its steady state.

    loop: begin with the whole range of the voltage, low, high and low again, after which the stage remembers nothing
    else, and go to the first value from there. last_V: the voltage that was played, (n,), for that of the next repeat:
    inside limits that bind it moves from there, to the least mean square of the error.

    Raises ModelError for limits that leave no voltage, or for a model that has no inverse.
    """
    stage, limits = own_response(model), limits_of(model, given)
    if not limits.low_V < limits.high_V:
        raise ModelError(
            f"voltage: {limits.low_V:g} .. {limits.high_V:g} V lies outside the model's {model.u_min_V:g} .. "
            f"{model.u_max_V:g} V; choose a part of it"
        )
    wanted = reference.values
    remarks = [*reference.remarks]
    if model.terms:
        remarks.append(f"not compensated, for its phase is not known: {', '.join(term.kind for term in model.terms)}")
    if any(isinstance(block, Hysteresis) for block in model.blocks) and not (loop or periodic):
        remarks.append("the stage is taken to come from rest; if it remembers other voltages, begin with a loop")
    planned, part = in_whole_samples(stage)
    # What is learnt begins with the answer of the model that is planned with.
    part = 0.0 if last_V is not None else part
    aim = wanted + part * np.diff(wanted, append=wanted[0] if periodic else wanted[-1])
    made = _period(planned, aim, limits) if periodic else _from_rest(planned, aim, limits, loop, last_V)
    volts, y, lead, cut_um, broken = made
    if part > 0.0:
        y = stage.simulate(np.tile(volts, RUN_IN if periodic else 1))[-wanted.size :]
    error = np.abs(y - wanted)
    span_um = float(np.ptp(wanted)) or model.grid.y_max_um - model.grid.y_min_um
    own = model.scores.get("identification", {}).get("own", {})
    return Waveform(
        model.name,
        reference,
        volts,
        without_unstable(stage).simulate(volts),
        y,
        model.Ts_s,
        lead,
        limits,
        broken,
        float(error.max()),
        cut_um,
        _spans(error > REACHED * span_um, reference.start_s, model.Ts_s),
        own.get("e_rms_um"),
        own.get("largest_um"),
        periodic,
        tuple(remarks),
    )


Made = tuple[Floats, Floats, int, float | None, tuple[str, ...]]
"""Voltages, what the model answers along the reference, samples before it, error of the cut voltage, limits broken."""


def lead_samples(stage: Model, wanted: Floats, limits: Limits, loop: bool) -> int:
    """Samples of the voltage before the first one of the reference."""
    return preview_samples(in_whole_samples(stage)[0]) + (_loop(stage, wanted, limits).size if loop else 0)


def _loop(stage: Model, wanted: Floats, limits: Limits) -> Floats:
    """Displacement of a loop from the least voltage over the range and on to the reference.

    A stroke is half a cosine: largest slope pi/2 range/T, largest second derivative pi^2/2 range/T^2.
    """
    range_V = limits.high_V - limits.low_V
    times_s = [
        LOOP_SAMPLES * stage.Ts_s,
        0.0 if limits.slew_V_s is None else 0.5 * math.pi * range_V / limits.slew_V_s,
        0.0 if limits.acceleration_V_s2 is None else math.pi * math.sqrt(0.5 * range_V / limits.acceleration_V_s2),
    ]
    count = math.ceil(max(times_s) / stage.Ts_s)
    rise = 0.5 * (1.0 - np.cos(np.pi * np.arange(count) / count))
    course = stage.simulate(limits.low_V + range_V * np.concatenate([rise, 1.0 - rise, np.zeros(2 * count)]))
    # From what rings on, and not from where it is: to stop it at once would take voltages below the least.
    course[-count:] += (wanted[0] - course[-count:]) * rise
    return course


def _from_rest(stage: Model, wanted: Floats, limits: Limits, loop: bool, last_V: Floats | None) -> Made:
    before, rest_V = (_loop(stage, wanted, limits), limits.low_V) if loop else (np.zeros(0), None)
    before = np.concatenate([before, np.full(preview_samples(stage), wanted[0])])
    # What a loop leaves behind is the past: its voltages stay, but for the last ones on the way to the reference, which
    # limits move.
    first = before.size - preview_samples(stage) - (AHEAD if loop else 0)
    course = np.concatenate([before, wanted, np.full(preview_samples(stage) + 1, wanted[-1])])
    scored = slice(before.size, before.size + wanted.size)
    volts, answer, cut_um, broken = _limited(stage, course, limits, scored, scored, first, rest_V, last_V)
    return volts[: scored.stop], answer[scored], before.size, cut_um, broken


def _period(stage: Model, wanted: Floats, limits: Limits) -> Made:
    """One period of the voltage that is played from rest under its first value until the stage is in its steady state.

    What the stage remembers of its beginning is found by playing: the reference is corrected by what it changes. Before
    the periods of the inverse stand a rest at the mean, where slow states stay, and half a cosine.
    """
    period, lead, slowest = wanted.size, preview_samples(stage), 1.0
    for block in stage.blocks:
        space = block.state_space(stage.Ts_s)
        slowest = slowest if space is None else max(slowest, -1.0 / math.log(np.abs(np.linalg.eigvals(space[0])).max()))
    repeats = RUN_IN + math.ceil(min(-slowest * math.log(SETTLED), MOST_SAMPLES) / period)
    ramp = 0.5 * (1.0 - np.cos(np.pi * np.arange(period) / period))
    last = lead + repeats * period
    aim, best = wanted, None
    for _ in range(CORRECTIONS):
        begin = aim.mean() + (aim[0] - aim.mean()) * ramp
        course = np.concatenate([np.full(lead, aim.mean()), begin, np.tile(aim, repeats), np.full(lead + 1, aim[-1])])
        volts, _, cut_um, broken = _limited(stage, course, limits, slice(last - period, last), slice(0, last), 0)
        volts = volts[last - period : last]
        y = stage.simulate(np.tile(volts, repeats))[-period:]
        missed = float(np.abs(y - wanted).max())
        if best is not None and not missed < 0.5 * best[0]:
            break
        best = missed, (volts, y, 0, cut_um, broken)
        if broken:
            break
        aim = aim + (wanted - y)
    assert best is not None
    return best[1]


def _limited(
    stage: Model,
    course: Floats,
    limits: Limits,
    scored: slice,
    counted: slice,
    first: int,
    rest_V: float | None = None,
    last_V: Floats | None = None,
) -> tuple[Floats, Floats, float | None, tuple[str, ...]]:
    """Voltages and answer along a course that begins and ends at rest, error of the cut voltage, limits broken."""
    if rest_V is None:
        rest_V = min(max(rest_voltage(stage, float(course[0])), limits.low_V), limits.high_V)
    volts, answer = corrected_inverse(stage, course, rest_V)
    volts[0] = rest_V
    broken = limits.broken(volts, stage.Ts_s)
    # The inverse of a hysteresis ends where its range does, within rounding.
    near_V = MOVED * (limits.high_V - limits.low_V)
    ends = (volts < limits.low_V + near_V) | (volts > limits.high_V - near_V)
    if ends[scored].any() and np.abs(answer - course)[scored].max() > REACHED * np.ptp(course[scored]):
        broken = broken or ("voltage",)
    if not broken:
        return np.clip(volts, limits.low_V, limits.high_V), answer, None, broken
    cut = clipped(volts, limits, stage.Ts_s)
    cut_um = float(np.abs(stage.simulate(np.append(cut, cut[-1])) - course)[scored].max())
    if last_V is None:
        # What leaves out the blocks that have no stable inverse, as the emitted one does, may be nearer when it is cut.
        emitted = inverse(without_unstable(stage), course, rest_V)
        emitted[0] = rest_V
        return *best_within(stage, course, [volts, emitted], limits, scored, counted, first), cut_um, broken
    # What a play measured of a loop holds the noise of a monitor: the planned one stays.
    last_V = np.concatenate([volts[:first], last_V[first:], np.full(max(volts.size - last_V.size, 0), last_V[-1])])
    return *best_within(stage, course, [last_V], limits, scored, counted, first, MEAN_SQUARE), cut_um, broken


def _spans(missed: NDArray[np.bool_], start_s: float, Ts_s: float) -> tuple[tuple[float, float], ...]:
    """From .. to, in s, of every unbroken run of samples that are missed."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], missed, [False]]).astype(np.int8)))
    return tuple((start_s + Ts_s * float(a), start_s + Ts_s * float(b - 1)) for a, b in edges.reshape(-1, 2))
