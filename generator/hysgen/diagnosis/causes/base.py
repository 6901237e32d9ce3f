"""Interface of a cause: candidate chains for the search, removal from a chain, evidence, and extension of the model.

A cause is named only if two criteria hold: the error of the probe on the checking rows grows without the cause
(`search`), and the physical signature that the file of the cause defines holds.
"""

from __future__ import annotations

import abc
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Fit, Part, Projector, Scene, TrainingFit

Floats = NDArray[np.float64]


SLOW_Z = 4.0
"""Least size of a slow cause in standard errors; the errors are uncertain, because few blocks determine them."""

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
        return Projector.of(self.scene.columns(self.fit.chain)[:, self.scene.rows])

    def amount(self, column: Floats) -> float:
        """Least-squares weight of `column`, (n,), for the residual, fitted jointly with all columns of the chain."""
        rows = self.scene.rows
        orthogonal = self.projector.orthogonal_part(column[rows])
        return float(orthogonal @ self.fit.error[rows] / (orthogonal @ orthogonal + 1e-300))

    def changed_by(self, chain: Chain) -> Floats:
        """(n,) change of the response to the fitted hysteresis if `chain` takes the place of the fitted chain."""
        return np.concatenate(self.responses(chain)) - np.concatenate(self.responses(self.fit.chain))

    def responses(self, chain: Chain) -> list[Floats]:
        """Response of the linear part of `chain` to the fitted hysteresis, (n_i,) for each run."""
        paths = self.scene.paths(self.fit.chain, self.fit.weights)
        return self.scene.responses(paths, chain)


@dataclass(frozen=True)
class Estimate:
    """A physical parameter with its standard error, both in the unit at the end of the parameter's name."""

    value: float
    standard_error: float


@dataclass(frozen=True)
class Signature:
    """Evidence for a cause: whether it holds, its statistic in standard errors or an equivalent, and a sentence."""

    holds: bool
    z: float
    text: str
    parameters: Mapping[str, Estimate] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Known:
    """Data for an extension of a known plant: its parameters by "cause.parameter", and ranges of the record.

    low_V, high_V: range of the voltage across the ceramic. span_s: length of the record. lag_s: of the stage.
    channels: (n,) each.
    """

    parameters: Mapping[str, float]
    low_V: float
    high_V: float
    span_s: float
    lag_s: float
    channels: Mapping[str, Floats]


@dataclass(frozen=True, eq=False)
class Effect:
    """The effect of a cause beside a chain without it, for what a record can tell (`identifiability`).

    column: (n,) change of the prediction per unit of the amount, in um; None if `least` is known without a fit.
    most: amount from which on the effect is not physical.
    """

    unit: str
    column: Floats | None = None
    most: float = math.inf
    least: float = math.nan


class Cause(abc.ABC):
    """One cause of the vocabulary. It has no state: each module has one instance, CAUSE."""

    name: ClassVar[str]

    rank: ClassVar[int]
    """Place on the ladder and in the vocabulary: sensor faults, path of the command, disturbances, slow changes."""

    part: ClassVar[type[Part] | None] = None
    """Class of the cause's part of the chain; None if the cause has no part."""

    kind: ClassVar[str] = ""
    """Kind of the block or term of its extension; by default the name of the cause."""

    slow: ClassVar[bool] = False
    """Whether the cause acts over the length of the record; slow causes can be swapped for each other."""

    mistaken_for: ClassVar[tuple[str, ...]] = ()
    """Similar causes; the search compares this cause with each of them and swaps the two if the error falls."""

    judged_by_gain: ClassVar[bool] = True
    """Whether the extension must lower the error of the model; False if the measured error itself is corrupted."""

    on_all_rows: ClassVar[bool] = False
    """Whether signature and extension are those of all rows of the record, not of the rows of the search."""

    experiment: ClassVar[str] = ""
    """What to record so that the cause shows."""

    needed: ClassVar[float] = 1.2
    """Least growth of the probe's error above the noise on the checking rows without the cause, as a ratio."""

    starts: ClassVar[int] = 1
    """Number of proposals that one step of the search refines, the best ones first; see `select_starts`."""

    def present(self, chain: Chain) -> bool:
        """Whether the chain contains the part of this cause."""
        return self.part is not None and chain.get(self.part) is not None

    def shown(self, residual: Residual) -> bool:
        """Whether the final fit contains the cause; only then the signature is computed."""
        return self.present(residual.fit.chain)

    def needed_in(self, chain: Chain) -> float:
        """Least growth of the error (`needed`) for the form of the cause in this chain."""
        return self.needed

    def without(self, chain: Chain) -> Chain:
        """The chain without the part of this cause."""
        return chain if self.part is None else chain.without(self.part)

    def without_one_part(self, chain: Chain) -> list[Chain]:
        """Chains without one mode, line or channel of this cause; by default one chain without the whole cause."""
        return [self.without(chain)]

    def simpler_forms(self, chain: Chain) -> list[Chain]:
        """Chains with a simpler form of this cause, which is preferred if the error does not grow."""
        return []

    def admissible(self, scene: Scene, chain: Chain) -> bool:
        """Whether the parameters of this cause are in the range that its signature requires; called in every step."""
        return True

    def supported(self, residual: Residual) -> Chain:
        """The chain without those of several modes, lines or channels of this cause that have no evidence."""
        return residual.fit.chain

    def restarts(self, scene: Scene, chain: Chain) -> list[Chain]:
        """The same chain with other starting values of this cause, if the fit is known to have several minima."""
        return []

    def proposals(self, residual: Residual) -> list[Chain]:
        """Candidate chains with this cause, or one more part of it, at starting values; empty if none is possible."""
        return []

    def select_starts(self, candidates: list[TrainingFit]) -> list[TrainingFit]:
        """The linear fits that are refined. candidates: linear fits of the proposals, sorted by rms error."""
        return candidates[: self.starts]

    def effect(self, residual: Residual) -> Effect | None:
        """The effect of the cause per unit of its amount beside a chain without it; None if it is not excited."""
        return None

    @abc.abstractmethod
    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """Evidence for the cause. residual: of the final fit; rival: the best fit without the cause."""

    @abc.abstractmethod
    def extension(self, residual: Residual) -> Extension:
        """The extension of the model, with the shape parameters of the final fit."""

    def forms(self, extension: Extension) -> list[Extension]:
        """Forms of the extension in rising cost, compared by cross-validation (`extension_forms`)."""
        return [extension]

    def true_extension(self, known: Known) -> Extension | None:
        """The extension with the true parameters of the plant; None if it changes the record and not the model."""
        return None
