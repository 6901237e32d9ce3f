"""C code from a model: `generate` returns the text of each file without side effects, `write` writes the files.

A generated folder consists of six C files, CMakeLists.txt, an example, the model file and MANIFEST.json. The same
model and options give the same bytes on every machine and at any time. `Derived` holds what is computed from a model
for its C: certificates, float32 numbers, errors; each once.
"""

from __future__ import annotations

import dataclasses
import functools
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from hysgen.certify.certificates import Certificates, certify
from hysgen.codegen.learning import commit_feature, learner_feature
from hysgen.codegen.manifest import CMAKE, EXAMPLE, MANIFEST, in_quantities, manifest, model_file, write
from hysgen.codegen.operations import CLOCK_HZ, Cycles, Figures, budget, cycles_of, figures, per_sample, require_budget
from hysgen.codegen.parameters import (
    Section,
    Table,
    block_sections,
    error_section,
    error_texts,
    loop_sections,
    numbers_digest,
    range_section,
    rule_section,
    term_sections,
)
from hysgen.codegen.render import Feature, context, render
from hysgen.codegen.selftest import HASH_FACTOR, HASH_START, chains, learning
from hysgen.codegen.structs import alignment, interface, structs
from hysgen.display import decimal
from hysgen.errors import CertificateError, HysgenError, ModelError
from hysgen.float32.coefficients import Coefficients, coefficients
from hysgen.float32.reference.accuracy import Accuracy, accuracy, beyond_references
from hysgen.machine.files import digest
from hysgen.machine.reproducible import rounded_up
from hysgen.model.file import dump_model
from hysgen.model.intervals import LARGEST
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


__all__ = ["Derived", "Options", "cost_figures", "generate", "marked_source", "tables", "write"]

LEAST_RESOLVED: Final = 1e-5
"""Step of float32 at the end of the range, as a share of the range, below which it is fine enough in any case."""

MOST_MISSED: Final = 0.1
"""Share of its range by which an inverse may be off. That of the bundled models is off by 1e-5 of it or less, one whose
range has collapsed by all of it."""

ERROR_SAMPLES: Final = 20_000
ERROR_DIGITS: Final = 6
"""Digits of the errors found, in the manifest: a difference of 1e-6 of float64 numbers near 1 has 9 exact digits."""


@np.errstate(over="ignore", invalid="ignore")  # what float32 cannot hold is refused below, in one line
def generate(model: Model | Derived, options: Options | None = None) -> dict[str, str]:
    """The text of every file of the generated folder, by file name.

    Raises CertificateError, with place and value, if the options include an inverse that is singular or not certified
    stable in the model's range, BudgetError, with the numbers, if a sample takes longer than the sample period,
    ModelError if float32 does not resolve the displacement, and what `Derived.require_use` raises unless forced.
    """
    chosen = options or Options()
    derived = Derived.of(model)
    model = derived.model
    _require_resolution(model)
    if chosen.inverse:
        derived.require_inverse()
    if not chosen.forced:
        derived.require_use(chosen.inverse)
    errors = accuracy(model, ERROR_SAMPLES, inverse=chosen.inverse)
    if chosen.inverse:
        _require_inverse_resolution(model, errors)
    facts = _facts(derived, errors, inverse=chosen.inverse)
    facts["alignment"] = alignment(model) if chosen.aligned else None
    # The first rendering is for counting operations; the second has the counts in the comments of the header.
    counted = figures(model.name, _counted_texts(model.name, facts))
    unknown = sorted(set(chosen.cycles) - set(counted.operations))
    if unknown:
        raise HysgenError(f"{', '.join(unknown)}: not a function of {model.name}: {', '.join(counted.operations)}")
    cycles = cycles_of(counted.operations, chosen.cycles)
    require_budget(model, cycles, chosen.clock_Hz, chosen.budget_cycles)
    facts |= {
        "chains": chains(model, inverse=chosen.inverse),
        "learning": learning(model, derived.certificates),
        "hash_start": f"0x{HASH_START:08x}",
        "hash_factor": f"0x{HASH_FACTOR:08x}",
    }
    costs = {name: f"{counts.describe()}.\n * C674x: {cycles[name]}." for name, counts in counted.operations.items()}
    texts = _firmware(model.name, facts, costs, counted.struct_bytes)
    texts = {name: in_quantities(model, name, text) for name, text in texts.items()}
    texts[model_file(model)] = dump_model(model)
    stated = {} if chosen.budget_cycles is None else {"budget_cycles": chosen.budget_cycles}
    summary = {
        "options": {"inverse": chosen.inverse, "clock_Hz": chosen.clock_Hz, **stated},
        "certificates": derived.certificates.to_json(),
        "error": _errors(errors),
        "cost": _cost(model, counted, cycles, chosen.clock_Hz),
    }
    return texts | {MANIFEST: manifest(model, texts, summary)}


