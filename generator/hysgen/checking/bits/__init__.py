"""Bit-for-bit comparison of generated C with its float32 reference, in every build that this machine can make.

Results, states, status words and counters are compared as 32-bit patterns, over chains of samples of every input style,
with every installed compiler at every level, with and without flushing denormal numbers to zero. Here the results of a
verification as data, JSON values and text.
"""

import dataclasses
import struct
from dataclasses import dataclass
from typing import Any

from hysgen.display import Displayed, Summary, table

SMALLEST_NORMAL = 0x00800000


@dataclass(frozen=True)
class Mismatch:
    """The first difference between generated C and reference in one run of one build.

    word: "result", or the C path of a word of the state. got, expected: its bits. inputs: bits of the sample's
    arguments.
    """

    model: str
    function: str
    style: str
    build: str
    sample: int
    word: str
    got: int
    expected: int
    inputs: tuple[int, ...]

    def __str__(self) -> str:
        call = f"{self.model}_{self.function}({', '.join(_shown(bits) for bits in self.inputs)})"
        where = f"{self.style} inputs, sample {self.sample}, {self.build}"
        return f"{call}: {self.word} is {_shown(self.got)}, expected {_shown(self.expected)} [{where}]"


@dataclass(frozen=True)
class ComparedRun:
    """One function of one model under one input style: the samples compared in each of `builds` builds."""

    model: str
    function: str
    style: str
    samples: int
    builds: int


@dataclass(frozen=True, repr=False)
class Report(Displayed):
    """Result of a verification.

    builds: compared compilers, levels and floating-point modes. skipped: builds left out, with the reason. altered:
    files that differ from the manifest. seconds: wall time.
    """

    model: str
    builds: tuple[str, ...]
    skipped: tuple[str, ...]
    altered: tuple[str, ...]
    runs: tuple[ComparedRun, ...]
    mismatches: tuple[Mismatch, ...]
    seconds: float

    @property
    def equal(self) -> bool:
        """Whether every compared bit is equal and every file is as in the manifest."""
        return not self.mismatches and not self.altered and bool(self.runs)

    @property
    def samples(self) -> int:
        """Samples per build of the model's step functions; init, self-test and commit do not count."""
        steps = (
            run for run in self.runs if run.model == self.model and run.function not in ("init", "selftest", "commit")
        )
        return sum(run.samples for run in steps)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return dataclasses.asdict(self) | {"equal": self.equal, "samples": self.samples}

    def summary(self) -> Summary:
        """One row per function and model; notes name skipped builds, altered files and differences."""
        rows = []
        keys = dict.fromkeys((run.model, run.function) for run in self.runs)
        for model, function in keys:
            runs = [run for run in self.runs if (run.model, run.function) == (model, function)]
            wrong = len({m.build for m in self.mismatches if (m.model, m.function) == (model, function)})
            total, builds = sum(run.samples for run in runs), max(run.builds for run in runs)
            rows.append([model, function, f"{total}", f"{builds}", f"{wrong} differ" if wrong else "equal"])
        verdict = "equal in every bit" if self.equal else "NOT EQUAL"
        notes = [
            f"builds: {', '.join(self.builds)}",
            *(f"NOT COMPARED: {reason}" for reason in self.skipped),
            *(f"ALTERED: {reason}" for reason in self.altered),
            *(f"DIFFERENT: {mismatch}" for mismatch in self.mismatches),
        ]
        title = f"{self.model}: {verdict} over {self.samples} samples per build"
        return Summary(title, ["model", "function", "samples", "builds", "result"], rows, notes, left=2)

    def lines(self) -> list[str]:
        """The report as text; the verdict is the last line."""
        summary = self.summary()
        text = table(summary.header, summary.rows, summary.left)
        return [text, *summary.notes, f"{summary.title}, {self.seconds:.1f} s"]


def _shown(bits: int) -> str:
    """The pattern and its value as a float, or as an integer if the float would be denormal: counters, status words."""
    value = struct.unpack("<f", struct.pack("<I", bits))[0] if bits >= SMALLEST_NORMAL else bits
    return f"0x{bits:08x} ({value:.9g})"
