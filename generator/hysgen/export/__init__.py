"""Folders that bring a model into other tools, found by listing the modules of this package.

An export is an `Export` that a module there defines: its templates, its build and the ways to run it. Each folder
holds the generated C in model/, the files of the export, a build and an example. `export_texts` returns the texts;
`write_export` writes them, and compiles what the folder ships as a binary. `compare` runs a folder in its target, bit
for bit against the generated C on this machine: the component of templates/export/component.c.j2 around the C that the
model generates now, compiled as by `hysgen verify`; what stands in the folder has no part in it.
"""

from __future__ import annotations

import functools
import importlib
import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from hysgen.codegen import Options, generate
from hysgen.codegen.manifest import c_files, in_quantities, write
from hysgen.codegen.structs import interface
from hysgen.errors import BuildError, HysgenError, nearest
from hysgen.export.base import (
    MODES,
    Draft,
    Export,
    Mode,
    Samples,
    Words,
    Written,
    component_facts,
    component_texts,
    modes_of,
)
from hysgen.float32.coefficients import coefficients
from hysgen.machine.native import Library, build
from hysgen.model.model import Model
from hysgen.model.path import preview

__all__ = ["Export", "export_of", "export_texts", "exports", "write_export"]


@functools.lru_cache(maxsize=1)
def exports() -> Mapping[str, Export]:
    """Every export by its name, that of `--to`. Raises ValueError if two have the same name."""
    registry: dict[str, Export] = {}
    for module in sorted(entry.name for entry in pkgutil.iter_modules(__path__)):
        held = vars(importlib.import_module(f"{__name__}.{module}")).values()
        for export in (item for item in held if isinstance(item, Export)):
            if registry.setdefault(export.name, export) is not export:
                raise ValueError(f"{module}: the name {export.name!r} belongs to another export")
    return dict(sorted(registry.items()))


def export_of(name: str) -> Export:
    """The export of this name. Raises HysgenError if there is none."""
    if name not in exports():
        raise HysgenError(f"{name}: is no target{nearest(name, exports())}; choose from {', '.join(exports())}")
    return exports()[name]


def export_texts(model: Model, name: str, options: Options | None = None) -> dict[str, str]:
    """The text of every file of the folder, by its path there; what is built from them is not among them.

    Raises HysgenError for an unknown export, and the errors of `generate`.
    """
    return _texts(export_of(name), _draft(model, export_of(name), options))


def write_export(
    model: Model, name: str, folder: Path, options: Options | None = None, given: Mapping[str, str] | None = None
) -> list[Path]:
    """Write the folder of an export, with its binaries. Returns the paths in the order of writing.

    given: values of the export's own options. Raises the errors of `export_texts`, and BuildError where a compiler is
    missing or an option does not fit the model.
    """
    export = export_of(name)
    draft = _draft(model, export, options)
    texts = _texts(export, draft)
    write(texts, folder)
    values = {option.name: "" for option in export.options} | dict(given or {})
    return [folder / path for path in (*texts, *export.finish(Written(draft, folder, texts, values)))]


def _draft(model: Model, export: Export, options: Options | None) -> Draft:
    chosen = options or Options()
    facts = {**component_facts(model, chosen), "target": export.name, "title": export.title, "runs": bool(export.ways)}
    facts["preview"] = preview(model.blocks) if chosen.inverse else 0
    draft = Draft(model, chosen, generate(model, chosen), facts)
    return replace(draft, facts={**facts, **export.facts(draft)})


def _texts(export: Export, draft: Draft) -> dict[str, str]:
    texts = {f"model/{file}": text for file, text in draft.generated.items()}
    texts |= draft.rendered(export.files)
    texts |= export.sources(draft)
    texts |= {"README.md": draft.readme(export.readme)} if export.readme else {}
    named = set(draft.generated.values())  # in the model's quantities, wherever the export copies them
    return {path: text if text in named else in_quantities(draft.model, path, text) for path, text in texts.items()}


Progress = Callable[[float, str], None]

SEED: Final = 21
CORRUPTED: Final = (np.nan, np.inf, -np.inf, 1e30, -1e30, 1e-42, -0.0)
CORRUPTED_EVERY: Final = 97
"""One sample in so many is corrupted: often enough for every kind in each input within 10 000 samples."""

COMMITS: Final = 8
NOISE_UM: Final = 1e-4
"""Standard deviation of the noise of the displacement: small against the range of any stage, far above one ulp."""

SIMULATE: Final = MODES[1]
_HEADER_WORDS: Final = 4
"""Members of `<name>_component_t` before the model: mode, result, committing, answer."""


@dataclass(frozen=True)
class Compared:
    """Samples of one mode in one target, and how many of them have another result or another status word."""

    target: str
    mode: str
    samples: int
    differ: int

    def __str__(self) -> str:
        return f"{self.target:<14} {self.mode:<9} {self.samples} samples, {self.differ} differ"


