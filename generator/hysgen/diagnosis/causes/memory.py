"""Memory: the output depends on past extremes of the input, so the loop stays open however slowly it is run."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binom

from hysgen.diagnosis.causes.base import Cause, Estimate, Known, Residual, Signature
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Fit
from hysgen.machine.kernels import play_operators
from hysgen.model.terms.memory import Memory
from hysgen.record.series import turning_rows

Floats = NDArray[np.float64]

PLAYS, DEGREE = 6, 3
"""Plays while causes are weighed, each with its square and cube. These fits are unrestricted, and the past input makes
some of them fail; `extension_forms` chooses the form that the model gets."""

USUAL_PLAYS, USUAL_DEGREE = 10, 3
"""Plays of the usual form, beside the past input: on Preisach stages half the error of 6."""

OTHERS = ((6, 3, True), (6, 3, False), (12, 1, False))
"""Plays, degree, and whether the past input is among them.

Without the past input where the output is a sample late: there it takes the place of the input.
"""

FEWEST = 4
"""Samples that a swing needs to be counted."""
CHANCE = 1e-3
WITNESS = 0.25
"""Half-width, in half ranges of the input, of the play that measures the opening of the loop."""


class MemoryCause(Cause):
    name = "memory"
    rank = 40

    def present(self, chain: Chain) -> bool:
        return chain.memory

    def without(self, chain: Chain) -> Chain:
        return dataclasses.replace(chain, memory=False)

    def proposals(self, residual: Residual) -> list[Chain]:
        chain = residual.fit.chain
        return [] if chain.memory else [dataclasses.replace(chain, memory=True)]

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """On how many swings between turning points past extremes explain the output better than its dynamics do.

        A sign test: without memory each swing would be a coin's toss.
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
        loop_um = _opening(residual, rival)
        return Signature(
            holds=tosses > 0 and float(binom.sf(wins - 1, tosses, 0.5)) < CHANCE,
            z=float(z),
            text=f"past extremes explain {wins} of {tosses} swings better than dynamics do; "
            f"at the same input the way up and the way down differ by {1e3 * loop_um:.3g} nm",
            parameters={"loop_um": Estimate(loop_um, loop_um / max(float(z), 1.0))},
        )

    def usual_form(self, extension: Extension) -> Extension:
        range_V = _range_V(extension)
        return extension if range_V is None else dataclasses.replace(extension, term=usual_memory(*range_V))

    def other_forms(self, extension: Extension) -> list[Extension]:
        """Fewer plays, plays without powers, and plays without the past input: all cost fewer cycles."""
        range_V = _range_V(extension)
        if range_V is None:
            return []
        low_V, high_V = range_V
        terms = [Memory.polynomial(plays, degree, low_V, high_V, past) for plays, degree, past in OTHERS]
        return [dataclasses.replace(extension, term=term) for term in terms]

    def true_extension(self, known: Known) -> Extension:
        return Extension(term=usual_memory(known.low_V, known.high_V))

    def extension(self, residual: Residual) -> Extension:
        scene, chain = residual.scene, residual.fit.chain
        low_V, high_V = chain.passes_V(scene.operator.low_V, scene.operator.high_V)
        return Extension(term=Memory.polynomial(PLAYS, DEGREE, low_V, high_V))


def usual_memory(low_V: float, high_V: float) -> Memory:
    """The usual form of the term for an input between low_V and high_V."""
    return Memory.polynomial(USUAL_PLAYS, USUAL_DEGREE, low_V, high_V, past_input=True)


def _range_V(extension: Extension) -> tuple[float, float] | None:
    """The input's range that the memory term counts with; None for plays alone."""
    return extension.term.range_V if isinstance(extension.term, Memory) else None


def swings(u_V: Floats) -> NDArray[np.int64]:
    """(n,) number of the swing of each sample; a plateau belongs to the swing before it, at the start to its own."""
    moves = np.flatnonzero(np.diff(u_V))
    return np.searchsorted(np.append(moves[:1], turning_rows(u_V, 0.0)), np.arange(len(u_V))).astype(np.int64)


def _opening(residual: Residual, rival: Fit) -> float:
    """Mean height in um of the loop that a model without memory leaves open, from the slack z(u) - u of a play."""
    scene = residual.scene
    half = 0.5 * (scene.operator.high_V - scene.operator.low_V)
    slack = np.concatenate(
        [play_operators(run.u_V, np.array([WITNESS * half]), run.u_V[:1].copy())[:, 0] - run.u_V for run in scene.runs]
    )[scene.rows]
    error = rival.error[scene.rows]
    slack = slack - slack.mean()
    return 2.0 * WITNESS * half * abs(float(slack @ error)) / (float(slack @ slack) + 1e-300)


CAUSE = MemoryCause()
