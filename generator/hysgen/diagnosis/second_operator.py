"""The evidence by a second hysteresis operator, of more weights and other decay lengths.

    fall = (fall by the operator of the search + fall by the second operator) / 2

What an operator misses depends on its form: a misfit that resembles a cause by chance does so for one operator, the
effect of a cause for each. The search has chosen the cause among all others by the first operator; the second one took
no part in that choice. Which of them describes the stage better is not known, so the mean of both logarithms of the
odds counts (logarithmic pool; Genest and Zidek, 1986).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from functools import cached_property

from hysgen.diagnosis.probe import Chain, Scene, refine
from hysgen.diagnosis.score import Scored
from hysgen.diagnosis.slow_evidence import Whitenings

ROUNDS = 8
"""Gauss-Newton rounds of a fit, from a chain that is refined with the first operator already."""


@dataclass(frozen=True, eq=False)
class SecondOperator:
    """The scene with the second operator, and the fits of chains to it; each is made once."""

    first: Scene
    _scored: dict[Chain, Scored] = field(default_factory=dict)

    @cached_property
    def scene(self) -> Scene:
        """Twice the hat functions, polynomials of more degrees, decay lengths between those of the first operator."""
        own = self.first.operator
        last = own.reaches[-1:]
        reaches = (*(0.5**0.5 * reach for reach in own.reaches), *(2.0**0.5 * reach for reach in last))
        finer = dataclasses.replace(own, hats=2 * own.hats, degree=own.degree + 2, curve=own.curve + 4, reaches=reaches)
        return dataclasses.replace(self.first.bare(), operator=finer)

    @cached_property
    def whitenings(self) -> Whitenings:
        return Whitenings(self.scene)

    def scored(self, chain: Chain) -> Scored:
        """The chain, fitted with this operator."""
        if chain not in self._scored:
            self._scored[chain] = Scored.of(self.scene, refine(self.scene, chain, ROUNDS))
        return self._scored[chain]