def _require_resolution(model: Model) -> None:
    """Raise ModelError if the step of float32 at the end of the displacement range exceeds half the noise.

    Also if float32 ends before it: references reach one width of the range beyond either end, three times its end.
    """
    low_um, high_um = model.grid.y_min_um, model.grid.y_max_um
    end_um = max(abs(low_um), abs(high_um))
    if 3.0 * end_um > LARGEST:
        raise ModelError(f"{model.name}: a displacement of {end_um:.3g} um is beyond float32; give it in a larger unit")
    step_um = float(np.spacing(np.float32(end_um)))
    noise_um = float(model.scores.get("identification", {}).get("noise_floor", {}).get("rms_um", 0.0))
    fine_um = LEAST_RESOLVED * (high_um - low_um)
    limit_um, limit = max((0.5 * noise_um, "half the noise"), (fine_um, f"{LEAST_RESOLVED:g} of the range"))
    if step_um > limit_um:
        raise ModelError(
            f"{model.name}: at {high_um:.9g} um float32 has steps of {decimal(step_um, 3)} um, more than {limit} "
            f"({decimal(limit_um, 3)} um); take {low_um:.9g} um off the displacement, in the record before "
            "the fit and in the controller"
        )


def _require_inverse_resolution(model: Model, errors: Accuracy) -> None:
    """Raise CertificateError if the inverse misses by more than MOST_MISSED of its range, or its references by all.

    Not of a path that responds: its error is that of a displacement, on commands that light modes cannot follow.
    """
    if model.responds:
        return
    missed = errors.inverse_V / (model.u_max_V - model.u_min_V)
    if missed > MOST_MISSED or (missed := beyond_references(model)) > 1.0:
        raise CertificateError(
            f"{model.name}: one sample of the input leaves its range of displacement, and the inverse is off by up to "
            f"{missed:.3g} of the range of the input; fit it over a wider one, or generate without the inverse"
        )


def cost_figures(model: Model | Derived, options: Options | None = None) -> Figures:
    """Operations and bytes of the C that `generate` returns for these options, without its errors and self-test.

    Raises CertificateError and BudgetError as `generate` does.
    """
    chosen = options or Options()
    derived = Derived.of(model)
    model = derived.model
    if chosen.inverse:
        derived.require_inverse()
    # The errors stand in comments and in macros of the parameter file; neither is an operation or a byte.
    facts = _facts(derived, Accuracy(0, 0.0, 0.0, 0.0), inverse=chosen.inverse)
    counted = figures(model.name, _counted_texts(model.name, facts))
    require_budget(model, cycles_of(counted.operations, chosen.cycles), chosen.clock_Hz, chosen.budget_cycles)
    return counted


def tables(model: Model) -> list[Table]:
    """Every table of constants of `<name>_params.h` that the generated C reads, in the order of the file."""
    return [table for section in Derived(model).sections for table in section.tables]


