"""Comparison of the files in a folder, byte for byte, with newly generated text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Stale:
    """A file that is missing or differs; line: number of the first different line, counted from 1."""

    name: str
    fault: str
    line: int | None = None

    def __str__(self) -> str:
        return f"{self.name}: {self.fault}" + (f" from line {self.line} on" if self.line else "")


def stale(texts: Mapping[str, str], folder: Path) -> list[Stale]:
    """The files of `texts` (text by file name) that are missing or different in `folder`, sorted by name."""
    differences = []
    for name in sorted(texts):
        try:
            data = (folder / name).read_bytes()
        except OSError:
            differences.append(Stale(name, "missing"))
            continue
        if data != texts[name].encode():
            differences.append(Stale(name, "differs", _first_difference(data, texts[name].encode())))
    return differences


def _first_difference(one: bytes, other: bytes) -> int:
    """Number of the first different line, counted from 1."""
    mine, theirs = one.split(b"\n"), other.split(b"\n")
    pairs = enumerate(zip(mine, theirs, strict=False), start=1)
    return next((number for number, (a, b) in pairs if a != b), min(len(mine), len(theirs)) + 1)
