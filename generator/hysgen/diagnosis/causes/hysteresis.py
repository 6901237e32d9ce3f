"""Memory: the output depends on past extremes of the input, so the loop stays open at any frequency.

Curve: without memory, the displacement at rest is no straight line of the voltage.
Relaxation: domains switch by thermal activation, so the loop depends on the rate and a held input lets h creep.
"""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.base import Cause, Effect, Estimate, Residual, Signature, turns
from hysgen.diagnosis.experiment import Piece
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Fit, Part, Scene, ShapeParameter, functional_error, standard_errors
from hysgen.diagnosis.remedy import Advice, Motion, Seen, strokes, voltage_step
from hysgen.display import decimal
from hysgen.fitting.operator import CURVE, RELAXING, PathSize
from hysgen.fitting.path import RELAXATIONS
from hysgen.fitting.refit import LOOP_SHARE, loop_frequencies, loop_width
from hysgen.machine.kernels.operators import play_operators
from hysgen.model.model import Model
from hysgen.model.path import InputBlock
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.record.series import turning_rows

Floats = NDArray[np.float64]

SIZES = (
    PathSize(plays=6, degree=2, states=0, hats=3),
    PathSize(plays=8, degree=3, states=0),
    PathSize(plays=6, degree=2, states=2, hats=3),
    PathSize(),
    PathSize(plays=12, degree=5),
    PathSize(plays=24, degree=5),
)
"""Sizes of the hysteresis in rising cost: a short or noisy record does not determine the larger ones."""

FEWEST = 4
"""Least number of samples of a counted swing."""
WITNESS = 0.25
"""Half-width, in half ranges of the input, of the play that measures the opening of the loop."""


FOLLOWS: Final = 0.5
"""Least share of the power of the displacement that follows the command, as that of a drive that is measured does."""


