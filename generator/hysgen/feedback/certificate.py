"""A designed loop and its certificate: margins, bandwidth, settling and poles, each the worst of all draws.

Margins are those of Bode: the factor on |L| at every phase of -180 degrees, and the phase left wherever |L| = 1.
Settling is that of a step of the displacement, such as a push on the stage; a step of the reference passes through the
inverse.
"""

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.display import Displayed, Summary
from hysgen.errors import ModelError
from hysgen.feedback import design
from hysgen.feedback.design import Notch, bandwidths_Hz, best_filter, filter_block, largest_gains
from hysgen.feedback.stage import LATENCY, Uncertainty, draws, frequencies, inverse, lines, modes_of, response, stage
from hysgen.machine.reproducible import spectral_radius
from hysgen.model.feedback import Feedback
from hysgen.model.model import Model
from hysgen.model.path import preview
from hysgen.model.path.base import StateSpace, series
from hysgen.model.path.structure import Structure

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

SEARCHED, WORST, ROUNDS = 24, 8, 4
"""Draws for which the filter is searched first, those that join them after a search, and searches."""

LEAST_KEPT = 0.5
"""Share of the integral of a loop that a model identified again must allow."""

LARGEST_SHARE = 0.1
"""Largest correction as a share of the displacement range."""

SETTLED, STEPPED, TURNS = 0.02, 64, 60.0
"""Share of a step within which it has settled; draws that are stepped; radians of the bandwidth that are waited for."""


@dataclass(frozen=True)
class Certificate:
    """The worst of `draws` draws; bandwidth: -3 dB of the closed loop; peak: of |1/(1 + L)|; pole: a bound of all.

    integral_Hz: bandwidth of the largest integral without a filter that has the same margins; without_inverse_Hz: that
    of one around the stage without the inverse. settling_s: None if a step has not settled within TURNS.
    """

    draws: int
    bandwidth_Hz: float
    gain_margin_dB: float
    phase_margin_deg: float
    peak_dB: float
    pole: float
    settling_s: float | None
    integral_Hz: float
    without_inverse_Hz: float

    @property
    def holds(self) -> bool:
        """Whether every draw is stable and keeps the margins, to a thousandth."""
        wide = self.gain_margin_dB > 0.999 * design.GAIN_MARGIN_DB
        return wide and self.phase_margin_deg > 0.999 * design.PHASE_MARGIN_DEG and self.pole < 1.0


@dataclass(frozen=True, eq=False, repr=False)
class LoopDesign(Displayed):
    """correction(k) = correction(k-1) + integral/2 (f(k) + f(k-1)), f = F of the residual; the inverse is asked for it.

    latency: samples between reading and voltage that the record of the model does not hold. first_Hz: its lowest mode.
    For pictures: frequencies f_Hz, (n,); least and largest |L| of all draws, size, (2, n); phase_deg of L of the model
    itself, (n,); steps, (draws, samples): displacement after a push of 1.
    """

    model: str
    Ts_s: float
    integral: float
    notches: tuple[Notch, ...]
    latency: float
    uncertainty: Uncertainty
    first_Hz: float | None
    certificate: Certificate
    f_Hz: Floats
    size: Floats
    phase_deg: Floats
    steps: Floats

    @property
    def block(self) -> Structure | None:
        """F as a block, None for F = 1."""
        return filter_block(self.notches, self.Ts_s)

    def around(self, model: Model) -> Model:
        """The model with this loop as its feedback, whose correction is at most LARGEST_SHARE of the range."""
        return self._with(model, self.block)

    def _with(self, model: Model, block: Structure | None) -> Model:
        limit_um = LARGEST_SHARE * (model.grid.y_max_um - model.grid.y_min_um)
        stated = {"latency": self.latency, "uncertainty": asdict(self.uncertainty)}
        loop = Feedback(self.integral, limit_um, block)
        return dataclasses.replace(model, feedback=loop, history={**model.history, "loop": stated})

    def summary(self) -> Summary:
        """Bandwidth first, then margins, and what they hold for."""
        c, u = self.certificate, self.uncertainty
        share = "" if self.first_Hz is None else f", {100 * c.bandwidth_Hz / self.first_Hz:.0f} % of the first mode"
        settling = "not settled" if c.settling_s is None else f"{1e3 * c.settling_s:.3g} ms"
        answer = "holds" if c.holds else "DOES NOT hold"
        first = [
            f"an integral alone with the same margins: {c.integral_Hz:.4g} Hz, without the inverse of the model: "
            f"{c.without_inverse_Hz:.4g} Hz",
            f"certificate over {c.draws} draws of the uncertainty: {answer}; gain margin {c.gain_margin_dB:.3g} dB, "
            f"phase margin {c.phase_margin_deg:.3g} degrees, peak of the sensitivity {c.peak_dB:.3g} dB, "
            f"largest pole {c.pole:.5f}",
            f"a push on the stage settles to {100 * SETTLED:.0f} % in {settling}",
            f"uncertainty: gain {100 * u.gain:.3g} %, frequency of a mode {100 * u.frequency:.3g} %, damping "
            f"{100 * u.damping:.3g} %, share {100 * u.share:.3g} %, lag {100 * u.lag:.3g} %, "
            f"delay {u.late:.3g} samples; latency {self.latency:.3g} samples",
        ]
        rows = [
            [f"{value:.4g}" for value in (n.zero_Hz, n.zero_damping, n.pole_Hz, n.pole_damping)] for n in self.notches
        ]
        head = f"{self.model}: integral {self.integral:.4g} a sample, {len(rows)} notches"
        head += f": bandwidth {c.bandwidth_Hz:.4g} Hz{share}"
        return Summary(head, ("zeros Hz", "damping", "poles Hz", "damping"), rows, first=first, left=0)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "model": self.model,
            "Ts_s": self.Ts_s,
            "integral": self.integral,
            "notches": [asdict(notch) for notch in self.notches],
            "latency_samples": self.latency,
            "uncertainty": asdict(self.uncertainty),
            "first_mode_Hz": self.first_Hz,
            "certificate": asdict(self.certificate) | {"holds": self.certificate.holds},
        }


