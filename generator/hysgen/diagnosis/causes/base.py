"""The contract of a cause: how it is proposed to the probe, how it is taken out again, and what it must show itself.

A cause is named only if two things agree: the held-out gain that its part of the chain brings, which `search` measures
for all causes alike, and a physical signature of its own, which only the cause's module knows.
"""

from __future__ import annotations

import abc
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Fit, Part, Projector, Scene
from hysgen.diagnosis.probe.dynamics import respond

Floats = NDArray[np.float64]


SLOW_Z = 4.0
"""Least size of a slow cause in standard errors: few blocks of the record determine it."""

ZERO_UNCERTAIN = 0.25
"""Uncertainty of the stage's zero as a share of the span: a gain that changes about another zero adds a ramp."""


@dataclass(frozen=True, eq=False)
class Residual:
    """A fitted chain with its error on a scene. corrupted: samples of the scene that stand alone, (n,), or (0,)."""

    scene: Scene
    fit: Fit
    corrupted: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))

    @cached_property
    def projector(self) -> Projector:
        """The projector off the columns of the fitted chain, on the fitted rows."""
        return Projector.of(self.scene.columns(self.fit.chain)[:, self.scene.rows])

    def amount(self, column: Floats) -> float:
        """How much of `column`, (n,), explains the error best, all that is linear being free beside it."""
        rows = self.scene.rows
        alone = self.projector.rest(column[rows])
        return float(alone @ self.fit.error[rows] / (alone @ alone + 1e-300))

    def responses(self, chain: Chain) -> list[Floats]:
        """What the linear part of `chain` makes of the hysteresis that the fit found, run by run, (n_i,) each."""
        paths = self.scene.paths(self.fit.chain, self.fit.weights)
        return [respond(path, chain, self.scene.Ts_s) for path in paths]


@dataclass(frozen=True)
class Estimate:
    """A physical parameter with its standard error, in the unit that its name ends with."""

    value: float
    standard_error: float


@dataclass(frozen=True)
class Signature:
    """What a cause shows of itself: a statistic in standard errors or their equivalent, whether it holds, in words."""

    holds: bool
    z: float
    text: str
    parameters: Mapping[str, Estimate] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Known:
    """What an extension is made from when the plant is known: its parameters by "cause.parameter", and the record.

    low_V, high_V: range of the voltage across the ceramic. span_s: length of the record. channels: (n,) each.
    """

    parameters: Mapping[str, float]
    low_V: float
    high_V: float
    span_s: float
    channels: Mapping[str, Floats]


class Cause(abc.ABC):
    """One cause of the vocabulary. Stateless: one instance per module, called CAUSE."""

    name: ClassVar[str]

    rank: ClassVar[int]
    """Place on the ladder and in the vocabulary: sensor's faults, path of the command, disturbances, slow changes."""

    part: ClassVar[type[Part] | None] = None
    """Its part of the chain, None if it has none."""

    slow: ClassVar[bool] = False
    """Whether it acts over the length of the record, so that it can take the place of another slow cause."""

    mistaken_for: ClassVar[tuple[str, ...]] = ()
    """Other causes that the search may add in place of this one, and this one in place of them."""

    judged_by_gain: ClassVar[bool] = True
    """Whether the extension must lower the error of the model; not where the error itself is in doubt."""

    fitted_late: ClassVar[bool] = False
    """Whether its extension is left out while the forms of others are chosen: it takes the gain that they leave."""

    needed: ClassVar[float] = 1.2
    """By how much the probe's error on unfitted blocks must grow without the cause for it to be named."""

    starts: ClassVar[int] = 1
    """How many of its proposals are refined in a step, the best first; `select_starts` may choose otherwise."""

    def present(self, chain: Chain) -> bool:
        """Whether the chain holds this cause's part."""
        return self.part is not None and chain.get(self.part) is not None

    def shown(self, residual: Residual) -> bool:
        """Whether the final fit shows the cause, so that its signature is computed."""
        return self.present(residual.fit.chain)

    def needed_in(self, chain: Chain) -> float:
        """`needed`, for the form that the cause has in this chain."""
        return self.needed

    def without(self, chain: Chain) -> Chain:
        """The chain with this cause's part taken out."""
        return chain if self.part is None else chain.without(self.part)

    def without_one_part(self, chain: Chain) -> list[Chain]:
        """Chains with one part of this cause taken out: one mode, line or channel of several, or all there is."""
        return [self.without(chain)]

    def simpler_forms(self, chain: Chain) -> list[Chain]:
        """Chains in which this cause stands in a simpler form, which is preferred unless it explains less."""
        return []

    def admissible(self, scene: Scene, chain: Chain) -> bool:
        """Whether this cause's numbers in the chain let its signature hold; cheap, asked at every step."""
        return True

    def supported(self, residual: Residual) -> Chain:
        """The chain without those parts of this cause, of several, that show no evidence of their own."""
        return residual.fit.chain

    def restarts(self, scene: Scene, chain: Chain) -> list[Chain]:
        """The same chain with this cause's numbers elsewhere, where the fit is known to have several minima."""
        return []

    def proposals(self, residual: Residual) -> list[Chain]:
        """Chains that hold this cause (or one part more of it), rough values, worth a refinement; empty if hopeless."""
        return []

    def select_starts(self, candidates: list[Fit]) -> list[Fit]:
        """Those of its proposals, as they stand and the best first, that are worth a refinement."""
        return candidates[: self.starts]

    @abc.abstractmethod
    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """Evidence in the record. residual: of the final fit; rival: the best fit without the cause."""

    @abc.abstractmethod
    def extension(self, residual: Residual) -> Extension:
        """The extension of the model, with the shape parameters of the final fit."""

    def usual_form(self, extension: Extension) -> Extension:
        """The extension in the form that is kept unless another form is better for certain."""
        return extension

    def other_forms(self, extension: Extension) -> list[Extension]:
        """Other forms of the extension, of which the best is chosen inside the identification part."""
        return []

    def true_extension(self, known: Known) -> Extension | None:
        """The extension with the plant's own parameters; None if it treats the record instead of the model."""
        return None
