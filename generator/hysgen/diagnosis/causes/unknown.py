"""Unknown: changes at one instant, which no model can predict; a knock, a loosened clamp, a switched amplifier.

The displacement jumps, or the gain changes, and stays so. Without these parts a chain would explain them by the slow
causes that resemble them most, a drift or aging. Structure of another shape that is left in the residual is described
in words (`diagnosis.identifiability`).
"""

import dataclasses
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.base import Cause, Effect, Residual, Signature
from hysgen.diagnosis.extension import Correction, Extension
from hysgen.diagnosis.probe import Chain, Extent, Fit, Part, RunSignals, Scene, ShapeParameter, standard_errors
from hysgen.diagnosis.remedy import Advice, Seen
from hysgen.model.remaining import LEAST_SHARE, Near, falls_from_each_row
from hysgen.model.residual import BLOCKS, residual_noise

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]
T = TypeVar("T")

AT_ONCE = 4
"""Number of jumps that one step of the search adds at most; the search drops those that do not lower the score."""

LOCATION_ORDER = 2.0
"""Order of the time of a change: its standard error falls with the number of samples n as 1/n."""

LISTED = 4
"""Number of changes that the evidence lists."""

CLEARLY = 3.0
"""Standard errors of a change in the rows around it: in noise the largest of BLOCKS places has 2.5."""

FEWEST = 6
"""Least rows on each side of a change for the fit of a line, the command, the fitted displacement and the change: 12
rows for 5 weights."""

LAGS = 5.0
"""Time constants of the lag behind a change of the gain until it shows: all but 1 % of it."""

CHANGE = ShapeParameter("change", "1", lambda extent: (-0.9, 9.0))


@dataclass(frozen=True)
class SuddenPart(Part):
    """Jumps of the displacement, and changes of the gain about the displacement at 0 V, at one instant each.

    jumps_s: times of the jumps, each with one added column, 1 from then on. gains: pairs of a time in s and the
    relative change of the gain from then on.
    """

    cause: ClassVar[str] = "unknown"
    place: ClassVar[int] = 100
    timed: ClassVar[bool] = True
    flexible: ClassVar[bool] = True
    jumps_s: tuple[float, ...] = ()
    gains: tuple[tuple[float, float], ...] = ()

    @property
    def parameters(self) -> tuple[tuple[str, ShapeParameter], ...]:
        return tuple((f"unknown.{i}.change", CHANGE) for i, _ in enumerate(self.gains))

    @property
    def values(self) -> tuple[float, ...]:
        return tuple(change for _, change in self.gains)

    def with_values(self, values: Sequence[float]) -> Self:
        pairs = zip(self.gains, values, strict=True)
        return dataclasses.replace(self, gains=tuple((at_s, value) for (at_s, _), value in pairs))

    @property
    def times_s(self) -> tuple[float, ...]:
        """Times of all changes."""
        return (*self.jumps_s, *(at_s for at_s, _ in self.gains))

    @property
    def added(self) -> int:
        return len(self.jumps_s)

    @property
    def weight_orders(self) -> float:
        return len(self.jumps_s) + LOCATION_ORDER * len(self.times_s)

    def gain_change(self, t_s: Floats) -> Floats:
        change = np.zeros(t_s.shape if self.gains else ())
        for at_s, more in self.gains:
            change += more * (t_s >= at_s)
        return change

    def columns(self, run: RunSignals, extent: Extent, seen: Callable[[Floats], Floats]) -> list[Floats]:
        t_s = run.time_s(extent.Ts_s)
        return [(t_s >= at_s).astype(np.float64) for at_s in self.jumps_s]


@dataclass(frozen=True)
class SuddenChanges(Correction):
    """Jumps: pairs of a time in s and a size in um. gains: pairs of a time and the change of the gain about zero_um."""

    jumps: tuple[tuple[float, float], ...]
    gains: tuple[tuple[float, float], ...]
    zero_um: float

    def removed(self, y_um: Floats, t_s: Floats) -> Floats:
        """zero + (y - jumps(t) - zero) / (1 + change(t))"""
        level_um = y_um - sum((size_um * (t_s >= at_s) for at_s, size_um in self.jumps), np.zeros(len(t_s)))
        return self.zero_um + (level_um - self.zero_um) / (1.0 + SuddenPart(gains=self.gains).gain_change(t_s))


