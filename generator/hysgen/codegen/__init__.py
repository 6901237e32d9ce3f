"""C from a model: `generate` is pure and returns text, `write` puts it into a folder.

Five files of C that the firmware takes, and beside them the model itself and MANIFEST.json. The same model and options
give the same bytes; nothing in them depends on the machine or the clock.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from hysgen.certify.certificates import Certificates, certify
from hysgen.codegen.commit import commit_concern
from hysgen.codegen.concerns import Concern
from hysgen.codegen.guarantees import require_budget, require_inverse
from hysgen.codegen.interface import interface
from hysgen.codegen.learning import learner_concern
from hysgen.codegen.manifest import MANIFEST, manifest, model_file
from hysgen.codegen.operations import Figures, figures
from hysgen.codegen.operations.cycles import CLOCK_HZ, Cycles, budget, cycles_of, per_sample
from hysgen.codegen.parameters import block_sections, error_section, range_section, rule_section, term_sections
from hysgen.codegen.render import context, render
from hysgen.codegen.selftest import chains
from hysgen.float32.coefficients import Coefficients, coefficients
from hysgen.float32.reference.accuracy import accuracy
from hysgen.machine.files import write_whole
from hysgen.machine.reproducible import rounded_up
from hysgen.model.file import dump_model
from hysgen.model.model import Model

__all__ = ["Options", "generate", "write"]

ERROR_SAMPLES: Final = 20_000
ERROR_DIGITS: Final = 6
"""Of the worst errors, rounded up: an error of 1e-6 is a difference of float64 numbers near 1 and has 9 good digits."""


@dataclass(frozen=True)
class Options:
    """What is generated besides init, predict and simulate, and for what processor.

    cycles: stall-free cycles per function as measured on the target; those that are missing are estimated.
    """

    inverse: bool = True
    clock_Hz: float = CLOCK_HZ
    cycles: Mapping[str, int] = field(default_factory=dict)


# Each gives its concern, or None if the model does not ask for it; in the order of the generated text.
CONCERNS: list[Callable[[Model, Coefficients, Certificates], Concern | None]] = [learner_concern, commit_concern]


def generate(model: Model, options: Options | None = None) -> dict[str, str]:
    """File name -> text of everything that belongs to the generated folder.

    Raises CertificateError, with place and value, if an inverse is asked for that is singular or unstable in the
    model's range, and BudgetError, with the numbers, if a sample takes longer than the sample period.
    """
    chosen = options or Options()
    certificates = certify(model)
    if chosen.inverse:
        require_inverse(model, certificates)
    numbers = coefficients(model)
    upper = model.name.upper()
    errors = accuracy(model, ERROR_SAMPLES, inverse=chosen.inverse)
    concerns = [concern for build in CONCERNS if (concern := build(model, numbers, certificates)) is not None]
    sections = [range_section(numbers), rule_section(numbers, upper), *block_sections(model)]
    sections += term_sections(model, numbers, upper)
    sections += [section for concern in concerns for section in concern.sections]
    facts = context(model, numbers) | {
        "inverse": chosen.inverse,
        "prototypes": interface(model, inverse=chosen.inverse).prototypes,
        "concerns": concerns,
        "sections": [*sections, error_section(errors, inverse=chosen.inverse)],
        "chains": chains(model, inverse=chosen.inverse),
    }
    for concern in concerns:
        facts |= concern.facts
    # Costs are counted in the code, then told in the comments of its header.
    found = figures(model.name, _firmware(model.name, facts, {}, {}))
    cycles = cycles_of(found.operations, chosen.cycles)
    require_budget(model, cycles, chosen.clock_Hz)
    told = {name: f"{counts.describe()}.\n * C674x: {cycles[name]}." for name, counts in found.operations.items()}
    texts = _firmware(model.name, facts, told, found.struct_bytes)
    texts[model_file(model)] = dump_model(model)
    summary = {
        "options": {"inverse": chosen.inverse, "clock_Hz": chosen.clock_Hz},
        "certificates": certificates.to_json(),
        "worst_error": {
            "predict_um": rounded_up(errors.predict_um, ERROR_DIGITS),
            "inverse_V": rounded_up(errors.inverse_V, ERROR_DIGITS),
            "samples": errors.samples,
        },
        "cost": _cost(model, found, cycles, chosen.clock_Hz),
    }
    return texts | {MANIFEST: manifest(model, texts, summary)}


def write(texts: Mapping[str, str], folder: Path) -> None:
    """Write every text into `folder`, each file whole or not at all, the manifest last."""
    for name in sorted(texts, key=lambda name: name == MANIFEST):
        write_whole(folder / name, texts[name])


def _firmware(name: str, facts: Mapping[str, Any], told: Mapping[str, str], sizes: Mapping[str, int]) -> dict[str, str]:
    """The files of C. told: what the header says of a function's cost; sizes: bytes of structs; "" where unknown."""
    complete = {**facts, "figures": defaultdict(str, told), "bytes": defaultdict(int, sizes)}
    return {
        f"{name}.h": render("header.h.j2", complete),
        f"{name}.c": render("source.c.j2", complete),
        f"{name}_params.h": render("params.h.j2", complete),
        f"{name}_selftest.h": render("selftest.h.j2", complete),
        f"{name}_selftest.c": render("selftest.c.j2", complete),
    }


def _cost(model: Model, found: Figures, cycles: Mapping[str, Cycles], clock_Hz: float) -> dict[str, Any]:
    """Operations, cycles and bytes as plain JSON values."""
    whole = per_sample(cycles)
    return {
        "operations": {name: counts.to_json() for name, counts in found.operations.items()},
        "cycles": {name: {"value": c.value, "measured": c.measured} for name, c in cycles.items()},
        "per_sample": {"value": whole.value, "measured": whole.measured, "budget": budget(model.Ts_s, clock_Hz)},
        "bytes": {"structs": dict(found.struct_bytes), "constants": found.constant_bytes},
    }