def compare(
    model: Model, target: str, folder: Path, n: int, options: Options | None = None, progress: Progress | None = None
) -> list[Compared]:
    """Run the target in `folder` over n samples of every mode. Raises BuildError where a tool is missing or fails."""
    chosen = options or Options()
    runners = export_of(target).ways
    modes = modes_of(model, chosen)
    component = Reference.compile(model, chosen)
    compared = []
    for m, mode in enumerate(modes):
        samples = inputs(component, mode, n)
        expected = component.run(samples)
        for r, (name, runner) in enumerate(runners.items()):
            if progress is not None:
                progress((m + r / len(runners)) / len(modes), f"{name}, mode {mode.name}")
            given = runner(model, folder, samples)
            if given.shape != expected.shape:
                raise BuildError(f"{name}, mode {mode.name}: {len(given)} of {n} samples came back")
            compared.append(Compared(name, mode.name, n, int(np.any(given != expected, axis=1).sum())))
    return compared


@dataclass(frozen=True)
class Reference:
    """The component of a model, compiled on this machine. words: size of its state."""

    model: Model
    library: Library
    words: int

    @classmethod
    def compile(cls, model: Model, options: Options) -> Reference:
        """The component around the generated C. Raises BuildError without a compiler, and the errors of `generate`."""
        name = model.name
        texts = {**generate(model, options), **component_texts(component_facts(model, options))}
        sources = {Path(path).name: text for path, text in texts.items()}
        declared = (
            f"uint32_t {name}_component_start(void *, uint32_t, float, float);\n"
            f"void {name}_component_run(void *, uint32_t, const float *, const float *, const float *,"
            " const uint32_t *, float *, uint32_t *);\n"
        )
        del sources["main.c"]
        known = {struct.name: struct.size for struct in interface(model, inverse=options.inverse).structs}
        words = _HEADER_WORDS + known[f"{name}_t"] + known.get(f"{name}_learner_t", 0)
        return cls(model, build(list(c_files(sources).items()), declared, None, libraries=()), words)

    def run(self, samples: Samples) -> Words:
        """(n, 2) bits of results and status words. Raises BuildError if the component does not have the mode."""
        ffi, name = self.library.ffi, self.model.name
        start, run = (getattr(self.library.lib, f"{name}_component_{function}") for function in ("start", "run"))
        memory = ffi.new("uint32_t[]", self.words)
        if not start(memory, samples.mode.number, samples.y0_um, samples.u0_V):
            raise BuildError(f"{name}: has no mode {samples.mode.name}")
        out = np.empty((2, len(samples.rows)), np.uint32)
        columns = [samples.column(0), samples.column(1), samples.aux]
        floats = [ffi.from_buffer("float *", column) for column in columns]
        commit = ffi.from_buffer("uint32_t *", samples.commit)
        result = ffi.cast("float *", ffi.from_buffer(out[0]))
        run(memory, len(samples.rows), *floats, commit, result, ffi.from_buffer("uint32_t *", out[1]))
        return out.T


def inputs(component: Reference, mode: Mode, n: int) -> Samples:
    """Two sines over the range of the voltage, the model's free run as displacement, and corrupted samples.

    The displacement that a learner is given is 0.2 % larger than the model's, so that it learns and commits.
    """
    numbers = coefficients(component.model)
    random = np.random.default_rng(SEED + mode.number)
    low, high = float(numbers.u_min_V), float(numbers.u_max_V)
    k = np.arange(n + 1)
    wave = 0.6 * np.sin(2 * np.pi * k / 503.0) + 0.39 * np.sin(2 * np.pi * k / 8191.0 + 1.0)
    u = (0.5 * (low + high) + 0.5 * (high - low) * wave).astype(np.float32)
    u0 = np.float32(0.5 * (low + high))
    channels = len(component.model.channels)
    rows = np.zeros((n + 1, 3 + channels), np.uint32)
    rows[:, 1] = u.view(np.uint32)
    free = component.run(Samples(SIMULATE, numbers.rest_um, u0, rows))[:, 0].copy().view(np.float32)
    y = np.concatenate([[numbers.rest_um], free[:-1]]) + NOISE_UM * random.standard_normal(n + 1)
    value = u[:-1]
    if mode.name == "inverse":
        value = y[1:].astype(np.float32)
    if mode.name == "learn":
        y = 1.002 * y
    columns = [y[:-1].astype(np.float32), value]
    columns += [random.standard_normal(n).astype(np.float32) for _ in range(channels)]
    for place, column in enumerate(columns):
        column = column.copy()
        bad = np.arange(CORRUPTED_EVERY * (place + 1), n, CORRUPTED_EVERY)
        column[bad] = np.array(CORRUPTED, np.float32)[random.integers(len(CORRUPTED), size=bad.size)]
        rows[:-1, place] = column.view(np.uint32)
    if mode.name == "learn":
        rows[n // COMMITS : -1 : max(1, n // COMMITS), -1] = 1
    return Samples(mode, numbers.rest_um, u0, rows[:-1])
