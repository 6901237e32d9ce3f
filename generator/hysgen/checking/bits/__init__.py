"""Bit-for-bit comparison of generated C with its float32 reference, in every build that this machine can make.

Results, states, status words and counters are compared as 32-bit patterns, over chains of samples of every input style,
with every installed compiler at every level, with and without flushing denormal numbers to zero. Other models, most of
them random, are generated, compiled and compared in addition to the folder's model.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from hysgen.checking.bits.comparison import compare, samples_to_compare
from hysgen.checking.bits.random_models import (
    complete_model,
    low_gain_model,
    perturbed_model,
    random_model,
)
from hysgen.checking.bits.report import ComparedRun, Mismatch, Report
from hysgen.checking.host import LEVELS, compiled, host_compilers, toolchains, versions
from hysgen.codegen import Derived, generate
from hysgen.codegen.manifest import read_folder
from hysgen.model.model import Model

__all__ = ["ComparedRun", "Mismatch", "Report", "VerifySettings", "verify", "verify_texts"]

DEFAULT_SAMPLES: Final = 1_000_000
DEFAULT_OTHER_MODELS: Final = 5
SAMPLES_PER_OTHER_MODEL: Final = 40_000


@dataclass(frozen=True)
class VerifySettings:
    """Extent of a verification.

    samples: of the verified model, in each build, divided among its functions. other_models: number of further models:
    the same structure with other parameters, one with very small parameters, then random models of seeds seed, seed +
    1, ... compilers, levels: the builds; the report names a compiler that is not installed.
    """

    samples: int = DEFAULT_SAMPLES
    other_models: int = DEFAULT_OTHER_MODELS
    seed: int = 1
    compilers: Sequence[str] = field(default_factory=host_compilers)
    levels: Sequence[str] = LEVELS


def verify(
    folder: Path, settings: VerifySettings | None = None, progress: Callable[[float, str], None] | None = None
) -> Report:
    """Compare the C in a folder written by `hysgen generate` with the reference of the model beside it.

    progress: called with the fraction done and the current step.
    Raises HysgenError if the folder lacks its model or a file, BuildError if no compiler is installed or one rejects
    the C.
    """
    generated = read_folder(folder)
    return verify_texts(generated.model, generated.texts, settings, progress, generated.altered)


def verify_texts(
    model: Model,
    texts: Mapping[str, str],
    settings: VerifySettings | None = None,
    progress: Callable[[float, str], None] | None = None,
    altered: tuple[str, ...] = (),
) -> Report:
    """`verify` for generated texts in memory. altered: files that differ from the manifest, for the report."""
    started = time.monotonic()
    chosen = settings or VerifySettings()
    seed = chosen.seed
    installed, skipped = toolchains(chosen.compilers, chosen.levels)
    drawn = [perturbed_model(model, seed), low_gain_model(), complete_model(seed)]
    drawn += [random_model(seed + k) for k in range(chosen.other_models)]
    others = drawn[: chosen.other_models]
    todo = [(model, texts, chosen.samples), *((other, _texts(other), SAMPLES_PER_OTHER_MODEL) for other in others)]
    total, done = sum(share for _, _, share in todo), 0
    runs: list[ComparedRun] = []
    mismatches: list[Mismatch] = []
    for current, current_texts, share in todo:
        if progress is not None:
            progress(done / total, f"compiling {current.name}")
        builds, unavailable = compiled(current.name, current_texts, installed)
        skipped += [reason for reason in unavailable if reason not in skipped]

        begun, compared, planned = done, 0, samples_to_compare(builds[0].host, share)

        def advance(
            samples: int, name: str = current.name, begun: int = begun, share: int = share, planned: int = planned
        ) -> None:
            nonlocal compared
            compared += samples
            if progress is not None:
                progress((begun + share * compared / planned) / total, f"comparing {name}")

        for run, wrong in compare(current, builds, share, seed, advance):
            runs.append(run)
            mismatches.extend(wrong)
        done += share
    seconds = time.monotonic() - started
    labels = (*versions(installed), "with and without flush to zero" if not any("flush" in s for s in skipped) else "")
    return Report(
        model.name, tuple(filter(None, labels)), tuple(skipped), altered, tuple(runs), tuple(mismatches), seconds
    )


def _texts(other: Model) -> dict[str, str]:
    """The generated C of a model, with its inverse if the inverse is certified."""
    derived = Derived(other)
    return generate(derived, derived.options)
