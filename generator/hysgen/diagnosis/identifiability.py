"""What a record can tell: for every cause, the least effect that the diagnosis would name in this record.

An effect of amount a and derivative d of the prediction is fitted beside all parameters of the final chain, which leave
P d of it, P the projector off their derivatives. It is named if the rms error grows enough without it:

    a |P d| / sqrt(n) > sqrt(g^2 - 1) R        g: `score.least_growth` of one parameter; R: rms of the residual

If P leaves less than LEAST_SHARE of |d|^2, a part of the chain hides the cause: the one without whose derivatives most
of d is left.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes import Residual, causes, in_ladder_order
from hysgen.diagnosis.causes.base import Effect
from hysgen.diagnosis.probe import Projector, projector_off
from hysgen.diagnosis.probe.chain import COMMON
from hysgen.diagnosis.probe.solve import sensitivities
from hysgen.diagnosis.score import Scored, dispersion, least_growth
from hysgen.display import decimal

Floats = NDArray[np.float64]


LEAST_SHARE = 0.01
"""Share of the power of an effect beside the final chain below which a part of the chain hides it: its amount is known
ten times worse than without this part."""


@dataclass(frozen=True)
class Ability:
    """Whether a record could show a cause.

    verdict: "named"; "above", only an effect of at least `least`; "hidden" by the part `hidden_by`, at least `least`;
    or "not excited". limit: the cause is a limit, at most `least` to be seen. experiment: what to record so that the
    cause shows.
    """

    name: str
    verdict: str
    least: float | None = None
    unit: str = ""
    hidden_by: str = ""
    experiment: str = ""
    limit: bool = False

    def text(self) -> str:
        """The verdict in words."""
        match self.verdict:
            case "named":
                return "named"
            case "not excited":
                return f"not excited: {self.experiment}"
        amount = "a limit of at most" if self.limit else "an effect of at least"
        level = f"only {amount} {decimal(self.least or 0.0, 3)} {self.unit}"
        return f"{level}, because {self.hidden_by} hides it; {self.experiment}" if self.hidden_by else level

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
        return Ability(name, "above", effect.least, effect.unit, experiment=cause.experiment, limit=effect.limit)
    least, share, hidden_by = information.least(name, effect.column)
    if not least < effect.most:
        return Ability(name, "not excited", experiment=cause.experiment)
    if hidden_by and share < LEAST_SHARE:
        return Ability(name, "hidden", least, effect.unit, hidden_by, cause.experiment)
    return Ability(name, "above", least, effect.unit, experiment=cause.experiment)


@dataclass(frozen=True, eq=False)
class _Information:
    """Derivatives of the prediction by the parameters of each part on the fitted rows, (p, n), "memory" for h.

    scored: the final chain.
    """

    parts: Mapping[str, Floats]
    scored: Scored

    @classmethod
    def of(cls, residual: Residual) -> _Information:
        scene, fit = residual.scene, residual.fit
        columns = scene.columns(fit.chain)[:, scene.rows]
        shape = sensitivities(scene, fit, projector_off(scene, fit.chain, columns))
        size = scene.hysteresis_size(fit.chain)
        # The constant, the sensor's curve and the lag belong to every chain.
        parts = {"memory": columns[:size], "": np.vstack([columns[size : size + COMMON], shape[:1]])}
        for part in fit.chain.parts:
            own = [i for i, name in enumerate(fit.chain.names()) if name.startswith(f"{part.cause}.")]
            first = scene.column_of(fit.chain, type(part))
            parts[part.cause] = np.vstack([shape[own], columns[first : first + part.added]])
        return cls(parts, Scored.of(scene, fit))

    def least(self, name: str, column: Floats) -> tuple[float, float, str]:
        """Least amount of an effect, (n,) per unit; share of its power beside the chain; the part that hides most."""
        fit, rows = self.scored.fit, self.scored.scene.rows
        direction = column[rows] - column[rows].mean()
        kept = [part for part in self.parts if part != name]
        left = self._beside(direction, kept)
        power, whole = float(left @ left), float(direction @ direction)
        if power <= 1e-12 * whole or whole == 0.0:
            return math.inf, 0.0, ""
        growth = least_growth(
            self.scored.independent_samples(dispersion(fit.error[rows], left)), causes()[name].prior_odds
        )
        least = math.sqrt(growth**2 - 1.0) * fit.rms_um / math.sqrt(power / len(left))
        share, hidden_by = power / whole, ""
        if share < LEAST_SHARE:
            without = {part: self._beside(direction, [one for one in kept if one != part]) for part in kept if part}
            hidden_by = max(without, key=lambda part: float(without[part] @ without[part]))
        return least, share, hidden_by

    def _beside(self, direction: Floats, parts: list[str]) -> Floats:
        return Projector.of(np.vstack([self.parts[part] for part in parts])).orthogonal_part(direction)
