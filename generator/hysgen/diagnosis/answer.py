"""What a diagnosis says: the causes named, what each gains and rests on, and what remains."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.bootstrap import Gain
from hysgen.diagnosis.causes import Estimate
from hysgen.model.model import Model
from hysgen.record.noise import NoiseFloor

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Price:
    """What an extension costs per sample on the DSP."""

    cycles: int
    bytes: int


@dataclass(frozen=True)
class NamedCause:
    """A cause that evidence and gain agree on.

    evidence: in words. statistic: what the evidence comes to, in standard errors or their equivalent (`Signature.z`).
    step: rms on the ladder before and after its extension, held-out.
    alone: what leaving it out of the complete model costs, on blocks of the identification part left out of the fit;
    None for corrupted samples, for the error on these means nothing.
    probe_gain: how many times the probe's error beyond the white noise, on unfitted blocks, grows without it, as
    measured (`Found.needs`); None for corrupted samples, for the probe has no part for them.
    separated_by_likelihood: whether the cause is one of several slow causes and Schwarz's criterion finds the probe's
    chain far likelier with it. The cause is then named even if its probe_gain is below `Cause.needed`.
    share: part of the base error's power above the noise floor that its extension takes away; 0 if none is above.
    extended: whether its extension stands in the model: not if it does not pay there, with the certificates kept.
    """

    name: str
    parameters: Mapping[str, Estimate]
    evidence: str
    statistic: float
    step: Gain
    alone: Gain | None
    probe_gain: float | None
    separated_by_likelihood: bool
    share: float
    price: Price | None = None
    extended: bool = True

    @property
    def confidence(self) -> float | None:
        """Share of bootstrap draws, on blocks left out of the fit, in which its extension lowers the error by over 2 %.

        In the mean over blocks or in the rms (`bootstrap.combined_confidence`). It is no part of the evidence. None for
        corrupted samples: no such gain is measured.
        """
        return None if self.alone is None else self.alone.confidence

    def to_json(self) -> dict[str, Any]:
        """As in DESIGN.md, section 8, and more; null where a quantity does not exist or is not finite.

        So for corrupted samples `confidence`, `gain.alone` and `probe_gain` are null.
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
                "alone": None if alone is None else {"fall_um": alone.fall_um, "ci95": [alone.low_um, alone.high_um]},
            },
            "share": self.share,
            "extended": self.extended,
            "probe_gain": self.probe_gain,
            "separated_by_likelihood": self.separated_by_likelihood,
            "cost": None if self.price is None else {"cycles": self.price.cycles, "bytes": self.price.bytes},
        }


@dataclass(frozen=True)
class Refused:
    """A cause that was looked at closely and not named, and why."""

    name: str
    why: str


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The answer of `diagnose`.

    causes: in the order found. unknown: what the structure that is left looks like, or None.
    base, model: the paper's model and the extended one. errors_um: free-run error of each rung over the whole record.
    base_rms_um, extended_rms_um: free run, held out. persistence_um: of y(k+1) = y(k), held out.
    unexplained_fraction: part of the base error's power above the noise floor that is left; 0 if none is above.
    next_experiment: how to drive the stage to learn what this record cannot tell.
    """

    causes: tuple[NamedCause, ...]
    refused: tuple[Refused, ...]
    unknown: str | None
    base: Model
    model: Model
    base_rms_um: float
    extended_rms_um: float
    noise: NoiseFloor
    persistence_um: float
    unexplained_fraction: float
    next_experiment: str
    errors_um: tuple[tuple[str, Floats], ...] = field(repr=False)
    held_rows: NDArray[np.intp] = field(repr=False)
    probe_rms_um: float = math.nan

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the causes in the order found, `unknown` last if structure is left."""
        return (*(cause.name for cause in self.causes), *(("unknown",) if self.unknown else ()))

    @property
    def missing_certificates(self) -> tuple[str, ...]:
        """Those of gain, contraction and inverse that the extended model does not have.

        Fits keep them. Only where no certified model lies near the record is one without them delivered.
        """
        told = self.model.certificates
        return tuple(name for name in ("gain", "contraction", "inverse") if name in told and not told[name]["holds"])

    def to_json(self) -> dict[str, Any]:
        """As in DESIGN.md, section 8, and more; null where a quantity does not exist."""
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
            "noise_floor_from": self.noise.source,
            "unexplained_fraction": self.unexplained_fraction,
            "next_experiment": self.next_experiment,
            "not_named": [{"name": refused.name, "why": refused.why} for refused in self.refused],
            "probe_rms_um": _finite(self.probe_rms_um),
            "missing_certificates": list(self.missing_certificates),
        }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
