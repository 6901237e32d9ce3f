"""C code from a model: `generate` returns the text of each file without side effects, `write` writes the files.

A generated folder consists of six C files, CMakeLists.txt, an example, the model file and MANIFEST.json. The same
model and options give the same bytes on every machine and at any time.
"""

import dataclasses
import json
import re
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from hysgen.codegen.derived import Derived, Options
from hysgen.codegen.manifest import CMAKE, EXAMPLE, MANIFEST, manifest, model_file, require_model
from hysgen.codegen.operations import Figures, figures
from hysgen.codegen.operations.cycles import Cycles, budget, cycles_of, per_sample, require_budget
from hysgen.codegen.parameters import Table, error_section, error_texts, numbers_digest
from hysgen.codegen.render import context, render
from hysgen.codegen.selftest import HASH_FACTOR, HASH_START, chains, learning
from hysgen.codegen.structs import alignment, interface, structs
from hysgen.display import decimal
from hysgen.errors import CertificateError, HysgenError, ModelError
from hysgen.float32.reference.accuracy import Accuracy, accuracy, beyond_references
from hysgen.machine.files import digest, only_writer, write_whole
from hysgen.machine.reproducible import rounded_up
from hysgen.model.file import dump_model
from hysgen.model.intervals import LARGEST
from hysgen.model.model import Model

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


NAMES_HOLD = "names that end in _um hold um, in _V V"
"""What the identifiers of the C hold, which are the same for all quantities."""


def in_quantities(model: Model, path: str, text: str) -> str:
    """The text of a file in the model's quantities; in C, comments and strings. A line says what identifiers hold.

    The C of one structure is the same for all quantities but for its comments, so firmware that calls it is, too.
    """
    stated = model.quantities
    if not stated.other:
        return text
    if not path.endswith((".c", ".h")):
        return stated.text(text)
    text = re.sub(r'/\*.*?\*/|"[^"\n]*"', lambda part: stated.text(part[0]), text, flags=re.DOTALL)
    return re.sub(r"\A/\*(.*?)( ?\*/)", rf"/*\1\n * Here {stated.text(NAMES_HOLD)}.\2", text, count=1, flags=re.DOTALL)


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


def write(texts: Mapping[str, str], folder: Path) -> None:
    """Write the files into `folder`, the manifest last; an interrupted write leaves no partial file.

    Processes take turns. Raises HysgenError, with nothing written, if the folder holds the C of another model.
    """
    with only_writer(folder):
        for place in (name for name in texts if name.endswith(MANIFEST)):
            require_model(folder / place, json.loads(texts[place])["model"])
        for name in sorted(texts, key=lambda name: name.endswith(MANIFEST)):
            write_whole(folder / name, texts[name])


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
