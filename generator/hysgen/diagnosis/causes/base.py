"""Interface of a cause: candidate chains for the search, removal from a chain, evidence, and extension of the model.

A cause is named if the chain with the least score contains it (`search`). The file of the cause states the physical
bounds of its parameters, under which conditions it acts on a record, and the evidence that is reported.
"""

import abc
import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Fit, Part, Projector, Scene, TrainingFit, projector_off
from hysgen.diagnosis.remedy import Advice, Motion, Seen, Sketch
from hysgen.model.disturbances import Term
from hysgen.model.model import Model
from hysgen.model.path import InputBlock

Floats = NDArray[np.float64]


LEVELS = 20
"""Levels of the command that count as apart: within a twentieth of the range a curve is a straight line."""

FEWEST_LIMITED, LEAST_CHANGE = 10, 1e-3
"""Least number of fitted rows on which a limit acts, by at least this share of the range: fewer show no level."""

ZERO_UNCERTAIN = 0.25
"""Uncertainty of the displacement at 0 V as a share of the span; with a wrong zero, aging also shows as a ramp."""


@dataclass(frozen=True, eq=False)
class Residual:
    """A fitted chain with its residual on a scene. corrupted: (n,) flags of the corrupted samples, or (0,) for none."""

    scene: Scene
    fit: Fit
    corrupted: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))

    @cached_property
    def projector(self) -> Projector:
        """The projector off the columns of the fitted chain, on the fitted rows."""
        chain = self.fit.chain
        return projector_off(self.scene, chain, self.scene.columns(chain)[:, self.scene.rows])

    def amount(self, column: Floats) -> float:
        """Least-squares weight of `column`, (n,), for the residual, fitted jointly with all columns of the chain."""
        rows = self.scene.rows
        orthogonal = self.projector.orthogonal_part(column[rows])
        return float(orthogonal @ self.fit.error[rows] / (orthogonal @ orthogonal + 1e-300))

    def changed_by(self, chain: Chain) -> Floats:
        """(n,) change of the response to the fitted hysteresis if `chain` takes the place of the fitted chain."""
        return np.concatenate(self.responses(chain)) - np.concatenate(self.responses(self.fit.chain))

    def predicted(self, chain: Chain) -> Floats:
        """(n,) prediction of `chain` with the weights of the fitted one, added columns included."""
        return self.scene.seen(self._paths, chain, self.fit.weights)

    def about_zero_um(self) -> Floats:
        """(n,) response of the fitted chain about its displacement at 0 V, which a change of the gain multiplies."""
        chain, weights = self.fit.chain, self.fit.weights
        zero_um = self.scene.zero_um(chain, weights) - float(weights[self.scene.hysteresis_size(chain)])
        return np.concatenate(self.responses(chain)) - zero_um

    def responses(self, chain: Chain) -> list[Floats]:
        """Response of the linear part of `chain` to the fitted hysteresis, (n_i,) for each run."""
        return self.scene.responses(self._paths, chain)

    @cached_property
    def _paths(self) -> list[Floats]:
        """The fitted hysteresis of every run (`Scene.paths`)."""
        return self.scene.paths(self.fit.chain, self.fit.weights)


@dataclass(frozen=True)
class Estimate:
    """A physical parameter with its standard error, both in the unit at the end of the parameter's name."""

    value: float
    standard_error: float


@dataclass(frozen=True)
class Signature:
    """Evidence for a named cause: its statistic in standard errors or an equivalent, a sentence, its parameters."""

    z: float
    text: str
    parameters: Mapping[str, Estimate] = field(default_factory=dict)

    @property
    def most_confidence(self) -> float:
        """The probability that its own standard error leaves at most, 1 without an amount: p / (1 - p) = exp(z^2 / 2).

        The likelihood ratio of a Gaussian amount, z standard errors from 0, against nothing.
        """
        return 1.0 / (1.0 + math.exp(-0.5 * self.z**2)) if self.parameters else 1.0


