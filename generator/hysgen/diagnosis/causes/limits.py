"""Saturation: the output is constant while the command is beyond a level.

Slew: the amplifier limits the rate of the voltage, so fast commands become ramps of constant slope at any level.
"""

import dataclasses
import itertools
import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.base import (
    FEWEST_LIMITED,
    Cause,
    Effect,
    Estimate,
    Residual,
    Signature,
    limited_rows,
)
from hysgen.diagnosis.experiment import Piece
from hysgen.diagnosis.probe import Chain, Fit, Scene, TrainingFit, standard_errors
from hysgen.diagnosis.remedy import Advice, Motion, Seen, strokes, voltage_step
from hysgen.model.path.limits import Saturation, Slew

Floats = NDArray[np.float64]

LEVELS = (0.3, 0.5, 0.65, 0.75, 0.82, 0.88, 0.93, 0.97)
# Closer than LEVELS, because of local minima with a level too far out and a curve that is flat inside the level.
PAIRED = (0.5, 0.57, 0.64, 0.71, 0.78, 0.85, 0.92)

FURTHER_IN = 2

MOST_SLOPE = 0.5
"""Largest slope of the output beyond a level, as a share of that inside: nearer to a limit than to none."""

LIMIT_SLOPE = 0.01
"""Standard deviation of this share for a limit: its own, beside the error of the measurement."""

FREE_SLOPE = 0.4
"""Standard deviation of this share about 1 without a limit: the slopes of a piezo's branches differ by a factor of 2 or
3, and none is near zero while the command moves outward."""


FEWEST_SLOPE = 5
"""Least rows beyond a level for a slope."""

KNOWN = 3.0
"""Least distance of a level from the end of the command in its standard errors: nearer, there may be no limit at all,
and the level that fits best makes its few rows flat."""

LEAST_RESPONSE = 0.05
"""Least share of the largest response to what a level takes away, in the rows from which a slope follows."""

LEAST_MOVING = 0.1
"""Least rms response to the moves of the command beyond a level, as a share of that to all the level takes away."""

UNSEEN = Estimate(0.0, math.inf)
"""Slope beyond a level at which the command only rests."""


class SaturationCause(Cause):
    name = "saturation"
    rank = 10
    experiment = "drive over the whole range of the amplifier"
    mistaken_for = ("slew",)
    part = Saturation
    starts = 3  # a refinement rarely moves from the level of one stroke to that of another

    def proposals(self, residual: Residual) -> list[Chain]:
        chain, operator = residual.fit.chain, residual.scene.operator
        middle, half = 0.5 * (operator.low_V + operator.high_V), 0.5 * (operator.high_V - operator.low_V)
        part, candidates = _part(chain), []
        if part.high_V is None:
            candidates += [chain.having(dataclasses.replace(part, high_V=middle + level * half)) for level in LEVELS]
        if part.low_V is None:
            candidates += [chain.having(dataclasses.replace(part, low_V=middle - level * half)) for level in LEVELS]
        if part.low_V is None and part.high_V is None:
            # If both ends clip, one limit alone may lower the error too little for a step of forward selection.
            for low, high in itertools.product(PAIRED, PAIRED):
                candidates.append(chain.having(Saturation(middle - low * half, middle + high * half)))
        return candidates

    def select_starts(self, candidates: list[TrainingFit]) -> list[TrainingFit]:
        """The best starts, of each side alone and of both, and the next levels further in.

        Beside a side that clips, the other may show in too few rows. A level outside the true one is a
        local minimum, because the output is flat there, too: a refinement moves a level outward more easily.
        """
        best_of_sides = {tuple(name for name, *_ in _part(start.chain).levels): start for start in reversed(candidates)}
        chosen = candidates[: self.starts]
        for best in best_of_sides.values():
            further = {id(start): _further_in(_part(start.chain), _part(best.chain)) for start in candidates}
            inside = [start for start in candidates if 0.0 < further[id(start)] < math.inf]
            chosen += [best, *sorted(inside, key=lambda start: further[id(start)])[:FURTHER_IN]]
        return [start for start in candidates if start in chosen]

    def admissible(self, scene: Scene, fit: Fit) -> bool:
        part = fit.chain.get(Saturation)
        if part is None:
            return True
        if any(abs(one.value) >= MOST_SLOPE for one in _slopes(Residual(scene, fit))):
            return False
        errors = standard_errors(scene, fit).coordinates
        u_V = np.concatenate([run.u_V for run in scene.runs])[scene.rows]
        return all(
            float((sign * (u_V - level_V)).max()) > KNOWN * errors[f"saturation.{name}"]
            for name, level_V, sign in part.levels
        )

    def evidence(self, scene: Scene, fit: Fit) -> float:
        """Sum over the levels of 2 ln(N(s; 0, LIMIT_SLOPE) / N(s; 1, FREE_SLOPE)), with the slope s beyond the level.

        The misfit of the hysteresis, which limits what a fall of the residual says, is absent beyond a limit. Both
        deviations are widened by the standard error of s.
        """
        if not self.present(fit.chain):
            return 0.0
        total = 0.0
        for one in _slopes(Residual(scene, fit)):
            if one is UNSEEN:
                continue
            limit, free = (math.hypot(wide, one.standard_error) for wide in (LIMIT_SLOPE, FREE_SLOPE))
            total += ((one.value - 1.0) / free) ** 2 - (one.value / limit) ** 2 - 2.0 * math.log(limit / free)
        return total

    def simpler_forms(self, chain: Chain) -> list[Chain]:
        """Chains in which only one of the two ends clips."""
        part = _part(chain)
        if part.low_V is None or part.high_V is None:
            return []
        return [chain.having(Saturation(high_V=part.high_V)), chain.having(Saturation(low_V=part.low_V))]

    def effect(self, residual: Residual) -> Effect:
        """The highest level that FEWEST_SLOPE samples exceed."""
        command_V = np.sort(np.concatenate([run.u_V for run in residual.scene.runs])[residual.scene.rows])
        return Effect("V", limit=True, least=float(command_V[-FEWEST_SLOPE]))

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """Slope of the output over the command beyond the level, as a share of the mean slope of the record."""
        part = _part(residual.fit.chain)
        errors = standard_errors(residual.scene, residual.fit).coordinates
        parameters, texts, slopes = {}, [], _slopes(residual)
        for (name, level_V, _), slope in zip(part.levels, slopes, strict=True):
            parameters[name] = Estimate(level_V, errors[f"saturation.{name}"])
            flat = "the command only rests" if slope is UNSEEN else f"the slope is {slope.value:.2f} of that inside"
            texts.append(f"beyond {level_V:.4g} V {flat}")
        return Signature(
            z=float(min((1.0 - abs(one.value)) / 0.1 for one in slopes)),
            text="; ".join(texts),
            parameters=parameters,
        )

    def advice(self, seen: Seen) -> Advice:
        low_V, high_V = seen.model.u_min_V, seen.model.u_max_V
        bottom_V, top_V = seen.values.get("low_V", low_V), seen.values.get("high_V", high_V)
        ends = " and ".join(f"{'below' if name == 'low_V' else 'above'} {at:.4g} V" for name, at in seen.values.items())
        lost = 1.0 - (min(top_V, high_V) - max(bottom_V, low_V)) / (high_V - low_V)
        return Advice(
            f"commands {ends} do not reach the stage: the stroke is cut, and a loop winds up",
            "keep commands inside (hysgen waveform takes limits), or use an amplifier of a wider range: "
            f"{100.0 * lost:.2g} % of the range of this record is lost",
        )

    def motion(self, values: Mapping[str, float], Ts_s: float) -> Motion:
        return strokes(1.0, Ts_s)


