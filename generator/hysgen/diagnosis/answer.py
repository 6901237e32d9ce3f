"""The result of a diagnosis: named causes with parameters, evidence and gain, and the unexplained part of the error.

What is left: the model's own figure on the held-out rows, that of the probe on the same rows, and why they differ.

The chain of the search has its linear weights fitted to the identification part and is simulated over the whole record;
what no model can know is taken out of both errors (`hysgen.model.remaining`), the same jumps and wrong readings.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes import Estimate
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.identifiability import Ability
from hysgen.diagnosis.ladder import Gain, left_by
from hysgen.diagnosis.prepare import Prepared
from hysgen.diagnosis.probe import Chain, single_fit
from hysgen.diagnosis.search import thinned
from hysgen.model.model import Model
from hysgen.model.remaining import Remaining, Taken
from hysgen.record.noise import NoiseFloor
from hysgen.record.series import COVERED

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]


@dataclass(frozen=True)
class Price:
    """Cycles per sample on the DSP and bytes that an extension adds to the model."""

    cycles: int
    bytes: int

    @classmethod
    def between(cls, before: Price | None, after: Price | None) -> Price | None:
        """Price of one rung; None if no C can be generated for one of the two models."""
        if before is None or after is None:
            return None
        return cls(after.cycles - before.cycles, after.bytes - before.bytes)


@dataclass(frozen=True)
class NamedCause:
    """A cause of the probe's chain with the least score.

    evidence: in words. statistic: strength of the evidence in standard errors or their equivalent (`Signature.z`).
    step: held-out rms on the ladder before and after its extension, in the model's own figure; cold_um: the cold one.
    alone: gain of its extension beside all others, on cross-validation blocks; None for corrupted samples, on which the
    error has no meaning.
    confidence: posterior probability of the cause over the chains that the search scored. bayes: rise of the score
    without the cause, 2 ln of the Bayes factor. probe_gain: ratio of the probe's rms beyond the white noise without and
    with the cause. All three are None for corrupted samples, which are no part of the probe's chain.
    share: part of the base error's power above the noise floor that its extension removes, split jointly
    (`joint_shares`); 0 if no power is above it.
    extended: whether its extension is in the model; one that gains too little on rows left out of the fit is not.
    """

    name: str
    parameters: Mapping[str, Estimate]
    evidence: str
    statistic: float
    step: Gain
    alone: Gain | None
    confidence: float | None
    bayes: float | None
    probe_gain: float | None
    share: float
    cold_um: tuple[float, float]
    price: Price | None = None
    extended: bool = True

    @property
    def why_not_extended(self) -> str:
        """The reason why its extension is not in the model, "" if it is."""
        if self.extended:
            return ""
        return f"{self.name} is named and not extended: its extension gains less than 2 % on rows left out of the fit"

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values (docs/diagnosis.md); null where a quantity does not exist or is not finite.

        For corrupted samples `confidence`, `gain.alone` and `probe_gain` are null.
        """
        alone = self.alone
        return {
            "name": self.name,
            "parameters": {key: estimate.value for key, estimate in self.parameters.items()},
            "standard_errors": {key: _finite(estimate.standard_error) for key, estimate in self.parameters.items()},
            "evidence": self.evidence,
            "statistic": _finite(self.statistic),
            "confidence": self.confidence,
            "gain": {
                "free_run_rms_before": self.step.before_um,
                "free_run_rms_after": self.step.after_um,
                "ci95": [self.step.low_um, self.step.high_um],
                "cold_before": self.cold_um[0],
                "cold_after": self.cold_um[1],
                "alone": None if alone is None else {"fall_um": alone.fall_um, "ci95": [alone.low_um, alone.high_um]},
            },
            "share": self.share,
            "extended": self.extended,
            "held_out_beside_others": None,
            "probe_gain": self.probe_gain,
            "log_bayes_factor": None if self.bayes is None else 0.5 * self.bayes,
            "separated_by_likelihood": self.bayes is not None,
            "cost": None if self.price is None else {"cycles": self.price.cycles, "bytes": self.price.bytes},
        }


