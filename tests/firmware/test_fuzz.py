"""Random settings, faults, references, requests, bytes and preemption: no invariant of the firmware breaks."""

from __future__ import annotations

import functools
import re
import time

import pytest

from fixtures.firmware_bench import model
from hysgen.firmware.binding import firmware_model
from hysgen.firmware.sources import CONTROLLER, HOST_BOARD, read_sources
from hysgen.machine.native import Library, Toolchain, build, default_toolchain

DECLARED = "uint64_t fuzz_cases(uint64_t, uint64_t, uint32_t *, uint32_t *);"
NAMES = ("range", "rate", "model and stage apart", "parameters", "refused settings")
CORPUS = 300
"""Seeds of the corpus: 0 to CORPUS - 1; each repeats to the bit. `tests/firmware/test_fuzz.py COUNT` tries more."""


def library(changes: tuple[tuple[str, str, str], ...] = ()) -> Library:
    """The firmware with the fuzzer; changes: (file, old, new) of planted faults."""
    sources = dict([*read_sources(CONTROLLER), *read_sources(HOST_BOARD)])
    sources |= {name: text for name, text in firmware_model(model()).items() if re.fullmatch(r"\w+\.[ch]", name)}
    for file, old, new in changes:
        sources[file], count = re.subn(old, new, sources[file])
        assert count == 1, (file, old)
    return build(list(sources.items()), DECLARED, Toolchain(default_toolchain().command, ("-O2",)), ())


@functools.cache
def sound() -> Library:
    return library()


def broken(fuzzer: Library, first: int, count: int) -> tuple[dict[str, int], int, int]:
    """Cases per broken invariant, the first such seed, and samples in TRACK."""
    counts, tracked = fuzzer.ffi.new("uint32_t [6]"), fuzzer.ffi.new("uint32_t *")
    seed = fuzzer.lib.fuzz_cases(first, count, counts, tracked)
    return {name: counts[i] for i, name in enumerate(NAMES) if counts[i]}, seed, tracked[0]


def test_no_case_of_the_corpus_breaks_an_invariant() -> None:
    found, seed, tracked = broken(sound(), 0, CORPUS)
    assert not found, f"first at seed {seed}"
    assert tracked > 100 * CORPUS


@pytest.mark.parametrize(
    ("fault", "name"),
    [
        (
            (
                (
                    "controller.c",
                    r"self->output_V = number_limited\([^;]*;",
                    "self->output_V = controller_towards(self->output_V, wish_V, settings->step_V);",
                ),
                ("controller.c", r"\? settings->loop_high_V", "? settings->high_V + 1.0f"),
            ),
            "range",
        ),
        ((("controller.c", r"number_size\(way\) <= step", "number_size(way) <= 9.0f * step"),), "rate"),
        ((("watchdog.c", r"far = \(uint32_t\)", "far = 0u * (uint32_t)"),), "model and stage apart"),
        ((("firmware.c", r"status \|= STATUS_FAULT_SETTINGS", "status |= 0u"),), "refused settings"),
    ],
    ids=lambda each: each if isinstance(each, str) else "",
)
@pytest.mark.slow
def test_the_fuzzer_finds_a_planted_fault(fault: tuple[tuple[str, str, str], ...], name: str) -> None:
    found, _, _ = broken(library(fault), 0, CORPUS)
    assert name in found


if __name__ == "__main__":
    import sys

    count, started = int(sys.argv[1]), time.monotonic()
    found, seed, tracked = broken(sound(), 0, count)
    hours = (time.monotonic() - started) / 3600.0
    print(f"{count} cases, {tracked} samples in TRACK, broken: {found or 'none'}, first seed {seed}, {hours:.3f} h")
