"""Random settings, faults, references, images, resets, and interrupts before any access to memory of the idle loop.

    PYTHONPATH=tests python tests/firmware/test_fuzz.py CASES           tries CASES seeds and prints what broke
    PYTHONPATH=tests python tests/firmware/test_fuzz.py CASES --corpus  writes those of a new feature to fuzz/corpus.txt

The C of the fuzzer is in tests/firmware/fuzz. It is compiled with -fsanitize=thread, whose calls before each access to
memory are the places where an interrupt may come.
"""

# Safety case: [S1], [S2], [S3], [S10]

import argparse
import functools
import re
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from fixtures.firmware_bench import KEY, model
from hysgen.firmware import CONTROLLER, HOST_BOARD, Label, encode, firmware_folder, firmware_model, read_sources
from hysgen.machine.native import Library, Toolchain, build, default_toolchain
from hysgen.model.file import load_model
from hysgen.model.model import Model

FUZZER = Path(__file__).parent / "fuzz"
CORPUS = FUZZER / "corpus.txt"
INTERRUPTS = 600
"""Interrupts of a case: the shortest start takes some 200, a commit 40."""
ROOM = 4096
CHUNK = 20_000
PLANTED, RARE = 1000, {"store": 16_000, "stuck": 4000, "status": 4000}
"""Cases in which each planted fault is found: the rarest break 2 of them, a stuck sensor 5 of 4000, a lost image 3."""
SLOW = 4096
"""Every so manieth sensor drifts so slowly that feedback and learning follow it, and a guard that learns along too."""
NAMES = ("range", "rate", "apart", "parameters", "refused", "store", "panic", "correction", "stuck", "status", "armed",
         "drift")  # fmt: skip
DECLARED = """
void fuzz_give(const uint8_t *);
uint32_t fuzz_image_bytes(void);
uint64_t fuzz_cases(uint64_t, uint64_t, uint32_t, uint32_t *, uint64_t *, uint8_t *, uint64_t *, uint32_t, uint32_t *);
uint64_t fuzz_preemptions(void);
uint32_t fuzz_places(void);
"""
FLAGS = ("-O3", "-fsanitize=thread", "-nostdlib", "-fno-semantic-interposition", "-fno-plt", "-Wl,-Bsymbolic")
PACKAGED = ("-O3", "-Xclang", *(flag for flag in FLAGS[1:] if flag != "-nostdlib"))
"""The compiler of pip links functions of its own unless its front end alone is told; it brings headers of a libc."""
Change = tuple[str, str, str]


@dataclass(frozen=True)
class Found:
    """Cases by broken invariant, the first seed that broke one, samples in TRACK, seeds that reached something new."""

    broken: dict[str, int]
    seed: int
    tracked: int
    finders: tuple[int, ...]


def images(driven: Model) -> bytes:
    """Three images that the firmware accepts, with rising counters, and one that is not certified."""

    def scaled(factor: float) -> Model:
        return replace(driven, consequents=driven.consequents * [1.0, factor, 1.0])

    good = [encode(scaled(factor), KEY, Label(counter=1 + i)) for i, factor in enumerate((1.01, 0.99, 1.02))]
    return b"".join([*good, encode(scaled(-1.0), KEY, Label(counter=9))])


def library(changes: tuple[Change, ...] = (), driven: Model | None = None) -> Library:
    """The firmware with the fuzzer; changes: (file, pattern, replacement) of planted faults."""
    driven = driven or model()
    sources = dict([*read_sources(CONTROLLER), *read_sources(HOST_BOARD)])
    sources |= {name: text for name, text in firmware_model(driven).items() if re.fullmatch(r"\w+\.[ch]", name)}
    sources |= {path.name: path.read_text(encoding="utf-8") for path in FUZZER.glob("*.[ch]")}
    for file, old, new in changes:
        sources[file], count = re.subn(old, new, sources[file])
        assert count == 1, (file, old)
    compiler = default_toolchain()
    chosen = Toolchain(compiler.command, PACKAGED if "cc" in compiler.call[1:] else FLAGS)
    built = build(list(sources.items()), DECLARED, chosen, ("-lc",))
    given = images(driven)
    assert len(given) == 4 * built.lib.fuzz_image_bytes()
    built.lib.fuzz_give(given)
    return built


@functools.cache
def sound() -> Library:
    return library()


def fuzzed(fuzzer: Library, seeds: Iterable[range], progress: Callable[[Found], None] = lambda _: None) -> Found:
    """The result over all seeds; progress: called with the result so far after each range."""
    ffi = fuzzer.ffi
    broken, tracked, features = ffi.new("uint32_t [12]"), ffi.new("uint64_t *"), ffi.new("uint8_t [4096]")
    finders, found, worst = ffi.new("uint64_t []", ROOM), ffi.new("uint32_t *"), 1 << 64
    result = Found({}, worst, 0, ())
    for each in seeds:
        seed = fuzzer.lib.fuzz_cases(each.start, len(each), INTERRUPTS, broken, tracked, features, finders, ROOM, found)
        worst = min(worst, seed)
        counts = {name: broken[i] for i, name in enumerate(NAMES) if broken[i]}
        result = Found(counts, worst, tracked[0], tuple(finders[0 : found[0]]))
        progress(result)
    return result