class MemoryCause(Cause):
    name = "memory"
    kind = "hysteresis"
    rank = 40
    prior_odds = 999.0  # every ceramic remembers: of drives without it, one in a thousand is measured for a hysteresis
    experiment = Piece.NESTED

    def present(self, chain: Chain) -> bool:
        return chain.memory

    def without(self, chain: Chain) -> Chain:
        return dataclasses.replace(chain, memory=False)

    def admissible(self, scene: Scene, fit: Fit) -> bool:
        """A command that never turns remembers no extreme: what a stage does on its one way is a curve, or creep."""
        return not fit.chain.memory or turns(scene)

    def evidence(self, scene: Scene, fit: Fit) -> float:
        """Takes the odds of a drive back where the displacement does not follow the command: that of nothing driven."""
        if not fit.chain.memory:
            return 0.0
        # Steps and bends are many enough for slow moves of a stage, too.
        stiff = dataclasses.replace(fit.chain, parts=tuple(part for part in fit.chain.parts if not part.flexible))
        y_um, beside = scene.y_um[scene.rows], scene.added_columns(stiff)[:, scene.rows].T
        without_um = y_um - beside @ np.linalg.lstsq(beside, y_um - y_um.mean(), rcond=None)[0]
        follows = without_um.var() - fit.rms_um**2 >= FOLLOWS * y_um.var()
        return 0.0 if follows else 2.0 * math.log(Cause.prior_odds / self.prior_odds)

    def proposals(self, residual: Residual) -> list[Chain]:
        chain = residual.fit.chain
        return [] if chain.memory else [dataclasses.replace(chain, memory=True, curve=True)]

    def effect(self, residual: Residual) -> Effect:
        """Of a play, per um of the opening of its loop."""
        half_V = 0.5 * (residual.scene.operator.high_V - residual.scene.operator.low_V)
        return Effect("um between the way up and the way down", _slack(residual) / (2.0 * WITNESS * half_V))

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """Sign test on the swings between turning points: the number of swings on which the fit with memory is better.

        Without memory, the fit with memory is better on each swing with probability 1/2.
        """
        scene = residual.scene
        swing = np.concatenate([swings(run.u_V) + 10**9 * i for i, run in enumerate(scene.runs)])[scene.rows]
        with_um, without_um = residual.fit.error[scene.rows], rival.error[scene.rows]
        _, place = np.unique(swing, return_inverse=True)
        size = np.bincount(place)
        better = np.bincount(place, with_um**2) < np.bincount(place, without_um**2)
        counted = size >= FEWEST
        tosses, wins = int(counted.sum()), int(better[counted].sum())
        z = (2.0 * wins - tosses) / np.sqrt(max(tosses, 1))
        return Signature(float(z), f"past extremes explain {wins} of {tosses} swings better than dynamics do")

    def seen_in(self, signature: Signature, model: Model, residual: Residual) -> Signature:
        """The width of the model's loop at the slow frequency at which `hysgen diff` compares loops.

        Its standard error is that of the opening of the fitted hysteresis under the same slow sine.
        """
        f_Hz = loop_frequencies(model)[0]
        width_um, _ = loop_width(model, f_Hz)
        error_um = functional_error(residual.scene, residual.fit, _opening(residual, model))
        words = f"under {f_Hz:.3g} Hz the way up and the way down differ by {decimal(width_um, 3)} um on average"
        parameters = {"loop_um": Estimate(width_um, error_um), "loop_Hz": Estimate(f_Hz, math.nan)}
        return Signature(signature.z, f"{signature.text}; {words}", parameters)

    def advice(self, seen: Seen) -> Advice:
        model, f_Hz = seen.model, seen.values["loop_Hz"]
        middle_V, quarter_V = 0.5 * (model.u_min_V + model.u_max_V), 0.25 * (model.u_max_V - model.u_min_V)
        half_um = loop_width(model.within(input_V=(middle_V - quarter_V, middle_V + quarter_V)), f_Hz)[0]
        return Advice(
            f"one voltage stands for displacements {seen.values['loop_um']:.3g} um apart, by the way on which it is "
            "reached; no calibration curve can be better than half of that",
            f"follow the inverse of this model (hysgen waveform), drive by charge, or close a loop around the sensor; "
            f"half the stroke has a loop of {half_um:.3g} um",
        )

    def motion(self, values: Mapping[str, float], Ts_s: float) -> Motion:
        return strokes(1.0 / values["loop_Hz"], Ts_s, loop=True)

    def motions_um(self, motion: Motion, seen: Seen) -> tuple[Floats, Floats] | None:
        """The second of two periods, and the middle of its way up and its way down."""
        twice = dataclasses.replace(motion, levels=np.tile(motion.levels, 2))
        both = super().motions_um(twice, seen)
        if both is None:
            return None
        closed_um = both[0][len(motion.levels) :]
        return closed_um, 0.5 * (closed_um + closed_um[::-1])

    def forms(self, extension: Extension) -> list[Extension]:
        return [dataclasses.replace(extension, size=size) for size in SIZES]

    def extension(self, residual: Residual) -> Extension:
        return Extension(size=PathSize(), lag_s=residual.fit.chain.lag_s)


