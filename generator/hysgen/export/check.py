"""An exported model run in its target, compared bit for bit with the generated C on this machine.

The reference is the component of templates/export/component.c.j2 around the C that the model generates now, compiled as
by `hysgen verify`: what stands in the folder has no part in it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from hysgen.codegen import Options, generate
from hysgen.codegen.manifest import c_files
from hysgen.codegen.structs import interface
from hysgen.errors import BuildError
from hysgen.export import export_of
from hysgen.export.base import MODES, Mode, Samples, Words, component_facts, component_texts, modes_of
from hysgen.float32.coefficients import coefficients
from hysgen.machine.native import Library, build
from hysgen.model.model import Model

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