def corpus() -> list[range]:
    """The seeds of the corpus."""
    lines = CORPUS.read_text(encoding="utf-8").splitlines()
    return [range(int(line.split()[0]), int(line.split()[0]) + 1) for line in lines if not line.startswith("#")]


def test_no_case_of_the_corpus_breaks_an_invariant() -> None:
    seeds = corpus()
    found = fuzzed(sound(), seeds)
    assert not found.broken, f"first at seed {found.seed}"
    assert len(seeds) > 50
    assert found.tracked > 50 * len(seeds)
    assert sound().lib.fuzz_places() > 100


@pytest.mark.parametrize(
    ("name", "file", "old", "new"),
    [
        (
            "range",
            "controller.c",
            r"self->output_V = number_limited\([^;]*;",
            "self->output_V = controller_towards(self->output_V, state_V + 99.0f, settings->step_V);",
        ),
        ("rate", "controller.c", r"number_size\(way\) <= step", "number_size(way) <= 9.0f * step"),
        ("apart", "watchdog.c", r"far = \(uint32_t\)", "far = 0u * (uint32_t)"),
        ("parameters", "firmware.c", r"self->controller.installing = 1u;", ""),
        ("refused", "firmware.c", r"status \|= STATUS_FAULT_SETTINGS", "status |= 0u"),
        pytest.param(
            "store",
            "store.c",
            r"slot = \(uint32_t\)\(self->slot == 0u\)",
            "slot = (uint32_t)(self->slot == 1u)",
            marks=pytest.mark.proof,
        ),
        (
            "panic",
            "firmware.c",
            r"hysgen_board_amplifier_enable\(board, 0u\)",
            "hysgen_board_amplifier_enable(board, 1u)",
        ),
        ("correction", "controller.c", r"if \(\(settings->options & SETTINGS_LOOP\) != 0u\) \{", "{"),
        ("stuck", "controller.c", r"        if \(hysgen_controller_drives\(self\) == 0u\) \{", "{"),
        (
            "status",
            "firmware.c",
            r"    firmware_line\(self, board\);",
            "    self->controller.status |= self->image_status; firmware_line(self, board);",
        ),
        ("drift", "controller.c", r"self->start_um \+ self->offset_um :", "self->expected_um[now] :"),
        ("armed", "firmware.c", r"(enable\(board, )hysgen_controller_drives\(&self->controller\)", r"\g<1>1u"),
    ],
)
@pytest.mark.slow
def test_the_fuzzer_finds_a_planted_fault(name: str, file: str, old: str, new: str) -> None:
    seeds = (
        [range(at - 1, at) for at in range(SLOW, 5 * SLOW, SLOW)]
        if name == "drift"
        else [range(RARE.get(name, PLANTED))]
    )
    found = fuzzed(library(((file, old, new),)), seeds)
    assert name in found.broken


def show(count: int, first: int, driven: Model) -> Found:
    """Try `count` seeds from `first` on and print the result so far after every CHUNK of them."""
    fuzzer, started = library((), driven), time.monotonic()
    chunks = [range(at, min(at + CHUNK, first + count)) for at in range(first, first + count, CHUNK)]
    ends = iter(chunks)

    def progress(found: Found) -> None:
        print(
            f"{driven.name}: seeds {first} to {next(ends).stop - 1}, {INTERRUPTS} interrupts each, "
            f"{fuzzer.lib.fuzz_preemptions()} of all inside the idle loop, before {fuzzer.lib.fuzz_places()} different "
            f"accesses to memory, {found.tracked} in TRACK, broken: {found.broken or 'none'}, "
            f"{(time.monotonic() - started) / 3600.0:.2f} h",
            *((f"first seed: {found.seed}",) if found.broken else ()),
            flush=True,
        )

    return fuzzed(fuzzer, chunks, progress)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", type=int)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--model", default="appendix_a", help="name of a model in firmware/models")
    parser.add_argument("--corpus", action="store_true", help="write the seeds that reach something new to the corpus")
    chosen = parser.parse_args()
    shipped = firmware_folder() / "models" / chosen.model / f"{chosen.model}.json"
    reached = show(chosen.cases, chosen.first, load_model(shipped))
    if chosen.corpus:
        head = CORPUS.read_text(encoding="utf-8").splitlines()[0]
        seeds = sorted(reached.finders)
        CORPUS.write_text("\n".join([head, *map(str, seeds), ""]), encoding="utf-8")