@dataclass(frozen=True)
class Refused:
    """A candidate cause that is not named, and the reason."""

    name: str
    why: str


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The result of `diagnose`.

    causes: in the order of the ladder. unknown: unexplained structure in the probe's residual in words, or None.
    base, model: the paper's model and the extended one. errors_um: name and free-run error, (n,), of each rung.
    base_rms_um, extended_rms_um: free-run rms of the first and of the last rung on the held-out rows `held_rows`, cold.
    base_own_um: the own figure of the first rung; remaining: that of the last, and why it is no smaller.
    persistence_um: rms of the one-step error of y(k+1) = y(k), held out. probe_rms_um: of the probe on its fitted rows.
    unexplained_fraction: part of the base error's power above the noise floor that remains; 0 if no power is above it.
    abilities: for every cause, whether this record could show it, from which size on, and what hides it.
    next_experiment: excitation that distinguishes causes which this record cannot distinguish; may be empty.
    """

    causes: tuple[NamedCause, ...]
    refused: tuple[Refused, ...]
    unknown: str | None
    base: Model
    model: Model
    base_rms_um: float
    extended_rms_um: float
    base_own_um: float
    remaining: Left
    noise: NoiseFloor
    persistence_um: float
    unexplained_fraction: float
    abilities: tuple[Ability, ...]
    next_experiment: str
    errors_um: tuple[tuple[str, Floats], ...] = field(repr=False)
    held_rows: NDArray[np.intp] = field(repr=False)
    probe_rms_um: float = math.nan

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the causes in the order of the ladder, `unknown` last if structure is left."""
        return (*(cause.name for cause in self.causes), *(("unknown",) if self.unknown else ()))

    @property
    def missing_certificates(self) -> tuple[str, ...]:
        """Certificates among gain, contraction and inverse that the extended model lacks.

        The fit enforces all three; it returns a model without them only if no certified model fits the record.
        """
        known = self.model.certificates
        return tuple(name for name in ("gain", "contraction", "inverse") if name in known and not known[name]["holds"])

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values (docs/diagnosis.md); null where a quantity does not exist."""
        causes = [cause.to_json() for cause in self.causes]
        if self.unknown:
            causes.append({"name": "unknown", "parameters": {}, "evidence": self.unknown})
        return {
            "causes": causes,
            "free_run_rms": {
                "base": self.base_rms_um,
                "extended": self.extended_rms_um,
                "noise_floor": self.noise.rms_um,
                "persistence_one_step": self.persistence_um,
                "unit": "um",
            },
            "remaining": self.remaining.to_json() | {"base_rms_um": self.base_own_um},
            "scored_rows": row_ranges(self.held_rows),
            "noise_floor_from": self.noise.source,
            "unexplained_fraction": self.unexplained_fraction,
            "next_experiment": self.next_experiment,
            "held_change": self.remaining.sudden,
            "could_show": [ability.to_json() for ability in self.abilities],
            "not_named": [{"name": refused.name, "why": refused.why} for refused in self.refused],
            "probe_rms_um": _finite(self.probe_rms_um),
            "missing_certificates": list(self.missing_certificates),
        }


def row_ranges(rows: NDArray[np.intp]) -> list[list[int]]:
    """First row and row behind the last of each run of consecutive rows.

    >>> row_ranges(np.array([3, 4, 5, 9]))
    [[3, 6], [9, 10]]
    """
    ends = np.flatnonzero(np.diff(rows) > 1)
    firsts, lasts = rows[np.concatenate([[0], ends + 1])], rows[np.concatenate([ends, [len(rows) - 1]])]
    return [[int(first), int(last) + 1] for first, last in zip(firsts, lasts, strict=True)]


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


FALLING = "a hysteresis that may fall leaves {}, and has no inverse (--predict-only)"

WORTH_ANOTHER_FORM = 0.8
"""Own figure of another form, over that of the model, up to which it is spoken of: a finer form of the same hysteresis
gains some percent on any record."""

AT_THE_NOISE = 1.5
"""Own figure over the noise up to which nothing is left, and over that of the probe up to which both are as good."""

WITHOUT = {"past": "state before the rows", "periodic": "phase of the lines", "aging": "course of the aging",
           "drift": "course of the drift", "jump": "jumps", "gain step": "steps of the gain",
           "outliers": "wrong readings"}  # fmt: skip
"""What is taken out, in words, by cause."""


@dataclass(frozen=True)
class Left:
    """The model's own figure on the held-out rows.

    rms_um: of the model; in_noise: over the noise floor; probe_rms_um: of the probe on the same rows. reason: where the
    difference lies. taken: what was taken out of the error of the model.
    """

    rms_um: float
    in_noise: float
    probe_rms_um: float
    reason: str
    taken: tuple[Taken, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "rms_um": self.rms_um,
            "in_noise": self.in_noise,
            "probe_rms_um": self.probe_rms_um,
            "reason": self.reason,
            "taken_out": list(dict.fromkeys(taken.cause for taken in self.taken)),
            "taken_out_in_words": [taken.text for taken in self.taken],
        }

    def line(self) -> str:
        """One sentence for people."""
        causes = dict.fromkeys(WITHOUT.get(taken.cause, taken.cause) for taken in self.taken)
        without = f" without what no model can know ({', '.join(causes)})" if causes else ""
        return (
            f"Left{without}: {self.rms_um:.3g} um, {self.in_noise:.3g} times the noise; a finer model (the probe) "
            f"leaves {self.probe_rms_um:.3g} um on the same rows: {self.reason}."
        )

    @property
    def sudden(self) -> str:
        """Jumps and steps of the gain in the held-out rows, in words; "" if there are none."""
        found = [taken.text for taken in self.taken if taken.cause in ("jump", "gain step")]
        return f"in the held-out rows {', '.join(found)}: taken out of what is left" if found else ""


def left_over(
    prepared: Prepared,
    chain: Chain,
    extensions: Mapping[str, Extension],
    model: Remaining,
    noise_um: float,
    remembers: bool,
    falling: Callable[[], Remaining],
) -> Left:
    """What is left. chain: of the search; extensions: of all causes in it; model: what the last rung leaves.

    falling: what a hysteresis that may fall leaves, asked where something is left, the stage remembers, and the probe,
    which is bound to no form, leaves less.
    """
    known, error_um = _probe_error_um(prepared, chain)
    probe = left_by(prepared, extensions, error_um, model, finer=True)
    reason = _reason(model.rms_um, probe.rms_um, noise_um, _beyond(prepared, known))
    worth_um = WORTH_ANOTHER_FORM * model.rms_um
    left = model.rms_um > AT_THE_NOISE * noise_um and probe.rms_um <= worth_um
    if left and remembers and (other_um := falling().rms_um) <= worth_um:
        reason = FALLING.format(f"{other_um:.3g} um")
    return Left(model.rms_um, model.rms_um / max(noise_um, 1e-300), probe.rms_um, reason, model.taken)


def _probe_error_um(prepared: Prepared, chain: Chain) -> tuple[Rows, Floats]:
    """The rows of the identification part that the probe knows, and (n,) yhat - y of a chain fitted to them.

    Slow changes that the models are fitted without are parts of the chain, and so are no part of this error.
    """
    scene = prepared.scene(whole=True)
    known = scene.rows[scene.rows < prepared.cut]
    return known, -single_fit(thinned(scene.using(known)), chain).error


def _beyond(prepared: Prepared, known: Rows) -> str:
    """That the held-out rows leave the range of the fitted ones, in words; "" if these cover it but for 1 - COVERED."""
    seen_V, held_V = prepared.u_V[known], prepared.u_V[prepared.held_rows]
    both_V = np.concatenate([seen_V, held_V])
    if np.ptp(seen_V) >= COVERED * np.ptp(both_V):
        return ""
    ends = (held_V.min(), held_V.max(), seen_V.min(), seen_V.max())
    low_V, high_V, from_V, to_V = (f"{float(end_V):.4g}" for end_V in ends)
    return (
        f"the held-out rows go through {low_V} .. {high_V} V, the fitted ones through {from_V} .. {to_V} V: beyond "
        "these the stage was never seen; identify from rows that cover the range"
    )


def _reason(rms_um: float, probe_um: float, noise_um: float, beyond: str) -> str:
    """Where the difference between the model, the probe and the noise lies. beyond: of `_beyond`."""
    if rms_um <= AT_THE_NOISE * noise_um:
        return "the model is at the noise"
    if beyond:
        return beyond
    if rms_um > AT_THE_NOISE * probe_um:
        return "the difference is the form of the model, not the record"
    if probe_um <= AT_THE_NOISE * noise_um:
        return "both are close to the noise"
    return "what is left has a cause that no model here has, or the record is too short to determine it"
