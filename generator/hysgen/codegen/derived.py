"""What is computed from a model for its C: certificates, float32 numbers, errors; each once."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from hysgen.certify.certificates import Certificates, certify
from hysgen.codegen.learning import commit_feature, learner_feature
from hysgen.codegen.operations.cycles import CLOCK_HZ
from hysgen.codegen.parameters import Section, block_sections, loop_sections, range_section, rule_section, term_sections
from hysgen.codegen.render import Feature
from hysgen.errors import CertificateError, ModelError
from hysgen.float32.coefficients import Coefficients, coefficients
from hysgen.model.model import Model
from hysgen.model.scores import NEXT_TO_NOTHING

MOST_MOVED = 0.1
"""Share of its range by which half the noise of the displacement may move the input that an inverse asks for."""


@dataclass(frozen=True)
class Options:
    """Options of the generated code and of its processor.

    inverse: whether the inverse is generated. clock_Hz: clock of the processor.
    cycles: measured stall-free cycles by function; the cycles of functions that are not listed are estimated.
    budget_cycles: cycles that one sample may take; None: the sample period.
    aligned: whether the learner is aligned to 8 bytes on the C674x, as its kernels demand.
    forced: whether there is C of a model, and an inverse, that `Derived.require_use` refuses.
    """

    inverse: bool = True
    clock_Hz: float = CLOCK_HZ
    cycles: Mapping[str, int] = field(default_factory=dict)
    budget_cycles: int | None = None
    aligned: bool = False
    forced: bool = False


@dataclass(frozen=True)
class Derived:
    """A model with all that is computed from it, when it is asked for the first time."""

    model: Model

    @classmethod
    def of(cls, model: Model | Derived) -> Derived:
        """The argument itself if it is derived already."""
        return model if isinstance(model, Derived) else cls(model)

    @functools.cached_property
    def certificates(self) -> Certificates:
        """Contraction, gain and inverse over the range of the model."""
        return certify(self.model)

    @functools.cached_property
    def numbers(self) -> Coefficients:
        """The float32 numbers of the C."""
        return coefficients(self.model)

    @functools.cached_property
    def features(self) -> list[Feature]:
        """Learner and commit of a model with learner settings, in the order of the generated text."""
        both = (
            learner_feature(self.model, self.numbers),
            commit_feature(self.model, self.numbers, self.certificates) if self.model.learner else None,
        )
        return [feature for feature in both if feature is not None]

    @functools.cached_property
    def sections(self) -> list[Section]:
        """The sections of `<name>_params.h` except that of the worst errors."""
        return [
            range_section(self.numbers, responds=self.model.responds),
            rule_section(self.model, self.numbers),
            *block_sections(self.model),
            *term_sections(self.model, self.numbers),
            *loop_sections(self.model, self.numbers),
            *(section for feature in self.features for section in feature.sections),
        ]

    @property
    def options(self) -> Options:
        """The usual options: with the inverse if it is certified."""
        return Options(inverse=self.certificates.inverse_holds)

    def require_use(self, inverse: bool) -> None:
        """Raise ModelError for a model that explains next to nothing of its record, CertificateError if noise moves the
        inverse: noise/2 > MOST_MOVED (w_high - w_low) min |b(y)|.
        """
        name, known, scale = self.model.name, self.model.scores.get("identification", {}), self.certificates
        for line in known.get("warnings", ()):
            if NEXT_TO_NOTHING in line:
                raise ModelError(f"{name}: {line}; record again, or give --force")
        noise_um = 0.5 * float(known.get("noise_floor", {}).get("rms_um", 0.0))
        gain, whole = min(abs(scale.gain_lowest.value), abs(scale.gain_highest.value)), float(np.ptp(scale.w_range))
        if inverse and noise_um > MOST_MOVED * whole * gain:
            raise CertificateError(
                f"{name}: half the noise of the displacement, {noise_um:.3g} um, moves the {scale.w_name} of the "
                f"inverse by {noise_um / (gain or 1e-300):.3g} of its {whole:.3g} {scale.w_unit}: its gain is down to "
                f"{gain:.3g} um/{scale.w_unit}; give --no-inverse, or --force"
            )

    @property
    def predict_only(self) -> bool:
        """Whether the model was fitted for predictions alone (`FitSettings.rising`): then there is no inverse."""
        return self.model.history.get("fit", {}).get("rising") is False

    def require_inverse(self) -> None:
        """Raise CertificateError, with place and value, if Eq. (11) is singular or the path has no inverse."""
        certificates, name = self.certificates, self.model.name
        remedy = "restrict the range (generate --displacement-range), or generate without the inverse"
        if not certificates.gain_holds:
            low, high = certificates.gain_lowest, certificates.gain_highest
            unit = f"um/{certificates.w_unit}"
            worst = low if abs(low.value) <= abs(high.value) or low.value * high.value < 0.0 else high
            raise CertificateError(
                f"{name}: the gain df/d{certificates.w_name} is {worst.value:.4g} {unit} at y = {worst.y_um:.4g} um "
                f"and {high.value:.4g} {unit} at y = {high.y_um:.4g} um, so the inverse is singular or nearly so; "
                f"{remedy}"
            )
        if not certificates.inverse_holds:
            raise CertificateError(
                f"{name}: the inverse of the path is not certified ({'; '.join(certificates.path.parts())}): a "
                "voltage may not exist; fit the model again, or generate without the inverse"
            )
