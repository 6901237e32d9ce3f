"""Is the generated C its reference, in every bit? `verify` compiles a folder in every way and compares.

Results, states, status words and counters are compared as 32-bit patterns, over chains of samples of every style, at
every compiler and level that is installed, with and without flushing denormal numbers to zero. Beside the folder's
model, models of other structures are generated, compiled and compared.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Final

from hysgen.certify.certificates import certify
from hysgen.checking.bits.builds import COMPILERS, LEVELS, compiled, toolchains, versions
from hysgen.checking.bits.comparison import compare
from hysgen.checking.bits.random_models import faint_model, kin, random_model
from hysgen.checking.bits.report import Mismatch, Report, Run
from hysgen.codegen import Options, generate
from hysgen.codegen.manifest import read_folder
from hysgen.model.model import Model

__all__ = ["Mismatch", "Report", "Run", "verify", "verify_texts"]

DEFAULT_SAMPLES: Final = 1_000_000
DEFAULT_STRUCTURES: Final = 5
SAMPLES_PER_STRUCTURE: Final = 40_000


def verify(
    folder: Path,
    *,
    samples: int = DEFAULT_SAMPLES,
    structures: int = DEFAULT_STRUCTURES,
    seed: int = 1,
    compilers: Sequence[str] = COMPILERS,
    levels: Sequence[str] = LEVELS,
    progress: Callable[[float, str], None] | None = None,
) -> Report:
    """Compare the C in a folder that `hysgen generate` wrote with the reference of the model beside it.

    samples: of the folder's model, in each build, over all functions. structures: other models: the same structure with
    other numbers, one with very small numbers, then models drawn from `seed` on.
    compilers, levels: what to build with; a compiler that is missing is told in the report.
    progress: told the fraction done and what is being done.
    Raises HysgenError if the folder lacks its model or files, or no compiler is installed or takes the C.
    """
    generated = read_folder(folder)
    return verify_texts(
        generated.model,
        generated.texts,
        samples=samples,
        structures=structures,
        seed=seed,
        compilers=compilers,
        levels=levels,
        progress=progress,
        altered=generated.altered,
    )


def verify_texts(
    model: Model,
    texts: Mapping[str, str],
    *,
    samples: int = DEFAULT_SAMPLES,
    structures: int = DEFAULT_STRUCTURES,
    seed: int = 1,
    compilers: Sequence[str] = COMPILERS,
    levels: Sequence[str] = LEVELS,
    progress: Callable[[float, str], None] | None = None,
    altered: tuple[str, ...] = (),
) -> Report:
    """`verify` for generated texts that need not lie in a folder."""
    started = time.monotonic()
    found, skipped = toolchains(compilers, levels)
    drawn = [kin(model, seed), faint_model(), *(random_model(seed + k) for k in range(structures))]
    others = drawn[:structures]
    todo = [(model, texts, samples), *((other, _texts(other), SAMPLES_PER_STRUCTURE) for other in others)]
    total, done = sum(share for _, _, share in todo), 0
    runs: list[Run] = []
    mismatches: list[Mismatch] = []
    for current, current_texts, share in todo:
        if progress is not None:
            progress(done / total, f"compiling {current.name}")
        made, unable = compiled(current.name, current_texts, found)
        skipped += [reason for reason in unable if reason not in skipped]

        def advance(compared: int, name: str = current.name) -> None:
            nonlocal done
            done += compared
            if progress is not None:
                progress(min(1.0, done / total), f"comparing {name}")

        for run, wrong in compare(current, made, share, seed, advance):
            runs.append(run)
            mismatches.extend(wrong)
    seconds = time.monotonic() - started
    labels = (*versions(found), "with and without flush to zero" if not any("flush" in s for s in skipped) else "")
    return Report(
        model.name, tuple(filter(None, labels)), tuple(skipped), altered, tuple(runs), tuple(mismatches), seconds
    )


def _texts(other: Model) -> dict[str, str]:
    """C of a drawn model, with its inverse where that is certified."""
    return generate(other, Options(inverse=certify(other).inverse_holds))
