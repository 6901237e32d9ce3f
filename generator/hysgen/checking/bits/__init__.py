"""Bit-for-bit comparison of generated C with its float32 reference, in every build that this machine can make.

Results, states, status words and counters are compared as 32-bit patterns, over chains of samples of every input style,
with every installed compiler at every level, with and without flushing denormal numbers to zero.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from hysgen.checking.bits.comparison import compare, samples_to_compare
from hysgen.checking.bits.report import ComparedRun, Mismatch, Report
from hysgen.checking.host import LEVELS, compiled, host_compilers, toolchains, versions
from hysgen.model.model import Model

__all__ = ["ComparedRun", "Mismatch", "Report", "VerifySettings", "verify_texts"]

DEFAULT_SAMPLES: Final = 1_000_000


@dataclass(frozen=True)
class VerifySettings:
    """Extent of a verification.

    samples: in each build, divided among the functions. compilers, levels: the builds; the report names a compiler that
    is not installed.
    """

    samples: int = DEFAULT_SAMPLES
    seed: int = 1
    compilers: Sequence[str] = field(default_factory=host_compilers)
    levels: Sequence[str] = LEVELS


def verify_texts(
    model: Model,
    texts: Mapping[str, str],
    settings: VerifySettings | None = None,
    progress: Callable[[float, str], None] | None = None,
    altered: tuple[str, ...] = (),
) -> Report:
    """Compare generated C with the reference of its model.

    progress: called with the fraction done and the current step. altered: files that differ from the manifest, for the
    report. Raises BuildError if no compiler is installed or one rejects the C.
    """
    started = time.monotonic()
    chosen = settings or VerifySettings()
    installed, skipped = toolchains(chosen.compilers, chosen.levels)
    if progress is not None:
        progress(0.0, f"compiling {model.name}")
    builds, unavailable = compiled(model.name, texts, installed)
    planned, done = samples_to_compare(builds[0].host, chosen.samples), 0

    def advance(samples: int) -> None:
        nonlocal done
        done += samples
        if progress is not None:
            progress(done / planned, f"comparing {model.name}")

    runs: list[ComparedRun] = []
    mismatches: list[Mismatch] = []
    for run, wrong in compare(model, builds, chosen.samples, chosen.seed, advance):
        runs.append(run)
        mismatches.extend(wrong)
    skipped = list(dict.fromkeys([*skipped, *unavailable]))
    seconds = time.monotonic() - started
    labels = (*versions(installed), "with and without flush to zero" if not any("flush" in s for s in skipped) else "")
    return Report(
        model.name, tuple(filter(None, labels)), tuple(skipped), altered, tuple(runs), tuple(mismatches), seconds
    )
