"""Resonance: a lightly damped mode that oscillates at its own frequency for every input."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from hysgen.diagnosis.causes.base import Cause, Effect, Estimate, Known, Residual, Signature
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Fit, Mode, Part, ShapeParameter, standard_errors
from hysgen.model.path.modes import Modes

PER_DECADE = 45
"""Grid frequencies per decade; the responses of two modes half a step apart stay alike until they have decayed."""

DAMPINGS = (0.03, 0.12)
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
    """Parallel second-order modes behind the hysteresis."""

    cause: ClassVar[str] = "resonance"
    order: ClassVar[int] = 40
    modes: tuple[Mode, ...] = ()

    @property
    def parameters(self) -> tuple[tuple[str, ShapeParameter], ...]:
        return tuple((f"resonance.{i}.{one.field}", one) for i, _ in enumerate(self.modes) for one in MODE)

    @property
    def values(self) -> tuple[float, ...]:
        return tuple(value for mode in self.modes for value in (mode.f_Hz, mode.zeta, mode.share))

    def with_values(self, values: Sequence[float]) -> Self:
        return type(self)(tuple(Mode(*values[i : i + 3]) for i in range(0, len(values), 3)))


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
        """The six modes of a grid whose responses explain most of the residual, one at a time."""
        chain, scene = residual.fit.chain, residual.scene
        if len(chain.modes) >= MOST_MODES:
            return []
        low_Hz, high_Hz = 6.0 / scene.span_s, 0.45 / scene.Ts_s
        # The grid starts at a fiftieth of the corner frequency of the lag.
        low_Hz = max(low_Hz, 0.02 / (2 * math.pi * chain.lag_s), 1e-3 * high_Hz)
        error = residual.projector.orthogonal_part(residual.fit.error[scene.rows])
        still = self.without(chain)
        bare = residual.responses(still)
        candidates = []
        count = max(20, int(PER_DECADE * math.log10(high_Hz / low_Hz)))
        for zeta in DAMPINGS:
            grid_Hz = np.geomspace(low_Hz, high_Hz, count).tolist()
            rings = np.empty((count, len(scene.rows)))
            for i, f_Hz in enumerate(grid_Hz):
                single = chain.having(ResonancePart((Mode(f_Hz, zeta, 1.0),)))
                ring = [seen - stiff for seen, stiff in zip(residual.responses(single), bare, strict=True)]
                rings[i] = np.concatenate(ring)[scene.rows]
            rings = residual.projector.orthogonal_part(rings)
            powers = np.einsum("ij,ij->i", rings, rings) + 1e-300
            shares = rings @ error / powers
            candidates += list(
                zip((shares**2 * powers).tolist(), grid_Hz, [zeta] * count, shares.tolist(), strict=True)
            )
        candidates.sort(reverse=True)
        chosen: list[Mode] = []
        for _, f_Hz, zeta, share in candidates:
            if all(zeta != mode.zeta or abs(math.log(f_Hz / mode.f_Hz)) > 0.25 for mode in chosen):
                chosen.append(Mode(f_Hz, zeta, float(np.clip(share, -1.0, 1.0))))
            if len(chosen) == 6:
                break
        return [chain.having(ResonancePart((*chain.modes, mode))) for mode in chosen]

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


def modes_block(modes: Sequence[Mode], lag_s: float) -> Modes:
    """The block of these modes behind a lag, in rising order of their frequencies."""
    rising = sorted(modes, key=lambda mode: mode.f_Hz)
    return Modes(tuple(m.f_Hz for m in rising), tuple(m.zeta for m in rising), tuple(m.share for m in rising), lag_s)


CAUSE = ResonanceCause()