def _errors(errors: Accuracy) -> dict[str, Any]:
    """The errors for the manifest, rounded up: found, 0 without an inverse, and proved, None without a bound."""
    fields = dataclasses.asdict(errors)
    proved, samples = fields.pop("proved"), fields.pop("samples")
    largest = {name: rounded_up(error, ERROR_DIGITS) for name, error in fields.items()} | {"samples": samples}
    return {
        "found": largest,
        "proved": proved and {name: bound and rounded_up(bound, 2) for name, bound in proved.items()},
    }


def marked_source(model: Model, *, inverse: bool) -> str:
    """The text of `<name>.c` with a line for every hook of its templates (hooks.py), otherwise that of `generate`."""
    facts = _algorithm_facts(Derived(model), inverse=inverse)
    return render("source.c.j2", facts, marked=True)


def _algorithm_facts(derived: Derived, *, inverse: bool) -> dict[str, Any]:
    """The variables of `source.c.j2`: of the model, of its features and whether there is an inverse."""
    facts = context(derived.model, derived.numbers) | {"inverse": inverse, "features": derived.features}
    for feature in derived.features:
        facts |= feature.facts
    return facts


def _facts(derived: Derived, errors: Accuracy, *, inverse: bool) -> dict[str, Any]:
    """The variables of all templates except the cost of the functions."""
    model = derived.model
    sections = [*derived.sections, error_section(errors, inverse=inverse, responds=model.responds)]
    return _algorithm_facts(derived, inverse=inverse) | {
        "prototypes": interface(model, inverse=inverse).prototypes,
        "structs": structs(model),
        "alignment": None,
        "learns": model.learner is not None,
        "errors": error_texts(model.name, errors, responds=model.responds),
        "sections": sections,
        "numbers_digest": numbers_digest(sections),
    }


def _counted_texts(name: str, facts: Mapping[str, Any]) -> dict[str, str]:
    """The C files whose operations and bytes are counted, without costs in their comments."""
    complete = {**facts, "figures": defaultdict(str), "bytes": defaultdict(int), "algorithm": ""}
    files = {f"{name}.h": "header.h.j2", f"{name}_params.h": "params.h.j2", f"{name}.c": "source.c.j2"}
    return {file: render(template, complete) for file, template in files.items()}


def _firmware(name: str, facts: Mapping[str, Any], cost: Mapping[str, str], sizes: Mapping[str, int]) -> dict[str, str]:
    """The C files by name, and CMakeLists.txt.

    cost: text on the cost by function, default ""; sizes: bytes by struct, default 0.
    """
    source = render("source.c.j2", facts)
    complete = {
        **facts,
        "figures": defaultdict(str, cost),
        "bytes": defaultdict(int, sizes),
        "algorithm": digest(source.encode()),
    }
    return {
        f"{name}.h": render("header.h.j2", complete),
        f"{name}.c": source,
        f"{name}_params.h": render("params.h.j2", complete),
        f"{name}_selftest.h": render("selftest.h.j2", complete),
        f"{name}_selftest.c": render("selftest.c.j2", complete),
        f"{name}_selftest_data.h": render("selftest_data.h.j2", complete),
        CMAKE: render("CMakeLists.txt.j2", complete),
        EXAMPLE: render("example.c.j2", complete),
    }


def _cost(model: Model, counted: Figures, cycles: Mapping[str, Cycles], clock_Hz: float) -> dict[str, Any]:
    """Operations, cycles and bytes for the manifest, as JSON values."""
    whole = per_sample(cycles)
    return {
        "operations": {name: counts.to_json() for name, counts in counted.operations.items()},
        "cycles": {name: {"value": c.value, "measured": c.measured} for name, c in cycles.items()},
        "per_sample": {"value": whole.value, "measured": whole.measured, "budget": budget(model.Ts_s, clock_Hz)},
        "bytes": {"structs": dict(counted.struct_bytes), "constants": counted.constant_bytes},
    }