class CurveCause(Cause):
    """h(v) = g(v), single-valued; a straight line without it. The hysteresis of a stage with memory bends, too."""

    name = "curve"
    kind = "hysteresis"
    rank = 39
    prior_odds = 1.0  # of the few drives that do not remember, as many bend as do not
    held_by = "memory"
    experiment = Piece.NESTED

    def present(self, chain: Chain) -> bool:
        return chain.curve and not chain.memory

    def without(self, chain: Chain) -> Chain:
        return dataclasses.replace(chain, curve=chain.memory)

    def proposals(self, residual: Residual) -> list[Chain]:
        chain = residual.fit.chain
        return [] if chain.curve else [dataclasses.replace(chain, curve=True)]

    def effect(self, residual: Residual) -> Effect:
        """Of a parabola, per um of its bow over the range of the voltage."""
        scene = residual.scene
        bows = [1.0 - scene.operator.normalised(run.u_V) ** 2 for run in scene.runs]
        return Effect("um from a straight line", np.concatenate(bows))

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The largest bow of the curve, divided by the error that its weights have in white noise."""
        scene, fit = residual.scene, residual.fit
        v_V = np.concatenate([fit.chain.amplified(run.u_V, scene.Ts_s * run.stride) for run in scene.runs])
        paths = zip(scene.runs, scene.paths(fit.chain, fit.weights), strict=True)
        h_um = np.concatenate([path[len(run.history) :] for run, path in paths])
        ends = [int(np.argmin(v_V)), int(np.argmax(v_V))]
        bow_um = h_um - np.interp(v_V, v_V[ends], h_um[ends])
        at = int(np.argmax(np.abs(bow_um)))
        error_um = fit.rms_um * math.sqrt(scene.hysteresis_size(fit.chain) / len(scene.rows))
        most_um = float(bow_um[at])
        return Signature(
            z=abs(most_um) / max(error_um, 1e-15),
            text=f"at {v_V[at]:.4g} V the curve lies {decimal(most_um, 3)} um from a straight line between its ends, "
            f"the same on the way up and down; a straight line leaves {rival.rms_um / fit.rms_um:.3g} times the error",
            parameters={"bow_um": Estimate(most_um, error_um)},
        )

    def advice(self, seen: Seen) -> Advice:
        bow_um = abs(seen.values["bow_um"])
        return Advice(
            f"equal steps of the voltage give unequal moves: one gain for all is wrong by up to {bow_um:.3g} um",
            "a table of the curve, or the inverse of this model, in place of one gain; a part of the range bends less: "
            f"half of it by about {0.25 * bow_um:.2g} um",
        )

    def motion(self, values: Mapping[str, float], Ts_s: float) -> Motion:
        return strokes(1.0, 1e-3, loop=True)

    def motions_um(self, motion: Motion, seen: Seen) -> tuple[Floats, Floats]:
        """A parabola of this bow, and the line between its ends."""
        line_um = seen.stroke_um * motion.levels
        return line_um + 4.0 * seen.values["bow_um"] * motion.levels * (1.0 - motion.levels), line_um

    def extension(self, residual: Residual) -> Extension:
        return Extension(size=CURVE, lag_s=residual.fit.chain.lag_s)


def swings(u_V: Floats) -> NDArray[np.int64]:
    """(n,) number of the swing of each sample; a plateau belongs to the swing before it, or is the first swing."""
    moves = np.flatnonzero(np.diff(u_V))
    return np.searchsorted(np.append(moves[:1], turning_rows(u_V, 0.0)), np.arange(len(u_V))).astype(np.int64)


def _opening(residual: Residual, model: Model) -> Floats:
    """(size of h,) mean opening of each column of h under the slow sine of `loop_width`, in its second period."""
    middle_V, half_V = 0.5 * (model.u_min_V + model.u_max_V), LOOP_SHARE * 0.5 * (model.u_max_V - model.u_min_V)
    u_V = middle_V + half_V * np.sin(np.linspace(0.0, 4.0 * np.pi, 2001))
    return np.asarray(np.trapezoid(residual.scene.operator.columns(u_V)[:, 1000:], u_V[1000:])) / (2.0 * half_V)


def _slack(residual: Residual) -> Floats:
    """(n,) z(u) - u of the play WITNESS, in V."""
    scene = residual.scene
    width = np.array([0.5 * WITNESS * (scene.operator.high_V - scene.operator.low_V)])
    return np.concatenate([play_operators(run.u_V, width, run.u_V[:1].copy())[:, 0] - run.u_V for run in scene.runs])


STARTS = (0.015, 0.04)
"""Starting values of the relaxation, a third of the logarithm of its range from either end."""

RELAXING_SIZES = (dataclasses.replace(RELAXING, plays=12), RELAXING)
"""Sizes of a hysteresis that relaxes, in rising cost."""


@dataclass(frozen=True)
class RelaxationPart(Part):
    """Plays that relax by `half_widths` of their half-widths per factor e of time (`model.path.hysteresis`)."""

    cause: ClassVar[str] = "relaxation"
    place: ClassVar[int] = 30
    amplifies: ClassVar[bool] = True
    table: ClassVar[tuple[ShapeParameter, ...]] = (
        ShapeParameter("half_widths", "1", lambda e: RELAXATIONS, logarithm=True, step=lambda e: 1e-3),
    )
    half_widths: float

    @property
    def relaxation(self) -> float:
        return self.half_widths


class RelaxationCause(Cause):
    name = "relaxation"
    kind = "hysteresis"
    rank = 45
    experiment = Piece.RATES
    mistaken_for = ("creep",)
    part = RelaxationPart
    starts = 2

    def admissible(self, scene: Scene, fit: Fit) -> bool:
        """Only plays relax; and a run whose samples are several periods apart would relax too little."""
        return not self.present(fit.chain) or (fit.chain.memory and _every_sample(scene))

    def proposals(self, residual: Residual) -> list[Chain]:
        chain = residual.fit.chain
        if self.present(chain) or not chain.memory or not _every_sample(residual.scene):
            return []
        return [chain.having(RelaxationPart(start)) for start in STARTS]

    def effect(self, residual: Residual) -> Effect | None:
        chain, scene = residual.fit.chain, residual.scene
        if not chain.memory or not _every_sample(scene):
            return None
        relaxed = chain.having(RelaxationPart(RELAXATIONS[0]))
        moved = scene.responses(scene.moved_paths(relaxed, residual.fit.weights), relaxed)
        change = (np.concatenate(moved) - np.concatenate(residual.responses(chain))) / RELAXATIONS[0]
        return Effect("of the half-widths", change, most=RELAXATIONS[1])

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The relaxation divided by its standard error."""
        value = residual.fit.chain.relaxation
        error = value * standard_errors(residual.scene, residual.fit).coordinates["relaxation.half_widths"]
        return Signature(
            z=value / max(error, 1e-15),
            text=f"plays go on by {100 * value:.2g} % +- {100 * error:.1g} % of their half-widths per factor e of time "
            f"while the input rests; the error is {rival.rms_um / residual.fit.rms_um:.2f} times larger without it",
            parameters={"half_widths": Estimate(value, error)},
        )

    def advice(self, seen: Seen) -> Advice:
        percent = 100.0 * seen.values["half_widths"]
        return Advice(
            f"the loop depends on the rate: its half-width grows by {percent:.2g} % for each factor 2.7 of the rate, "
            "and after a stroke the stage creeps on",
            f"calibrate at the rate of use: ten times slower is another loop by {2.3 * percent:.2g} %; or follow the "
            "inverse of this model, or close a loop around the sensor",
        )

    def motion(self, values: Mapping[str, float], Ts_s: float) -> Motion:
        return voltage_step(1.0, Ts_s)

    def unaffected(self, blocks: Sequence[InputBlock]) -> tuple[InputBlock, ...]:
        """Plays that stand while the voltage rests."""
        return tuple(
            dataclasses.replace(block, relaxation=0.0) if isinstance(block, Hysteresis) else block for block in blocks
        )

    def forms(self, extension: Extension) -> list[Extension]:
        """The size of the hysteresis that memory has, or densities fine enough for many hysterons."""
        return [extension, *(dataclasses.replace(extension, size=size) for size in RELAXING_SIZES)]

    def extension(self, residual: Residual) -> Extension:
        chain = residual.fit.chain
        return Extension(relaxation=chain.relaxation, lag_s=chain.lag_s)


def _every_sample(scene: Scene) -> bool:
    """Whether all runs of the scene hold every sample from the start of their segment on."""
    return all(run.stride == 1 and not len(run.history) for run in scene.runs)
