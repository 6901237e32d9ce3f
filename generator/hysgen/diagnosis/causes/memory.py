"""Memory: the output depends on past extremes of the input, so the loop stays open at any frequency."""

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
"""Plays of the term while causes are tested, each with its square and cube. The term excludes the past input, because
some fits without a loop-gain limit fail with it; `extension_forms` chooses the form of the delivered model."""

USUAL_PLAYS, USUAL_DEGREE = 10, 3
"""Plays of the usual form, which includes the past input; on Preisach stages its error is half of that of 6 plays."""

OTHERS = ((6, 3, True), (6, 3, False), (12, 1, False))
"""Other forms: plays, degree, and whether the past input is a regressor.

One form excludes the past input for a stage that is one sample late, in which the past input replaces the input.
"""

FEWEST = 4
"""Least number of samples of a counted swing."""
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
    """Input range of the memory term; None for a term of plays alone."""
    return extension.term.range_V if isinstance(extension.term, Memory) else None


def swings(u_V: Floats) -> NDArray[np.int64]:
    """(n,) number of the swing of each sample; a plateau belongs to the swing before it, or is the first swing."""
    moves = np.flatnonzero(np.diff(u_V))
    return np.searchsorted(np.append(moves[:1], turning_rows(u_V, 0.0)), np.arange(len(u_V))).astype(np.int64)


def _opening(residual: Residual, rival: Fit) -> float:
    """Mean height in um of the loop in the residual of a model without memory, by regression on z(u) - u of a play."""
    scene = residual.scene
    half = 0.5 * (scene.operator.high_V - scene.operator.low_V)
    slack = np.concatenate(
        [play_operators(run.u_V, np.array([WITNESS * half]), run.u_V[:1].copy())[:, 0] - run.u_V for run in scene.runs]
    )[scene.rows]
    error = rival.error[scene.rows]
    slack = slack - slack.mean()
    return 2.0 * WITNESS * half * abs(float(slack @ error)) / (float(slack @ slack) + 1e-300)


CAUSE = MemoryCause()