def _part(chain: Chain) -> Saturation:
    """The saturation part of the chain; a part that does not clip if the chain has none."""
    return chain.get(Saturation) or Saturation()


def _further_in(part: Saturation, other: Saturation) -> float:
    """Sum in V by which the levels are further in than those of `other`; inf if one is further out or missing."""
    total = 0.0
    for level_V, other_V, sign in ((part.low_V, other.low_V, 1.0), (part.high_V, other.high_V, -1.0)):
        if (level_V is None) != (other_V is None):
            return math.inf
        if level_V is not None and other_V is not None:
            inward_V = sign * (level_V - other_V)
            total += inward_V if inward_V >= 0.0 else math.inf
    return total


def _slopes(residual: Residual) -> list[Estimate]:
    """For each level, the share s of the mean gain with which the displacement follows the command beyond the level.

        s = sum x e / sum x^2,   x = response at the mean gain to the voltage that the level takes away

    e: residual; the voltage, x and e about their means over each excursion beyond the level, because hysteresis and
    drift move an excursion as a whole. 0 if the output is constant beyond the level, 1 if the slope does not change
    there; UNSEEN if the command rests there, and 1 with fewer than FEWEST_SLOPE rows. Standard error: that of an error
    which keeps its sign to x over an excursion, because the misfit of the hysteresis does so while the lag follows.
    """
    scene, fit = residual.scene, residual.fit
    part, u_V = fit.chain.of(Saturation), np.concatenate([run.u_V for run in scene.runs])
    gain = float(np.polyfit(u_V[scene.rows], scene.y_um[scene.rows], 1)[0])
    slopes = []
    for name, _, _ in part.levels:
        free = fit.chain.having(dataclasses.replace(part, **{name: None}))
        taken = [
            np.append(np.zeros(len(run.history)), gain * (free.amplified(*command) - fit.chain.amplified(*command)))
            for run, command in zip(scene.runs, scene.commands, strict=True)
        ]
        response = np.concatenate(scene.responses(taken, fit.chain))
        beyond = np.abs(response) > LEAST_RESPONSE * np.abs(response[scene.rows]).max()
        rows = scene.rows[beyond[scene.rows]]
        if len(rows) < FEWEST_SLOPE:
            slopes.append(Estimate(1.0, 1.0))
            continue
        excursions = np.cumsum(np.diff(beyond, prepend=False))[rows]
        moving = np.concatenate(scene.responses([_about_means(one, _excursions(one)) for one in taken], fit.chain))
        x, e = (_about_means(values[rows], excursions) for values in (moving, fit.error))
        power = float(x @ x) + 1e-300
        if power < LEAST_MOVING**2 * float(response[rows] @ response[rows]):
            slopes.append(UNSEEN)
            continue
        share = float(x @ e) / power
        left = e - share * x
        held = float(np.mean(left * left) * np.sum(np.bincount(excursions, np.abs(x)) ** 2))
        slopes.append(Estimate(share, math.sqrt(held) / power))
    return slopes


