"""What a record can tell: for every cause, the least effect that the diagnosis would name in this record.

An effect of amount a and derivative d of the prediction is fitted beside all parameters of the final chain, which leave
P d of it, P the projector off their derivatives. Two criteria of the diagnosis bound a from below:

    evidence   a > LEAST_Z s,   s^2 = sum over blocks of (P d . e)_b^2 / |P d|^4      e: residual, `uncertainty`
    need       a |P d| / sqrt(N) > sqrt(needed^2 - 1) times the error above the white noise     `Cause.needed`

If P leaves less than LEAST_SHARE of |d|^2, a part of the chain hides the cause: the one without whose derivatives most
of d is left. The third criterion, the gain of the extension in the delivered model, is not foreseen here.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes import Residual, causes, in_ladder_order
from hysgen.diagnosis.causes.base import Effect
from hysgen.diagnosis.comparison import LEAST_ABOVE_NOISE
from hysgen.diagnosis.probe import Projector
from hysgen.diagnosis.probe.solve import sensitivities
from hysgen.diagnosis.probe.uncertainty import block_edges, block_left_out_error
from hysgen.record.series import residual_noise

Floats = NDArray[np.float64]

LEAST_Z = 5.0
"""Standard errors that the signatures of the causes require: 4 for slow ones, 5 for others."""

LEAST_SHARE = 0.01
"""Share of the power of an effect beside the final chain below which a part of the chain hides it: its amount is known
ten times worse than without this part."""


@dataclass(frozen=True)
class Ability:
    """Whether a record could show a cause.

    verdict: "named"; "above", only an effect of at least `least`; "hidden" by the part `hidden_by`, at least `least`;
    or "not excited". experiment: what to record so that the cause shows.
    """

    name: str
    verdict: str
    least: float | None = None
    unit: str = ""
    hidden_by: str = ""
    experiment: str = ""

    def text(self) -> str:
        """The verdict in words."""
        match self.verdict:
            case "named":
                return "named"
            case "not excited":
                return f"not excited: {self.experiment}"
        level = f"only from {self.least:.3g} {self.unit} on"
        return f"{level}, hidden by {self.hidden_by}: {self.experiment}" if self.hidden_by else level

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values; null where a quantity does not exist."""
        return {
            "name": self.name,
            "verdict": self.verdict,
            "least": self.least,
            "unit": self.unit or None,
            "hidden_by": self.hidden_by or None,
            "experiment": self.experiment or None,
        }


def abilities(residual: Residual, whole: Residual, named: Mapping[str, object]) -> tuple[Ability, ...]:
    """What a record could show, for every cause in the order of the ladder.

    residual: of the final chain on the rows of the search; whole: on all rows (`Cause.on_all_rows`). named: the named
    causes. A cause of the chain that is not named counts as part of the chain.
    """
    information = _Information.of(residual)
    result = []
    for name in in_ladder_order(causes()):
        cause = causes()[name]
        if name in named:
            result.append(Ability(name, "named"))
            continue
        effect = cause.effect(whole if cause.on_all_rows else residual)
        if effect is None:
            result.append(Ability(name, "not excited", experiment=cause.experiment))
        else:
            result.append(_ability(name, effect, information))
    return tuple(result)


def _ability(name: str, effect: Effect, information: _Information) -> Ability:
    cause = causes()[name]
    if effect.column is None:
        return Ability(name, "above", effect.least, effect.unit, experiment=cause.experiment)
    least, share, hidden_by = information.least(name, effect.column, cause.needed)
    if not least < effect.most:
        return Ability(name, "not excited", experiment=cause.experiment)
    if hidden_by and share < LEAST_SHARE:
        return Ability(name, "hidden", least, effect.unit, hidden_by, cause.experiment)
    return Ability(name, "above", least, effect.unit, experiment=cause.experiment)


@dataclass(frozen=True, eq=False)
class _Information:
    """Derivatives of the prediction by the parameters of each part on the fitted rows, (p, n), "memory" for h.

    error: (n,) residual of a fit without the row's block. beyond_um: error above the white noise.
    """

    rows: NDArray[np.intp]
    parts: Mapping[str, Floats]
    error: Floats
    beyond_um: float

    @classmethod
    def of(cls, residual: Residual) -> _Information:
        scene, fit = residual.scene, residual.fit
        columns = scene.columns(fit.chain)[:, scene.rows]
        shape = sensitivities(scene, fit, Projector.of(columns))
        size = scene.hysteresis_size(fit.chain)
        # The constant and the lag belong to every chain.
        parts = {"memory": columns[:size], "": np.vstack([columns[size : size + 1], shape[:1]])}
        for part in fit.chain.parts:
            own = [i for i, name in enumerate(fit.chain.names()) if name.startswith(f"{part.cause}.")]
            first = scene.column_of(fit.chain, type(part))
            parts[part.cause] = np.vstack([shape[own], columns[first : first + part.added]])
        noise_um = residual_noise(fit.error[scene.dense])
        beyond_um = math.sqrt(max(fit.rms_um**2 - noise_um**2, (LEAST_ABOVE_NOISE * noise_um) ** 2))
        error = block_left_out_error(np.vstack([columns, shape]), fit.error[scene.rows])
        return cls(scene.rows, parts, error, beyond_um)

    def least(self, name: str, column: Floats, needed: float) -> tuple[float, float, str]:
        """Least amount of an effect, (n,) per unit; share of its power beside the chain; the part that hides most."""
        direction = column[self.rows] - column[self.rows].mean()
        kept = [part for part in self.parts if part != name]
        left = self._beside(direction, kept)
        power, whole = float(left @ left), float(direction @ direction)
        if power <= 1e-12 * whole or whole == 0.0:
            return math.inf, 0.0, ""
        scores = [float(left[a:b] @ self.error[a:b]) for a, b in itertools.pairwise(block_edges(len(left)))]
        evident = LEAST_Z * math.sqrt(math.fsum(score**2 for score in scores)) / power
        growing = math.sqrt(needed**2 - 1.0) * self.beyond_um / math.sqrt(power / len(left))
        share, hidden_by = power / whole, ""
        if share < LEAST_SHARE:
            without = {part: self._beside(direction, [one for one in kept if one != part]) for part in kept if part}
            hidden_by = max(without, key=lambda part: float(without[part] @ without[part]))
        return max(evident, growing), share, hidden_by

    def _beside(self, direction: Floats, parts: list[str]) -> Floats:
        return Projector.of(np.vstack([self.parts[part] for part in parts])).orthogonal_part(direction)