def carried(old: Model, new: Model) -> Model:
    """`new` with the loop of `old`, its integral no larger than what keeps the margins around `new`.

    Without a loop if that is less than LEAST_KEPT of it, or if the certificate does not hold.
    """
    stated: Any = old.history.get("loop", {})
    try:
        given = Uncertainty(**stated.get("uncertainty", {}))
        loop = design_loop(new, given, float(stated.get("latency", LATENCY)), old.feedback)
    except (ModelError, AttributeError, TypeError, ValueError):
        return new
    known = old.feedback
    holds = known and loop.certificate.holds and loop.integral >= LEAST_KEPT * known.integral
    return loop._with(new, known.filter) if known and holds else new


def design_loop(model: Model, given: Uncertainty, latency: float, before: Feedback | None = None) -> LoopDesign:
    """The loop of the largest least bandwidth that keeps its margins for every draw.

    latency: as for LoopDesign. before: a loop whose filter is taken, and whose integral is not exceeded. Raises
    ModelError if there is none.
    """
    modes, ringing, cloud, f_Hz = modes_of(model), lines(model), draws(model), frequencies(model, given)
    z = np.exp(2j * math.pi * f_Hz * model.Ts_s)
    known, ahead = inverse(model), latency + preview(model.blocks)
    chains = [stage(model, unit, given, ahead) for unit in cloud]
    stages = np.array([response(chain, z) for chain in chains]) * (response(known, z) * 0.5 * (z + 1.0) / (z - 1.0))
    wide = [(f, 2.0 * given.frequency) for f, _ in modes]
    starts = (ringing, wide, sorted([*ringing, *wide]))
    notches = () if before else _notches(stages, f_Hz, model.Ts_s, starts)
    block = before.filter if before else filter_block(notches, model.Ts_s)
    filters = _factors(block, model.Ts_s)
    loops = stages * response(filters, z)
    # In float32, and no larger than the largest one.
    gain = float(np.nextafter(np.float32(_gain(loops, model)), np.float32(0.0)))
    gain = min(gain, before.integral if before else gain)
    loops *= gain
    # A preview is the delay of the stage in whole samples, which a loop without the inverse has, too.
    without = stages / response(known, z)
    integral = (np.eye(1), np.ones(1), np.array([gain]), 0.5 * gain)
    closed = [_closed([integral, *filters, *known, *chain]) for chain in chains]
    bandwidth_Hz = float(bandwidths_Hz(loops, f_Hz).min())
    steps = _steps(closed[:: len(closed) // STEPPED], math.ceil(TURNS / (2.0 * math.pi * bandwidth_Hz * model.Ts_s)))
    late = np.flatnonzero((np.abs(steps) > SETTLED).any(axis=0))
    settling = None if late[-1] == steps.shape[1] - 1 else float(late[-1] + 1) * model.Ts_s
    certificate = Certificate(
        len(cloud),
        bandwidth_Hz,
        *margins(loops),
        float(20.0 * np.log10(np.abs(1.0 / (1.0 + loops)).max())),
        max(spectral_radius(A) for A, _, _ in closed),
        settling,
        *(float(bandwidths_Hz(_gain(bare, model) * bare, f_Hz).min()) for bare in (stages, without)),
    )
    own = response([integral, *filters, *known, *stage(model, np.zeros(cloud.shape[1]), given, ahead)], z)
    band = np.array([np.abs(loops).min(axis=0), np.abs(loops).max(axis=0)])
    phase_deg, first_Hz = np.rad2deg(np.unwrap(np.angle(own))), next((f for f, _ in modes), None)
    name, Ts_s = model.name, model.Ts_s
    return LoopDesign(name, Ts_s, gain, notches, latency, given, first_Hz, certificate, f_Hz, band, phase_deg, steps)


def _notches(
    stages: Complex, f_Hz: Floats, Ts_s: float, starts: Sequence[Sequence[tuple[float, float]]]
) -> tuple[Notch, ...]:
    """The filter of the largest least bandwidth over all draws, () where none is better than the integral alone.

    Few draws are searched, and may miss the one that bounds the integral: those that allow the least join them.
    """
    z = np.exp(2j * math.pi * f_Hz * Ts_s)
    searched, bare_Hz = list(range(SEARCHED)), bandwidths_Hz(largest_gains(stages).min() * stages, f_Hz)
    best: tuple[float, tuple[Notch, ...]] = float(bare_Hz.min()), ()
    for _ in range(ROUNDS):
        notches = best_filter(stages[searched], f_Hz, Ts_s, starts)
        loops = stages * response(_factors(filter_block(notches, Ts_s), Ts_s), z)
        gains = largest_gains(loops)
        best = max(best, (float(bandwidths_Hz(gains.min() * loops, f_Hz).min()), notches), key=lambda pair: pair[0])
        worst = [int(row) for row in np.argsort(gains, kind="stable")[:WORST] if row not in searched]
        if not worst:
            break
        searched += worst
    return best[1]


def _factors(block: Structure | None, Ts_s: float) -> list[StateSpace]:
    return [] if block is None else [block.state_space(Ts_s)]


def _gain(loops: Complex, model: Model) -> float:
    gain = float(largest_gains(loops).min())
    if not 0.0 < gain < math.inf:
        raise ModelError(f"{model.name}: no loop around this model keeps its margins; state a smaller uncertainty")
    return gain


def margins(loops: Complex) -> tuple[float, float]:
    """Least gain margin in dB and phase margin in degrees; between frequencies L is a straight line."""
    a, b = loops[:, :-1], loops[:, 1:]
    cross = (a.imag < 0.0) != (b.imag < 0.0)
    step = np.where(cross, b.imag - a.imag, 1.0)
    real = a.real - a.imag / step * (b.real - a.real)
    before = cross & (real < 0.0)
    gain_dB = float(np.min(np.abs(20.0 * np.log10(-real[before])), initial=math.inf))
    size, over = np.log(np.abs(a)), np.log(np.abs(b))
    unit = (size < 0.0) != (over < 0.0)
    share = -size[unit] / (over[unit] - size[unit])
    at = a[unit] + share * (b[unit] - a[unit])
    return gain_dB, float(np.min(np.abs(np.angle(-at, deg=True)), initial=180.0))


def _closed(chain: Sequence[StateSpace]) -> tuple[Floats, Floats, Floats]:
    """A, B, C of x(k+1) = A x(k) - B d(k), y = d + C x: the loop under a push d. The lag of the stage leaves no D."""
    A, B, C, _ = series(chain)
    return A - np.outer(B, C), B, C


def _steps(closed: Sequence[tuple[Floats, Floats, Floats]], samples: int) -> Floats:
    """(draws, samples) displacement after a push of 1."""
    order = max(A.shape[0] for A, _, _ in closed)
    A, B, C = (np.zeros((len(closed), order, order)), *(np.zeros((len(closed), order)) for _ in range(2)))
    for i, (a, b, c) in enumerate(closed):
        A[i, : len(b), : len(b)], B[i, : len(b)], C[i, : len(b)] = a, b, c
    x, y = np.zeros_like(B), np.empty((len(closed), samples))
    for k in range(samples):
        y[:, k] = 1.0 + np.einsum("ij,ij->i", C, x)
        x = np.einsum("ijk,ik->ij", A, x) - B
    return y