@dataclass(frozen=True, eq=False)
class Effect:
    """The effect of a cause beside a chain without it, for what a record can tell (`identifiability`).

    column: (n,) change of the prediction per unit of the amount, in um; None if `least` is known without a fit.
    most: amount from which on the effect is not physical. limit: the cause is a limit, whose effect grows as the amount
    falls; `least` is then the largest limit that acts.
    """

    unit: str
    column: Floats | None = None
    most: float = math.inf
    least: float = math.nan
    limit: bool = False


def limited_rows(scene: Scene, chain: Chain, kind: type[Part]) -> int:
    """Number of rows, thinned or not, at which a part changes the voltage by more than LEAST_CHANGE of its range."""
    least_V = LEAST_CHANGE * (scene.operator.high_V - scene.operator.low_V)
    free = chain.without(kind.cause)
    changes = [np.abs(chain.amplified(*run) - free.amplified(*run)) for run in scene.commands]
    return int(np.count_nonzero(np.concatenate(changes)[scene.dense] > least_V))


def turns(scene: Scene) -> bool:
    """Whether the command of any run ever turns: on one way no voltage is passed twice."""
    moves = (np.diff(run.u_V, prepend=run.history.u_V) for run in scene.runs)
    return any(bool((move_V < 0.0).any() and (move_V > 0.0).any()) for move_V in moves)


def comes_back(scene: Scene) -> bool:
    """Whether most rows lie on levels, a LEVELS-th of the range each, that the command has left and come back to."""
    low_V, high_V = scene.operator.low_V, scene.operator.high_V
    levels = [np.floor(LEVELS * (run.u_V - low_V) / (high_V - low_V)).astype(np.intp) for run in scene.runs]
    visits = np.bincount(np.concatenate([level[np.diff(level, prepend=-1) != 0] for level in levels]))
    return bool(np.mean(visits[np.concatenate(levels)[scene.rows]] > 1) > 0.5)


