"""C code from a model: `generate` returns the text of each file without side effects, `write` writes the files.

A generated folder consists of six C files, CMakeLists.txt, an example, the model file and MANIFEST.json. The same
model and options give the same bytes on every machine and at any time.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from hysgen.certify.certificates import Certificates, certify
from hysgen.codegen.learning import commit_feature, learner_feature
from hysgen.codegen.manifest import CMAKE, EXAMPLE, MANIFEST, manifest, model_file
from hysgen.codegen.operations import Figures, figures
from hysgen.codegen.operations.cycles import CLOCK_HZ, Cycles, budget, cycles_of, per_sample, require_budget
from hysgen.codegen.parameters import (
    Section,
    Table,
    block_sections,
    error_section,
    numbers_digest,
    range_section,
    rule_section,
    term_sections,
)
from hysgen.codegen.render import Feature, context, render
from hysgen.codegen.selftest import HASH_FACTOR, HASH_START, chains, learning
from hysgen.codegen.structs import alignment, interface, structs
from hysgen.errors import CertificateError, HysgenError
from hysgen.float32.coefficients import Coefficients, coefficients
from hysgen.float32.reference.accuracy import Accuracy, accuracy
from hysgen.machine.files import digest, write_whole
from hysgen.machine.reproducible import rounded_up
from hysgen.model.file import dump_model
from hysgen.model.model import Model

__all__ = ["Options", "cost_figures", "generate", "marked_source", "tables", "write"]

ERROR_SAMPLES: Final = 20_000
ERROR_DIGITS: Final = 6
"""Digits of the worst errors in the manifest: a difference of 1e-6 of float64 numbers near 1 has 9 exact digits."""


@dataclass(frozen=True)
class Options:
    """Options of the generated code and of its processor.

    inverse: whether the inverse is generated. clock_Hz: clock of the processor.
    cycles: measured stall-free cycles by function; the cycles of functions that are not listed are estimated.
    budget_cycles: cycles that one sample may take; None: the sample period.
    aligned: whether the learner is aligned to 8 bytes on the C674x, as its kernels demand.
    """

    inverse: bool = True
    clock_Hz: float = CLOCK_HZ
    cycles: Mapping[str, int] = field(default_factory=dict)
    budget_cycles: int | None = None
    aligned: bool = False


# Each function returns its feature, or None if the model does not need it; in the order of the generated text.
FEATURES: list[Callable[[Model, Coefficients, Certificates], Feature | None]] = [learner_feature, commit_feature]


def generate(model: Model, options: Options | None = None) -> dict[str, str]:
    """The text of every file of the generated folder, by file name.

    Raises CertificateError, with place and value, if the options include an inverse that is singular or not certified
    stable in the model's range, and BudgetError, with the numbers, if a sample takes longer than the sample period.
    """
    chosen = options or Options()
    certificates = certify(model)
    if chosen.inverse:
        _require_inverse(model, certificates)
    errors = accuracy(model, ERROR_SAMPLES, inverse=chosen.inverse)
    facts = _facts(model, certificates, errors, inverse=chosen.inverse)
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
        "learning": learning(model, certificates),
        "hash_start": f"0x{HASH_START:08x}",
        "hash_factor": f"0x{HASH_FACTOR:08x}",
    }
    costs = {name: f"{counts.describe()}.\n * C674x: {cycles[name]}." for name, counts in counted.operations.items()}
    texts = _firmware(model.name, facts, costs, counted.struct_bytes)
    texts[model_file(model)] = dump_model(model)
    summary = {
        "options": {"inverse": chosen.inverse, "clock_Hz": chosen.clock_Hz, **_stated_budget(chosen)},
        "certificates": certificates.to_json(),
        "worst_error": {
            "predict_um": rounded_up(errors.predict_um, ERROR_DIGITS),
            **_inverse_error(model, errors),
            "samples": errors.samples,
        },
        "cost": _cost(model, counted, cycles, chosen.clock_Hz),
    }
    return texts | {MANIFEST: manifest(model, texts, summary)}


def cost_figures(model: Model, options: Options | None = None) -> Figures:
    """Operations and bytes of the C that `generate` returns for these options, without its errors and self-test.

    Raises CertificateError and BudgetError as `generate` does.
    """
    chosen = options or Options()
    certificates = certify(model)
    if chosen.inverse:
        _require_inverse(model, certificates)
    # The errors stand in comments and in macros of the parameter file; neither is an operation or a byte.
    facts = _facts(model, certificates, Accuracy(0, 0.0, 0.0, 0.0, 0.0), inverse=chosen.inverse)
    counted = figures(model.name, _counted_texts(model.name, facts))
    require_budget(model, cycles_of(counted.operations, chosen.cycles), chosen.clock_Hz, chosen.budget_cycles)
    return counted


def tables(model: Model) -> list[Table]:
    """Every table of constants of `<name>_params.h` that the generated C reads, in the order of the file."""
    numbers = coefficients(model)
    sections = _sections(model, numbers, _features(model, numbers, certify(model)))
    return [table for section in sections for table in section.tables]


def _features(model: Model, numbers: Coefficients, certificates: Certificates) -> list[Feature]:
    return [feature for build in FEATURES if (feature := build(model, numbers, certificates)) is not None]


def _sections(model: Model, numbers: Coefficients, features: Sequence[Feature]) -> list[Section]:
    """The sections of `<name>_params.h` except that of the worst errors."""
    return [
        range_section(numbers, responds=model.responds),
        rule_section(model, numbers),
        *block_sections(model),
        *term_sections(model, numbers),
        *(section for feature in features for section in feature.sections),
    ]


def _stated_budget(options: Options) -> dict[str, int]:
    """The budget for the manifest, if one is stated."""
    return {} if options.budget_cycles is None else {"budget_cycles": options.budget_cycles}


def _inverse_error(model: Model, errors: Accuracy) -> dict[str, float]:
    """Error of the inverse for the manifest: of the voltage or, behind responses of the stage, of what is reached."""
    if not model.responds:
        return {"inverse_V": rounded_up(errors.inverse_V, ERROR_DIGITS)}
    return {
        "path": rounded_up(errors.path, ERROR_DIGITS),
        "inverse_um": rounded_up(errors.predict_of_inverse_um, ERROR_DIGITS),
    }


def marked_source(model: Model, *, inverse: bool) -> str:
    """The text of `<name>.c` with a line for every hook of its templates (hooks.py), otherwise that of `generate`."""
    facts = _algorithm_facts(model, coefficients(model), certify(model), inverse=inverse)
    return render("source.c.j2", facts, marked=True)


def write(texts: Mapping[str, str], folder: Path) -> None:
    """Write the files into `folder`, the manifest last; an interrupted write leaves no partial file."""
    for name in sorted(texts, key=lambda name: name == MANIFEST):
        write_whole(folder / name, texts[name])


def _algorithm_facts(
    model: Model, numbers: Coefficients, certificates: Certificates, *, inverse: bool
) -> dict[str, Any]:
    """The variables of `source.c.j2`: of the model, of its features and whether there is an inverse."""
    features = _features(model, numbers, certificates)
    facts = context(model, numbers) | {"inverse": inverse, "features": features}
    for feature in features:
        facts |= feature.facts
    return facts


def _facts(model: Model, certificates: Certificates, errors: Accuracy, *, inverse: bool) -> dict[str, Any]:
    """The variables of all templates except the cost of the functions."""
    numbers = coefficients(model)
    facts = _algorithm_facts(model, numbers, certificates, inverse=inverse)
    sections = _sections(model, numbers, facts["features"])
    sections.append(error_section(errors, inverse=inverse, responds=model.responds))
    return facts | {
        "prototypes": interface(model, inverse=inverse).prototypes,
        "structs": structs(model),
        "alignment": None,
        "learns": model.learner is not None,
        "sections": sections,
        "numbers_digest": numbers_digest(sections),
    }


def _counted_texts(name: str, facts: Mapping[str, Any]) -> dict[str, str]:
    """The C files whose operations and bytes are counted, without costs in their comments."""
    complete = {**facts, "figures": defaultdict(str), "bytes": defaultdict(int), "algorithm": ""}
    files = {f"{name}.h": "header.h.j2", f"{name}_params.h": "params.h.j2", f"{name}.c": "source.c.j2"}
    return {file: render(template, complete) for file, template in files.items()}


def _require_inverse(model: Model, certificates: Certificates) -> None:
    """Raise CertificateError, with place and value, if Eq. (11) of `model` is singular or its path has no inverse."""
    remedy = "restrict the range (generate --displacement-range), or generate without the inverse"
    if not certificates.gain_holds:
        low, high = certificates.gain_lowest, certificates.gain_highest
        unit = f"um/{certificates.w_unit}"
        worst = low if abs(low.value) <= abs(high.value) or low.value * high.value < 0.0 else high
        raise CertificateError(
            f"{model.name}: the gain df/d{certificates.w_name} is {worst.value:.4g} {unit} at y = {worst.y_um:.4g} um "
            f"and {high.value:.4g} {unit} at y = {high.y_um:.4g} um, so the inverse is singular or nearly so; {remedy}"
        )
    if not certificates.inverse_holds:
        raise CertificateError(
            f"{model.name}: the inverse of the path is not certified ({'; '.join(certificates.path.parts())}): a "
            "voltage may not exist; fit the model again, or generate without the inverse"
        )


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
