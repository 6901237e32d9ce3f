"""A scene seen through what its misfit is known to do: it moves only when the stage does.

    e(k) = m(k) + n(k),    m(k) = exp(-|dv(k)| / reach) m(k-1) + ...,    n white

What a hysteresis model leaves is a function of the path: it stays while the stage rests, and is another one after the
stage has gone some way v. So two samples of a plateau share their misfit, and what changes between them is told to
within the noise; least squares that take all samples for independent would weigh it like any other. Here every column
and the measurement become innovations of that process (generalised least squares by a Kalman filter; Harvey, 1989):
errors of a fit are nearly independent, and chains of different kinds can be compared by their likelihood.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from hysgen.diagnosis.probe.chain import Chain
from hysgen.diagnosis.probe.scene import Scene
from hysgen.diagnosis.probe.solve import Fit, refine, rms
from hysgen.machine.kernels import innovation_gains, innovations, lag_states

Floats = NDArray[np.float64]

REACH = 0.05
"""Way, as a share of the input's range, from which the one after which the misfit is another is looked for."""


@dataclass(frozen=True, eq=False)
class Whitening:
    """The filter for one scene, (n,) each: how much of the misfit a step keeps, Kalman gains, innovation variances."""

    keep: Floats
    gain: Floats
    variance: Floats

    def of(self, signals: Floats) -> Floats:
        """Innovations of `signals`, (n,) or (m, n)."""
        return innovations(np.atleast_2d(signals), self.keep, self.gain, self.variance).reshape(signals.shape)


@dataclass(frozen=True, eq=False)
class WhitenedScene(Scene):
    """A scene whose measurement and columns are innovations: rows times a fit's squared rms is its chi square.

    What a fit to it says in micrometres (`Fit.error`, `y_um`) is in standard deviations; its chain means the same.
    """

    whitening: Whitening = field(kw_only=True)

    @property
    def y_um(self) -> Floats:
        return self.whitening.of(super().y_um)

    def columns(self, chain: Chain) -> Floats:
        return self.whitening.of(super().columns(chain))

    def seen(self, paths: Sequence[Floats], chain: Chain, weights: Floats) -> Floats:
        return self.whitening.of(super().seen(paths, chain, weights))

    @classmethod
    def of(cls, scene: Scene, fit: Fit) -> Self:
        """The scene with the misfit and noise that a fit leaves on its rows, by maximum likelihood."""
        plain = {one.name: getattr(scene, one.name) for one in dataclasses.fields(Scene)}
        return cls(**plain, whitening=_likeliest(scene, fit))


def whitened_fit(scene: Scene, fit: Fit) -> tuple[WhitenedScene, Fit]:
    """The scene as its misfit lets it be seen, and the chain of `fit` fitted again to that."""
    seen = WhitenedScene.of(scene, fit)
    return seen, refine(seen, fit.chain)


def schwarz(scene: WhitenedScene, fit: Fit) -> float:
    """Schwarz's criterion, without what all fits to this scene share: chi square + parameters * ln(samples)."""
    parameters = len(fit.weights) + len(fit.chain.coordinates())
    return len(scene.rows) * fit.rms_um**2 + parameters * math.log(len(scene.rows))


def _likeliest(scene: Scene, fit: Fit) -> Whitening:
    """The whitening under which the error of `fit` is likeliest."""
    way = _way(scene, fit.chain)
    heard = np.zeros(scene.samples)
    heard[scene.rows] = 1.0
    level_um = rms(fit.error[scene.rows]) + 1e-300

    def whitening(logarithms: Floats) -> Whitening:
        reach, misfit_um, noise_um = np.exp(logarithms)
        keep = np.exp(-way / reach)
        return Whitening(keep, *innovation_gains(keep, heard, misfit_um**2, noise_um**2))

    def unlikely(logarithms: Floats) -> float:
        trial = whitening(logarithms)
        news = trial.of(fit.error)[scene.rows]
        return float(news @ news + np.log(trial.variance[scene.rows]).sum())

    start = np.log([REACH, level_um, 0.3 * level_um])
    found = minimize(unlikely, start, method="Nelder-Mead", options={"maxfev": 100, "xatol": 0.02, "fatol": 0.1})
    return whitening(found.x)


def _way(scene: Scene, chain: Chain) -> Floats:
    """(n,) how far the stage went in each step, in ranges of the input; infinitely far at the start of a run."""
    rate = np.array([-np.expm1(-scene.Ts_s / chain.lag_s)])
    late = max(0, round(chain.delay))
    span_V = scene.operator.high_V - scene.operator.low_V
    ways = []
    for run in scene.runs:
        v_V = chain.amplified(run.u_V, scene.Ts_s)
        v_V = np.concatenate([np.full(late, v_V[0]), v_V[: len(v_V) - late]])
        behind_V = lag_states(v_V, rate, v_V[:1].copy())[:, 0]
        ways.append(np.abs(np.diff(behind_V, prepend=np.inf)) / span_V)
    return np.concatenate(ways)