class Cause(abc.ABC):
    """One cause of the vocabulary. It has no state: the registry has one instance."""

    name: ClassVar[str]

    rank: ClassVar[int]
    """Place on the ladder and in the vocabulary: sensor faults, path of the command, disturbances, slow changes."""

    part: ClassVar[type[Part] | None] = None
    """Class of the cause's part of the chain; None if the cause has no part."""

    kind: ClassVar[str] = ""
    """Kind of the block or term of its extension; by default the name of the cause."""

    slow: ClassVar[bool] = False
    """Whether the cause acts over the length of the record; slow causes can be exchanged for each other."""

    mistaken_for: ClassVar[tuple[str, ...]] = ()
    """Similar causes, for which the search exchanges this cause if the score falls."""

    judged_by_gain: ClassVar[bool] = True
    """Whether the gain of the extension is measured; False if the measured error itself is corrupted."""

    prior_odds: ClassVar[float] = 0.1
    """Odds of the cause before the record: of the ten causes with an extension, a stage has one on average beside
    memory."""

    held_by: ClassVar[str] = ""
    """A cause whose part holds this one: a stage that has that one has no name for this."""

    changes: ClassVar[str] = ""
    """A cause whose part this one changes: it is judged beside that part alone."""

    extends: ClassVar[bool] = True
    """Whether a model can be extended by the cause; False for changes that no model predicts."""

    on_all_rows: ClassVar[bool] = False
    """Whether signature and extension are those of all rows of the record, not of the rows of the search."""

    experiment: ClassVar[str] = ""
    """What to record so that the cause shows."""

    starts: ClassVar[int] = 1
    """Number of proposals that one step of the search refines, the best ones first; see `select_starts`."""

    def present(self, chain: Chain) -> bool:
        """Whether the chain contains the part of this cause."""
        return any(part.cause == self.name for part in chain.parts)

    def shown(self, residual: Residual) -> bool:
        """Whether the cause is named: whether the final chain contains it."""
        return self.present(residual.fit.chain)

    def without(self, chain: Chain) -> Chain:
        """The chain without the part of this cause."""
        return chain.without(self.name)

    def without_one_part(self, chain: Chain) -> list[Chain]:
        """Chains without one mode, line or channel of this cause; by default one chain without the whole cause."""
        return [self.without(chain)]

    def simpler_forms(self, chain: Chain) -> list[Chain]:
        """Chains with a simpler form of this cause, to replace it if the score rises by less than LEAST_EVIDENCE."""
        return []

    def fuller_forms(self, chain: Chain, scene: Scene) -> list[Chain]:
        """Chains with a form of this cause, at starting values, that may hold what a similar cause took."""
        return []

    def admissible(self, scene: Scene, fit: Fit) -> bool:
        """Whether the cause acts on the fitted rows as its definition says, beside the bounds of its parameters.

        The causes with more specific conditions state them. A chain that is not admissible has no score.
        """
        return True

    def evidence(self, scene: Scene, fit: Fit) -> float:
        """2 ln of a likelihood ratio for the cause, of what the record shows beside the size of the residual."""
        return 0.0

    def proposals(self, residual: Residual) -> list[Chain]:
        """Candidate chains with this cause, or one more part of it, at starting values; empty if none is possible."""
        return []

    def select_starts(self, candidates: list[TrainingFit]) -> list[TrainingFit]:
        """The linear fits that are refined. candidates: linear fits of the proposals, sorted by rms error."""
        return candidates[: self.starts]

    @abc.abstractmethod
    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """Evidence for the named cause. residual: of the final fit; rival: the fit without the cause."""

    def seen_in(self, signature: Signature, model: Model, residual: Residual) -> Signature:
        """The signature with what the model that is extended by the cause shows of it; by default as it is.

        residual: of the search, for the error of what is shown.
        """
        return signature

    def extension(self, residual: Residual) -> Extension:
        """The extension of the model, with the shape parameters of the final fit; by default the part of the chain."""
        chain = residual.fit.chain
        part = next(part for part in chain.parts if part.cause == self.name)
        if isinstance(part, Term):
            return Extension(term=part)
        assert isinstance(part, InputBlock)
        return Extension(block=part, lag_s=chain.lag_s)

    def forms(self, extension: Extension) -> list[Extension]:
        """Forms of the extension in rising cost, compared by cross-validation (`ladder`)."""
        return [extension]

    def effect(self, residual: Residual) -> Effect | None:
        """The effect of the cause per unit of its amount beside a chain without it; None if it is not excited."""
        return None

    def advice(self, seen: Seen) -> Advice | None:
        """What the cause means, and what to change in the stage; None if nothing is known."""
        return None

    def motion(self, values: Mapping[str, float], Ts_s: float) -> Motion | None:
        """The motion that shows the cause with these parameters; None if none does."""
        return None

    def motions_um(self, motion: Motion, seen: Seen) -> tuple[Floats, Floats] | None:
        """The displacement, (n,), with the cause and without it; None if the model does not have the cause.

        By default that of the model, and of the model without the part of the cause. Other terms, and blocks that read
        channels, are left out.
        """
        model, kind = seen.model, self.kind or self.name
        u_V = model.u_min_V + motion.levels * (model.u_max_V - model.u_min_V)
        sizes = np.cumsum([0, *(term.size for term in model.terms)])
        own = [i for i, term in enumerate(model.terms) if term.kind == kind]
        terms, weights = tuple(model.terms[i] for i in own), [model.weights[sizes[i] : sizes[i + 1]] for i in own]
        still = tuple(block for block in model.blocks if not block.channels)
        acting = dataclasses.replace(model, terms=terms, weights=np.concatenate([np.zeros(0), *weights]), blocks=still)
        free = dataclasses.replace(model, terms=(), weights=np.zeros(0), blocks=self.unaffected(still))
        return None if acting == free else (acting.simulate(u_V), free.simulate(u_V))

    def unaffected(self, blocks: Sequence[InputBlock]) -> tuple[InputBlock, ...]:
        """The blocks of a model without the cause; by default without those of its kind."""
        return tuple(block for block in blocks if block.kind != (self.kind or self.name))

    def sketch(self, seen: Seen) -> Sketch | None:
        """Two small pictures, with the cause and without it; None if there are none."""
        motion = self.motion(seen.values, seen.model.Ts_s)
        both = None if motion is None else self.motions_um(motion, seen)
        return None if motion is None or both is None else Sketch.of(motion, *both)
