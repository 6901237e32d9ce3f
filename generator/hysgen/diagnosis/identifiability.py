"""What a record can tell: the least effect of every cause that would be named, and the experiment that tells more.

An effect of amount a and derivative d of the prediction is fitted beside all parameters of the final chain, which leave
P d of it, P the projector off their derivatives. It is named if the rms error grows enough without it:

    a |P d| / sqrt(n) > sqrt(g^2 - 1) R        g: `score.least_growth` of one parameter; R: rms of the residual

If P leaves less than LEAST_SHARE of |d|^2, a part of the chain hides the cause: the one without whose derivatives most
of d is left.

What a record holds, before any search: ranges, rate, noise, excitation, and what it could show beside hysteresis and
lag if nothing but its noise were left.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes import Residual, causes, in_ladder_order
from hysgen.diagnosis.causes.base import Effect
from hysgen.diagnosis.excitation import Excitation
from hysgen.diagnosis.prepare import Prepared, prepare
from hysgen.diagnosis.probe import Projector, projector_off, rms
from hysgen.diagnosis.probe.chain import COMMON
from hysgen.diagnosis.probe.solve import sensitivities
from hysgen.diagnosis.score import Scored, least_growth
from hysgen.diagnosis.search import start
from hysgen.display import Displayed, Summary, decimal
from hysgen.errors import RecordError
from hysgen.fitting import check_for_fit
from hysgen.machine.processes import one_blas_thread
from hysgen.model.residual import BLOCKS, dispersion
from hysgen.record.data import Record
from hysgen.record.noise import NoiseFloor
from hysgen.record.series import MEDIAN_TO_DEVIATION, resolution_um

Floats = NDArray[np.float64]


LEAST_SHARE = 0.01
"""Share of the power of an effect beside the final chain below which a part of the chain hides it: its amount is known
ten times worse than without this part."""


@dataclass(frozen=True)
class Ability:
    """Whether a record could show a cause.

    verdict: "named"; "above", only an effect of at least `least`; "hidden" by the part `hidden_by`, at least `least`;
    "not excited"; or "not judged" without the part `beside`. limit: it is one, at most `least`. experiment: to record.
    """

    name: str
    verdict: str
    least: float | None = None
    unit: str = ""
    hidden_by: str = ""
    experiment: str = ""
    limit: bool = False
    beside: str = ""

    @property
    def excited(self) -> bool | None:
        """Whether an effect of some size would show, or does; None if that is not judged."""
        return None if self.verdict == "not judged" else self.verdict != "not excited"

    @property
    def lacks(self) -> str:
        """What to record so that the cause shows; empty if an effect of some size shows in this record."""
        return self.experiment if self.verdict in ("not excited", "hidden") else ""

    def text(self) -> str:
        """The verdict in words."""
        match self.verdict:
            case "named":
                return "named"
            case "not excited":
                return f"not excited: {self.experiment}"
            case "not judged":
                return f"not judged: no {self.beside} is known that it changes"
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
        if cause.held_by in named:
            continue
        if cause.changes and not causes()[cause.changes].present(residual.fit.chain):
            result.append(Ability(name, "not judged", experiment=cause.experiment, beside=cause.changes))
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
        # What the rows show of themselves: a cause that is likelier than not before them is named without showing.
        odds = min(causes()[name].prior_odds, 1.0)
        growth = least_growth(self.scored.independent_samples(dispersion(fit.error[rows], left)), odds)
        least = math.sqrt(growth**2 - 1.0) * fit.rms_um / math.sqrt(power / len(left))
        share, hidden_by = power / whole, ""
        if share < LEAST_SHARE:
            without = {part: self._beside(direction, [one for one in kept if one != part]) for part in kept if part}
            hidden_by = max(without, key=lambda part: float(without[part] @ without[part]), default="")
        return least, share, hidden_by

    def _beside(self, direction: Floats, parts: list[str]) -> Floats:
        return Projector.of(np.vstack([self.parts[part] for part in parts])).orthogonal_part(direction)


UNKNOWN_ABOVE, OVER_NOISE = 0.0035, 2.5
"""Residual rms, as a share of the span of y and in noise floors, from both of which on the residual has structure.

