"""Resonance: a lightly damped mode that oscillates at its own frequency for every input."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.base import Cause, Effect, Estimate, Known, Residual, Signature
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Extent, Fit, Mode, Part, RunSignals, ShapeParameter, standard_errors
from hysgen.model.path.modes import Modes

Floats = NDArray[np.float64]

PER_DECADE = 45
"""Grid frequencies per decade; the responses of two modes half a step apart stay alike until they have decayed."""

DAMPINGS = (0.03, 0.12)
APART, MOST_STARTS = 0.25, 6
"""Least distance of two proposed modes of one damping, in ln(f), and their number."""

OTHER_LAGS = (0.3, 3.0, 30.0)
"""Lags in samples from which a first mode starts, beside that of the chain."""

MOST_MODES = 3
LEAST_DAMPING, MOST_DAMPING = 5e-4, 0.4
"""Damping ratios of a mode: below these a mode is a line, above them its response is that of a delay."""

MODE = (
    ShapeParameter("f_Hz", "Hz", lambda e: (3.0 / e.span_s, 0.48 / e.Ts_s), logarithm=True, order=3.0),
    ShapeParameter("zeta", "1", lambda e: (LEAST_DAMPING, MOST_DAMPING), logarithm=True),
    ShapeParameter("share", "1", lambda e: (-3.0, 3.0)),
)
"""Parameters of one mode."""


@dataclass(frozen=True)
class ResonancePart(Part):
    """Parallel second-order modes behind the hysteresis.

    Each adds two columns: what a movement before the record has left ringing.
    """

    cause: ClassVar[str] = "resonance"
    order: ClassVar[int] = 40
    timed: ClassVar[bool] = True
    modes: tuple[Mode, ...] = ()

    @property
    def parameters(self) -> tuple[tuple[str, ShapeParameter], ...]:
        return tuple((f"resonance.{i}.{one.field}", one) for i, _ in enumerate(self.modes) for one in MODE)

    @property
    def values(self) -> tuple[float, ...]:
        return tuple(value for mode in self.modes for value in (mode.f_Hz, mode.zeta, mode.share))

    def with_values(self, values: Sequence[float]) -> Self:
        return type(self)(tuple(Mode(*values[i : i + 3]) for i in range(0, len(values), 3)))

    @property
    def added(self) -> int:
        return 2 * len(self.modes)

    @property
    def weight_orders(self) -> float:
        return 0.0  # a ringing that fades is known no better from a longer record

    def columns(self, run: RunSignals, extent: Extent, seen: Callable[[Floats], Floats]) -> list[Floats]:
        t_s = run.time_s(extent.Ts_s)
        rates = (2.0 * math.pi * mode.f_Hz * complex(-mode.zeta, math.sqrt(1.0 - mode.zeta**2)) for mode in self.modes)
        rings = [np.exp(rate * t_s) for rate in rates]
        return [part for ring in rings for part in (ring.real, ring.imag)]

    def columns_depend_on(self, lag_s: float, delay: float) -> Hashable:
        return tuple((mode.f_Hz, mode.zeta) for mode in self.modes)


class ResonanceCause(Cause):
    name = "resonance"
    kind = "modes"
    rank = 60
    experiment = "drive with steps, or with frequencies up to a tenth of the sampling rate"
    part = ResonancePart
    starts = 3  # slow misfit can favour a wrong mode; a refinement does not cross the true damping ratio

    def without_one_part(self, chain: Chain) -> list[Chain]:
        modes = chain.modes
        fewer = [modes[:i] + modes[i + 1 :] for i in range(len(modes))]
        return [chain.having(ResonancePart(modes_kept)) if modes_kept else self.without(chain) for modes_kept in fewer]

    def proposals(self, residual: Residual) -> list[Chain]:
        """The six modes of a grid whose responses explain most of the residual, one at a time, and two at once.

        Of two strong modes, one alone may lower the error too little for a step of the search.
        """
        chain, scene = residual.fit.chain, residual.scene
        if len(chain.modes) >= MOST_MODES:
            return []
        grid = [Mode(f_Hz, zeta, 1.0) for zeta in DAMPINGS for f_Hz in _grid_Hz(residual)]
        bare = residual.responses(self.without(chain))
        rings = np.empty((len(grid), len(scene.rows)))
        for i, mode in enumerate(grid):
            single = residual.responses(chain.having(ResonancePart((mode,))))
            ring = [seen - stiff for seen, stiff in zip(single, bare, strict=True)]
            rings[i] = np.concatenate(ring)[scene.rows]
        rings = residual.projector.orthogonal_part(rings)
        error = residual.projector.orthogonal_part(residual.fit.error[scene.rows])
        chosen: list[Mode] = []
        for mode in _by_power(grid, rings, error):
            if all(mode.zeta != one.zeta or abs(math.log(mode.f_Hz / one.f_Hz)) > APART for one in chosen):
                chosen.append(mode)
            if len(chosen) == MOST_STARTS:
                break
        sets: list[tuple[Mode, ...]] = [(mode,) for mode in chosen]
        if len(chain.modes) + 2 <= MOST_MODES:
            first = rings[grid.index(dataclasses.replace(chosen[0], share=1.0))]
            first = first / (np.linalg.norm(first) + 1e-300)
            beside = rings - np.outer(rings @ first, first)
            others = _by_power(grid, beside, error - (error @ first) * first)
            sets.append((chosen[0], next(one for one in others if abs(math.log(one.f_Hz / chosen[0].f_Hz)) > APART)))
        together = [sorted((*chain.modes, *more), key=lambda mode: mode.f_Hz) for more in sets]
        proposed = [chain.having(ResonancePart(tuple(modes))) for modes in together]
        return proposed if chain.modes else proposed + _with_other_lags(chain, chosen[0], scene.Ts_s)

    def effect(self, residual: Residual) -> Effect:
        """Of a mode at a twentieth of the sampling rate."""
        f_Hz = 0.05 / residual.scene.Ts_s
        rings = residual.changed_by(residual.fit.chain.having(ResonancePart((Mode(f_Hz, 0.03, 1.0),))))
        return Effect(f"of the motion, for a mode at {f_Hz:.3g} Hz", rings, most=3.0)

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """Frequency, damping ratio and share of each mode with standard errors."""
        chain = residual.fit.chain
        errors = standard_errors(residual.scene, residual.fit).coordinates
        parameters, texts = {}, []
        for i, mode in enumerate(chain.modes):
            suffix = "" if i == 0 else f"_{i + 1}"
            df, dz, ds = (errors[f"resonance.{i}.{one.field}"] for one in MODE)
            parameters[f"f{suffix}_Hz"] = Estimate(mode.f_Hz, mode.f_Hz * df)
            parameters[f"zeta{suffix}"] = Estimate(mode.zeta, mode.zeta * dz)
            parameters[f"share{suffix}"] = Estimate(mode.share, ds)
            texts.append(f"rings at {mode.f_Hz:.4g} Hz with damping ratio {mode.zeta:.3g}, share {mode.share:.2g}")
        z = min(abs(m.share) / max(errors[f"resonance.{i}.share"], 1e-15) for i, m in enumerate(chain.modes))
        return Signature(z, "; ".join(texts), parameters)

    def extension(self, residual: Residual) -> Extension:
        chain = residual.fit.chain
        return Extension(block=modes_block(chain.modes, chain.lag_s), lag_s=chain.lag_s)

    def true_extension(self, known: Known) -> Extension:
        mode = Mode(*(known.parameters[f"resonance.{one.field}"] for one in MODE))
        return Extension(block=modes_block([mode], known.lag_s), lag_s=known.lag_s)


def _with_other_lags(chain: Chain, mode: Mode, Ts_s: float) -> list[Chain]:
    """Chains with a mode that carries half of the motion or all of it, behind the OTHER_LAGS.

    Beside a mode that rings as large as the motion, the lag of the chain without it is far off, and so is the share.
    """
    return [
        dataclasses.replace(chain.having(ResonancePart((dataclasses.replace(mode, share=share),))), lag_s=lag * Ts_s)
        for lag in OTHER_LAGS
        for share in (0.5, 1.0)
    ]


def _grid_Hz(residual: Residual) -> list[float]:
    """Frequencies of the modes that are proposed."""
    scene = residual.scene
    low_Hz, high_Hz = 6.0 / scene.span_s, 0.45 / scene.Ts_s
    # From a fiftieth of the corner frequency of the lag on; without the mode that rings, a fit may take the lag away.
    lag_s = max(residual.fit.chain.lag_s, scene.Ts_s)
    low_Hz = max(low_Hz, 0.02 / (2 * math.pi * lag_s), 1e-3 * high_Hz)
    count = max(20, int(PER_DECADE * math.log10(high_Hz / low_Hz)))
    frequencies: list[float] = np.geomspace(low_Hz, high_Hz, count).tolist()
    return frequencies


def _by_power(grid: Sequence[Mode], rings: Floats, error: Floats) -> list[Mode]:
    """The modes with their shares, those first that explain most of `error`, (n,); rings: (len(grid), n) responses."""
    powers = np.einsum("ij,ij->i", rings, rings) + 1e-300
    shares = rings @ error / powers
    order = np.argsort(-(shares**2) * powers, kind="stable")
    return [dataclasses.replace(grid[i], share=float(np.clip(shares[i], -1.0, 1.0))) for i in order.tolist()]


def modes_block(modes: Sequence[Mode], lag_s: float) -> Modes:
    """The block of these modes behind a lag, in rising order of their frequencies."""
    rising = sorted(modes, key=lambda mode: mode.f_Hz)
    return Modes(tuple(m.f_Hz for m in rising), tuple(m.zeta for m in rising), tuple(m.share for m in rising), lag_s)


CAUSE = ResonanceCause()