def _excursions(taken: Floats) -> NDArray[np.intp]:
    """(n,) number of the excursion beyond a level, or of the time between two; taken: (n,) what is beyond it."""
    return np.asarray(np.cumsum(np.diff(taken != 0.0, prepend=False)))


def _about_means(values: Floats, groups: NDArray[np.intp]) -> Floats:
    """The values less the mean of their group."""
    counts = np.maximum(np.bincount(groups), 1)
    return np.asarray(values - (np.bincount(groups, values) / counts)[groups])


QUANTILES = (0.3, 0.5, 0.65, 0.77, 0.85, 0.9, 0.935, 0.96, 0.975, 0.985, 0.992, 0.997, 0.999)
"""Quantiles of the command's rates that are the starting values of the limit; two or three edges are 0.2 % of a log."""


GAP = 2.0
"""Largest ratio of neighbouring starting values: a fit from half or twice a limit finds it, from less not always."""


class SlewCause(Cause):
    name = "slew"
    rank = 20
    experiment = Piece.STEPS
    part = Slew

    def admissible(self, scene: Scene, fit: Fit) -> bool:
        return not self.present(fit.chain) or limited_rows(scene, fit.chain, Slew) >= FEWEST_LIMITED

    def proposals(self, residual: Residual) -> list[Chain]:
        chain, scene = residual.fit.chain, residual.scene
        if self.present(chain):
            return []
        rates = np.concatenate([np.abs(np.diff(run.u_V)) / run.stride for run in scene.runs]) / scene.Ts_s
        levels = _without_gaps(np.unique(np.quantile(rates[rates > 1e-6 * rates.max()], QUANTILES)))
        # The fitted lag may contain the effect of the limit, so shorter lags are starting values too.
        return [
            dataclasses.replace(chain.having(Slew(rate, rate)), lag_s=share * chain.lag_s)
            for rate in levels.tolist()
            for share in (1.0, 0.25, 0.05)
        ]

    def effect(self, residual: Residual) -> Effect:
        """The highest rate of the command that FEWEST_LIMITED samples exceed."""
        scene = residual.scene
        rates = np.concatenate([np.abs(np.diff(run.u_V)) / run.stride for run in scene.runs])
        return Effect("V/s", limit=True, least=float(np.sort(rates)[-FEWEST_LIMITED]) / scene.Ts_s)

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The rate divided by its standard error, and the number of samples at which the limit delays the command."""
        scene, chain = residual.scene, residual.fit.chain
        rate = chain.of(Slew).rise_V_s
        error = rate * standard_errors(scene, residual.fit).coordinates["slew.rise_V_s"]
        held = limited_rows(scene, chain, Slew)
        z = rate / max(error, 1e-15)
        return Signature(
            z=z,
            text=f"the output never follows faster than {rate:.4g} V/s +- {error:.1g}, "
            f"at any level ({held} samples held back)",
            parameters={"rate_V_per_s": Estimate(rate, error)},
        )

    def advice(self, seen: Seen) -> Advice:
        rate, range_V = seen.values["rate_V_per_s"], seen.model.u_max_V - seen.model.u_min_V
        return Advice(
            f"a step over the range of {range_V:.4g} V takes {1e3 * range_V / rate:.3g} ms, whatever is commanded",
            f"ramps below {rate:.4g} V/s (full strokes up to {rate / (np.pi * range_V):.3g} Hz as a sine), or an "
            "amplifier of more current: it charges the ceramic, so twice the current takes half the time",
        )

    def motion(self, values: Mapping[str, float], Ts_s: float) -> Motion:
        return voltage_step(max(100.0 / values["rate_V_per_s"], 30.0 * Ts_s), Ts_s)


def _without_gaps(levels: Floats) -> Floats:
    """Rising levels with others between them, so that none is more than GAP times the one before it.

    Where a few edges are all that is fast, no quantile lies between them and the rest, but the limit may.
    """
    between = [
        np.geomspace(a, b, math.ceil(math.log(b / a) / math.log(GAP)) + 1)[:-1] for a, b in itertools.pairwise(levels)
    ]
    return np.concatenate([*between, levels[-1:]])