Of 780 stages of the families of the laboratory without an effect outside the vocabulary the probe left more than this
share on two, and more than 0.25 % on seven. Jumps and changes of the gain are parts of the probe and need no limit.
"""

NEAR, AT_ONCE = 0.006, 0.8
"""A way, as a share of the stroke, and the share of what is left that changes within it in slow motion, above which it
is no misfit at any size: hystereses of other equations have up to 0.4, modes 0.65, stick-slip 0.93 to 1.2."""

JUMP = 8.0
"""Size of a jump in robust standard deviations of the residual's steps."""

WINDOW = 256
"""Samples of one spectrum of the residual."""


def unexplained_structure(prepared: Prepared, result: Residual, noise: NoiseFloor) -> str | None:
    """The structure in the residual of the probe's fit, in words; None if the residual is noise or negligible."""
    rows = result.scene.rows
    residual = result.fit.error[rows]
    level, span = rms(residual), float(np.ptp(prepared.y_um[: prepared.cut]))
    steps_um = resolution_um(result.scene.y_um[rows]) / math.sqrt(12.0)
    noise_um = max(min(noise.rms_um, unpredictable_um(residual)), steps_um)
    sticks = changing_within(result, NEAR * span, noise_um) > AT_ONCE
    if level < OVER_NOISE * noise_um or (level < UNKNOWN_ABOVE * span and not sticks):
        return None
    words = residual_in_words(residual, prepared, rows)
    friction = f"which changes within {100 * NEAR} % of the way, as if the stage sticks and slips; " if sticks else ""
    return f"{decimal(level, 3)} um are left ({100 * level / span:.2g} % of the stroke), {friction}{words}"


def changing_within(result: Residual, way_um: float, noise_um: float) -> float:
    """Share of the power of a residual above the noise that changes while a slow motion goes on by way_um.

        (mean (e(k') - e(k))^2 / 2 - noise^2) / (var e - noise^2),    |p(k') - p(k)| = way_um, p: the prediction

    Slow: less than way_um within the lag. 0 where the stage goes less than half of its whole way slowly: only behind
    its turns then, where every misfit changes.
    """
    scene, error = result.scene, result.fit.error
    predicted_um = scene.y_um - error
    moves_um = np.abs(np.diff(predicted_um, prepend=predicted_um[0]))
    within_lag_um = moves_um * max(result.fit.chain.lag_s / scene.Ts_s, 1.0)
    slow = np.zeros(scene.samples, dtype=np.bool_)
    slow[scene.rows] = within_lag_um[scene.rows] < way_um
    gone_um, fast = np.cumsum(moves_um), np.cumsum(~slow)
    rows = np.flatnonzero(slow)
    later = np.minimum(np.searchsorted(gone_um, gone_um[rows] + way_um), scene.samples - 1)
    straight = np.abs(predicted_um[later] - predicted_um[rows]) > 0.9 * way_um
    whole = straight & (fast[later] == fast[rows])
    if np.count_nonzero(whole) < BLOCKS or moves_um[slow].sum() < 0.5 * moves_um.sum():
        return 0.0
    here, there_um = error[rows[whole]], error[later[whole]]
    floor = noise_um**2
    changed = 0.5 * float(np.mean((there_um - here) ** 2)) - floor
    return changed / max(float(np.var(here)) - floor, 1e-9 * float(np.var(here)) + 1e-300)