class UnknownCause(Cause):
    name = "unknown"
    rank = 1000
    experiment = "look at the mounting and the amplifier at this time"
    mistaken_for = ("drift", "aging")
    part = SuddenPart
    extends = False
    prior_odds = 1e-4  # an event of once a day, in a record of some ten seconds
    starts = 3

    def without_one_part(self, chain: Chain) -> list[Chain]:
        part = chain.of(SuddenPart)
        kept = [dataclasses.replace(part, jumps_s=_without(part.jumps_s, i)) for i, _ in enumerate(part.jumps_s)]
        kept += [dataclasses.replace(part, gains=_without(part.gains, i)) for i, _ in enumerate(part.gains)]
        return [chain.having(one) if one.times_s else self.without(chain) for one in kept]

    def admissible(self, scene: Scene, fit: Fit) -> bool:
        """Whether each change takes place at once (`_Rows.at_once`)."""
        if not self.present(fit.chain):
            return True
        at = _Rows.of(scene, fit.error)
        changes = [*_jumps(scene, fit, at.rows), *_gain_changes(scene, fit, at.rows)]
        return all(at.at_once(fit.error[at.rows], *change) for change in changes)

    def evidence(self, scene: Scene, fit: Fit) -> float:
        """Sum over the jumps of 2 ln(likelihood ratio by the rows around it / number of rows).

        A hysteresis has no jump between two samples, so its misfit, which limits what a fall of the residual says, is
        no rival there; that the time may be that of any row is. A change of the gain behind the lag is no jump: a bend
        of the misfit resembles it.
        """
        if not self.present(fit.chain):
            return 0.0
        at = _Rows.of(scene, fit.error)
        error, fitted_um = fit.error[at.rows], (scene.y_um - fit.error)[at.rows]
        near = [at.near(error, *jump, fitted_um).evidence(at.noise_um) for jump in _jumps(scene, fit, at.rows)]
        return math.fsum(max(one - 2.0 * math.log(len(at.rows)), 0.0) for one in near)

    def proposals(self, residual: Residual) -> list[Chain]:
        """One and AT_ONCE more jumps where they lower the error most, one after the other, or a change of the gain."""
        scene, chain = residual.scene, residual.fit.chain
        if not _one_segment(scene):
            return []
        part = chain.get(SuddenPart) or SuddenPart()
        changes = _Changes.of(residual)
        jumps = list(_jumps_s(changes, part.times_s))
        sets = [jumps[:count] for count in sorted({1, len(jumps)}) if jumps]
        chains = [chain.having(dataclasses.replace(part, jumps_s=(*part.jumps_s, *more))) for more in sets]
        found = dataclasses.replace(changes, direction=residual.about_zero_um()[changes.at.rows]).best(part.times_s)
        if found is not None:
            at_s, change, _ = found
            change = min(max(change, -0.5), 0.5)
            chains.append(chain.having(dataclasses.replace(part, gains=(*part.gains, (at_s, change)))))
        return chains

    def effect(self, residual: Residual) -> Effect:
        """Of a jump in the middle of the record."""
        t_s = residual.scene.time_s
        return Effect("um in one jump", (t_s >= 0.5 * residual.scene.span_s).astype(np.float64))

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The least change divided by its standard error."""
        scene, fit = residual.scene, residual.fit
        part, errors = fit.chain.of(SuddenPart), standard_errors(scene, fit)
        first = fit.chain.first_column(SuddenPart)
        changes = [
            (at_s, size_um, float(error), f"the displacement jumps by {size_um:+.3g} um at {at_s:.4g} s")
            for at_s, size_um, error in zip(
                part.jumps_s, _jump_sizes_um(scene, fit), errors.added[first:], strict=False
            )
        ] + [
            (
                at_s,
                change,
                errors.coordinates[f"unknown.{i}.change"],
                f"the gain changes by {change:+.2%} at {at_s:.4g} s",
            )
            for i, (at_s, change) in enumerate(part.gains)
        ]
        listed = [text for *_, text in sorted(changes)]
        more = [f"{len(listed) - LISTED} further changes"] if len(listed) > LISTED else []
        return Signature(
            z=min(abs(size) / max(error, 1e-15) for _, size, error, _ in changes),
            text=", ".join([*listed[:LISTED], *more]) + " (the models are fitted and scored without)",
        )

    def advice(self, seen: Seen) -> Advice:
        return Advice(
            "the stage or its sensor changed suddenly, and may do so again: no model foresees it",
            "look at clamps, glue, connectors and the amplifier at this time; after a lasting step of the gain, refit",
        )

    def extension(self, residual: Residual) -> Extension:
        """No part of a model, because a change says nothing about the next record; the changes of this one."""
        scene, fit = residual.scene, residual.fit
        part = fit.chain.of(SuddenPart)
        jumps = tuple(zip(part.jumps_s, _jump_sizes_um(scene, fit), strict=True))
        return Extension(correction=SuddenChanges(jumps, part.gains, scene.zero_um(fit.chain, fit.weights)))


def _without(items: tuple[T, ...], i: int) -> tuple[T, ...]:
    return items[:i] + items[i + 1 :]


def _one_segment(scene: Scene) -> bool:
    """Whether the times of all runs count from the start of one segment."""
    first = scene.runs[0].segment
    return len(scene.runs) == 1 or (first > 0 and all(run.segment == first for run in scene.runs))


def _jumps(scene: Scene, fit: Fit, rows: Rows) -> list[tuple[float, Floats, float]]:
    """Time, effect on the rows before it is cut off, and time constant of each jump: 0, of the sensor or the frame."""
    sizes_um = _jump_sizes_um(scene, fit)
    times_s = fit.chain.of(SuddenPart).jumps_s
    return [(at_s, np.full(len(rows), size_um), 0.0) for at_s, size_um in zip(times_s, sizes_um, strict=True)]


def _gain_changes(scene: Scene, fit: Fit, rows: Rows) -> list[tuple[float, Floats, float]]:
    """`_jumps` of each change of the gain, which may take place before the lag."""
    gains = fit.chain.of(SuddenPart).gains
    about_zero_um = Residual(scene, fit).about_zero_um()[rows] if gains else np.zeros(0)
    return [(at_s, change * about_zero_um, fit.chain.lag_s) for at_s, change in gains]


def _jump_sizes_um(scene: Scene, fit: Fit) -> list[float]:
    """Size of each jump of a fit whose chain has the part."""
    first = scene.column_of(fit.chain, SuddenPart)
    return [float(size_um) for size_um in fit.weights[first : first + fit.chain.of(SuddenPart).added]]


@dataclass(frozen=True, eq=False)
class _Rows:
    """The fitted rows in the order of time: (r,) rows, t_s, u_V. noise_um: of the residual; span_s: of the record."""

    rows: Rows
    t_s: Floats
    u_V: Floats
    noise_um: float
    span_s: float

    @classmethod
    def of(cls, scene: Scene, error: Floats) -> Self:
        """error: (n,) residual of a fit."""
        rows = scene.rows[np.argsort(scene.time_s[scene.rows], kind="stable")]
        u_V = np.concatenate([run.u_V for run in scene.runs])
        return cls(rows, scene.time_s[rows], u_V[rows], residual_noise(error[scene.dense]), scene.span_s)

    def at_once(self, error: Floats, at_s: float, effect: Floats, lag_s: float = 0.0) -> bool:
        """Whether at least LEAST_SHARE of a change, and CLEARLY standard errors, show in the rows around it."""
        near = self.near(error, at_s, effect, lag_s)
        return near.share > max(LEAST_SHARE, CLEARLY * self.noise_um / math.sqrt(near.power_um2))

    def near(
        self, error: Floats, at_s: float, effect: Floats, lag_s: float = 0.0, fitted_um: Floats | None = None
    ) -> Near:
        """The change in the rows around it, by least squares of the residual without the change.

        On a straight line in time, the command, and the change; over as few rows as show the change with twice CLEARLY
        standard errors, and a 40th of all rows at most. error: (r,) residual with the change; effect: (r,) change of
        the displacement, before it is cut off at at_s; lag_s: time constant with which it shows. fitted_um: (r,)
        displacement of the fit, with which its misfit moves, if the line shall have a part of it, too.
        """
        count, middle = len(self.rows), int(np.searchsorted(self.t_s, at_s))
        size_um = abs(float(effect[min(middle, count - 1)])) + 1e-300
        shown = 8.0 * (2.0 * CLEARLY * self.noise_um / size_um) ** 2 + FEWEST + LAGS * lag_s / self.span_s * count
        half = int(min(shown, count / (2 * BLOCKS)))
        near = slice(max(middle - half, 0), middle + half)
        since_s = self.t_s[near] - at_s
        # The fit takes the change as one at once, at the time of half of the one behind the lag.
        found = error[near] + effect[near] * (since_s >= 0.0)
        begun_s = np.maximum(since_s + math.log(2.0) * lag_s, 0.0)
        change = effect[near] * (-np.expm1(-begun_s / lag_s) if lag_s else since_s >= 0.0)
        moving = [] if fitted_um is None else [fitted_um[near] - change]
        smooth = np.vstack([np.ones(len(change)), since_s, self.u_V[near], *moving])
        return Near.of(change, found, smooth)


@dataclass(frozen=True, eq=False)
class _Changes:
    """Least squares with a change at any time.

    direction, error: (r,) effect of a change before it is cut off, residual; basis: (p, r) orthonormal combinations of
    the columns of the chain; on the fitted rows in the order of time. With H the part of `direction` from a time on,
    and P the projector off the basis, the sum of squares falls by (H e)^2 / (H P H).
    """

    at: _Rows
    direction: Floats
    error: Floats
    basis: Floats

    @classmethod
    def of(cls, residual: Residual) -> Self:
        """For a jump of 1 um."""
        at = _Rows.of(residual.scene, residual.fit.error)
        order = np.searchsorted(residual.scene.rows, at.rows)
        basis = residual.projector.basis()[:, order]
        return cls(at, np.ones(len(at.rows)), residual.fit.error[at.rows], basis)

    def best(self, taken_s: Sequence[float]) -> tuple[float, float, Floats] | None:
        """Time, size and orthogonal part, (r,), of the change that lowers the error most.

        A change has a 40th of the rows before and behind it without another one (taken_s, and the ends), because
        errors are judged by blocks of this length. None if there is no such place.
        """
        t_s = self.at.t_s
        falls = falls_from_each_row(
            self.direction, self.error, self.basis, np.searchsorted(t_s, taken_s).tolist(), 1e-9
        )
        at = int(np.argmax(falls))
        if falls[at] <= 0.0:
            return None
        cut = self.direction * (np.arange(len(t_s)) >= at)
        cut = cut - (self.basis @ cut) @ self.basis
        return 0.5 * float(t_s[at - 1] + t_s[at]), float(cut @ self.error / (cut @ cut)), cut


def _jumps_s(changes: _Changes, taken_s: Sequence[float]) -> Iterator[float]:
    """Times of AT_ONCE jumps at most, each the best beside those before it, until one does not take place at once."""
    times_s = list(taken_s)
    for _ in range(AT_ONCE):
        found = changes.best(times_s)
        if found is None:
            return
        at_s, size_um, cut = found
        left = changes.error - size_um * cut
        if len(times_s) > len(taken_s) and not changes.at.at_once(left, at_s, size_um * changes.direction):
            return
        yield at_s
        times_s.append(at_s)
        changes = dataclasses.replace(changes, error=left, basis=np.vstack([changes.basis, cut / np.sqrt(cut @ cut)]))
