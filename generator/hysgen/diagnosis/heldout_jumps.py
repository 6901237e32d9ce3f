"""Sudden changes in the held-out rows: they show in no fit to the identification part, and spoil every score.

The chain of the search is fitted to all rows, with and without one sudden change more. The change is told if it lies
behind the identification part, takes place at once, and lowers the score by LEAST_EVIDENCE, as in the search. Nothing
is chosen by it: neither causes nor models depend on the held-out rows.
"""

from __future__ import annotations

import dataclasses

from hysgen.diagnosis.causes import Residual
from hysgen.diagnosis.causes.unknown import CAUSE, SuddenPart
from hysgen.diagnosis.excerpt import excerpt
from hysgen.diagnosis.prepare import Prepared
from hysgen.diagnosis.probe import Chain, linear_fit, refine, rms
from hysgen.diagnosis.score import LEAST_EVIDENCE, Scored
from hysgen.diagnosis.search import corrupted_samples, thinned
from hysgen.machine.checkpoint import Steps

LEAST_EXCESS = 2.0
"""Error on the held-out rows over that on the identification part from which on a change is looked for there: less
spoils no score."""


def change_in_held_rows(prepared: Prepared, chain: Chain, kept: Steps | None = None) -> str:
    """The sudden change in the held-out rows that lowers the score of a chain most, in words; "" if none is evident.

    "", too, if the held-out rows are another segment than the identification part, which has a zero of its own.
    kept: fits of an interrupted diagnosis (`Scene`).
    """
    if len(prepared.record.segments) > 1 or not len(prepared.held_rows):
        return ""
    scene = excerpt(prepared.scene(whole=True), prepared.lag)
    cut_s = prepared.cut * prepared.record.Ts_s
    held = scene.time_s[scene.rows] >= cut_s
    known = linear_fit(thinned(scene.using(scene.rows[~held])), chain)
    clean = ~corrupted_samples(scene, known)[scene.rows]
    if rms(known.error[scene.rows[held & clean]]) < LEAST_EXCESS * rms(known.error[scene.rows[~held & clean]]):
        return ""
    scene = dataclasses.replace(thinned(scene.using(scene.rows[clean])), kept=kept)
    without = Scored.of(scene, refine(scene, chain))
    before = chain.get(SuddenPart) or SuddenPart()
    starts = [
        start
        for start in CAUSE.proposals(Residual(scene, without.fit))
        if all(at_s >= cut_s for at_s in start.of(SuddenPart).times_s if at_s not in before.times_s)
    ]
    changed = [Scored.of(scene, refine(scene, start)) for start in starts]
    evident = [one for one in changed if one.fall_from(without) > LEAST_EVIDENCE and CAUSE.admissible(scene, one.fit)]
    if not evident:
        return ""
    best = max(evident, key=lambda one: one.fall_from(without)).fit.chain.of(SuddenPart)
    jumps = [f"jumps at {at_s:.4g} s" for at_s in best.jumps_s if at_s >= cut_s]
    gains = [f"changes its gain by {change:+.2%} at {at_s:.4g} s" for at_s, change in best.gains if at_s >= cut_s]
    return f"in the held-out rows the displacement {', and '.join([*jumps, *gains])}, so they say less of the models"