def unpredictable_um(residual: Floats) -> float:
    """Standard deviation of the part of a residual, (m,), that its past does not predict, median over windows.

    exp(mean over the frequencies of ln S + Euler's constant), with S the periodogram: a vibration of changing frequency
    raises S at few frequencies of each window (Kolmogorov, 1941). inf for a residual shorter than a window.
    """
    taper = np.hanning(WINDOW)
    starts = range(0, len(residual) - WINDOW + 1, WINDOW // 2)
    spectra = [np.abs(np.fft.rfft(_without_line(residual[at : at + WINDOW]) * taper))[3:-1] ** 2 for at in starts]
    levels = [float(np.mean(np.log(one + 1e-300))) + np.euler_gamma for one in spectra]
    return math.sqrt(math.exp(float(np.median(levels))) / float(taper @ taper)) if levels else math.inf


def _without_line(values: Floats) -> Floats:
    """The values, (m,), less the straight line of least squares."""
    time = np.arange(len(values)) - 0.5 * (len(values) - 1)
    return np.asarray(values - values.mean() - (time @ values) / (time @ time) * time)


def residual_in_words(residual: Floats, prepared: Prepared, rows: NDArray[np.intp]) -> str:
    """Jumps, slow or fast, dependence on displacement and direction of a residual, (m,), in um on the given rows."""
    words = []
    steps = np.diff(residual)
    typical = MEDIAN_TO_DEVIATION * float(np.median(np.abs(steps))) + 1e-300
    jumps = int(np.count_nonzero(np.abs(steps) > JUMP * typical))
    if jumps > 5:
        words.append(f"{jumps} jumps")
    centred = residual - residual.mean()
    lag = max(1, len(residual) // 200)
    autocorrelation = float(centred[lag:] @ centred[:-lag] / (centred @ centred + 1e-300))
    words.append("slow" if autocorrelation > 0.5 else "fast")
    y = prepared.y_um[rows]
    along = float(np.corrcoef(y, np.abs(centred))[0, 1])
    if abs(along) > 0.25:
        words.append("larger at high displacement" if along > 0 else "larger at low displacement")
    rising = np.gradient(prepared.u_V)[rows] > 0
    if rising.any() and (~rising).any():
        gap = abs(float(centred[rising].mean() - centred[~rising].mean()))
        if gap > 0.5 * rms(centred):
            words.append("depends on the direction")
    return ", ".join(words)


RULES = 6
"""Rules of the fit for which the excitation is checked."""


EXCITATION = ("swings", "sizes", "rests", "longest_rest_s", "lowest_Hz", "highest_Hz", "fastest_V_per_s")
"""What the JSON of an inspection says of the excitation (`Excitation`)."""


@dataclass(frozen=True, eq=False, repr=False)
class Inspection(Displayed):
    """The content of a record: its excitation and noise, and what it could show, in the ladder's order."""

    seen: Excitation
    abilities: tuple[Ability, ...]
    warnings: tuple[str, ...]

    def summary(self) -> Summary:
        """Rate, ranges and excitation, then what would show of each cause."""
        seen, record = self.seen, self.seen.record
        (low_um, high_um) = record.y_range_um
        per_sample = seen.noise.rms_um / max(high_um - low_um, 1e-300)
        first = [
            *(f"channel {name}: {low:.5g} .. {high:.5g}" for name, (low, high) in record.aux_ranges.items()),
            f"noise: {seen.noise.describe()}, {100.0 * per_sample:.2g} % of the stroke",
            f"excitation: {seen.swings} swings of {seen.sizes} sizes, {seen.lowest_Hz:.3g} to {seen.highest_Hz:.3g} "
            f"Hz, at most {seen.fastest_V_per_s:.4g} V/s; {seen.rests} rests, the longest {seen.longest_rest_s:.3g} s",
            *(f"warning: {line}" for line in self.warnings),
        ]
        excited = {True: "yes", False: "no", None: ""}
        rows = [[able.name, excited[able.excited], able.text()] for able in self.abilities]
        return Summary(record.one_line(), ["cause", "excited", "what would show"], rows, left=3, first=first)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        seen, record = self.seen, self.seen.record
        return {
            "source": record.source,
            "samples": record.samples,
            "segments": [{"name": part.name, "samples": part.samples} for part in record.segments],
            "Ts_s": record.Ts_s,
            "duration_s": record.samples * record.Ts_s,
            "voltage_V": list(record.u_range_V),
            "displacement_um": list(record.y_range_um),
            "channels": {name: list(ends) for name, ends in record.aux_ranges.items()},
            "noise": seen.noise.to_json(),
            "excitation": {name: getattr(seen, name) for name in EXCITATION},
            "requirements": [{"cause": a.name, "met": bool(a.excited), "why": a.text()} for a in self.abilities],
            "warnings": [*record.warnings, *self.warnings],
        }


@one_blas_thread()
def inspect(record: Record) -> Inspection:
    """The content of a record and what it could show. Raises RecordError for a record too short for any fit."""
    seen, warnings = Excitation.of(record), check_for_fit(record, RULES, 3 * RULES)
    try:
        scene = prepare(record).excerpt()
    except RecordError as refused:
        return Inspection(seen, (), (*warnings, str(refused)))
    white_um = seen.noise.rms_um * np.random.default_rng(0).standard_normal(scene.samples)
    residual = Residual(scene, dataclasses.replace(start(scene), error=white_um, rms_um=seen.noise.rms_um))
    return Inspection(seen, abilities(residual, residual, {}), warnings)
