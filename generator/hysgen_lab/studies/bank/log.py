"""The log of a run: one JSON line for each record, on the disk as soon as it is judged, so that a run can be resumed.

    {"hysgen bank": 1, "sources": "..."}
    {"category": "creep", "seed": 1000, ...}

The first line holds the digest of the package that judged; a log of another state of the package is refused.
"""

import dataclasses
import json
import math
import os
from collections.abc import Iterator
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from hysgen.errors import HysgenError
from hysgen.machine.files import digest
from hysgen_lab.studies.bank.result import Judgement

FORM = 1

RATIOS = ("fall", "over_truth", "over_probe", "gain")
"""Values of a judgement that may be nan, null in the file."""


def sources_digest() -> str:
    """SHA-256 over the names and texts of the Python and C files of product and laboratory."""
    packages = ("hysgen", __package__.partition(".")[0])
    files = sorted(file for package in packages for file in _sources(resources.files(package), f"{package}/"))
    return digest("".join(f"{name} {digest(text)}\n" for name, text in files).encode())


def read_log(path: Path) -> list[Judgement]:
    """The judgements of a log; none if there is no such file. An incomplete last line is ignored.

    Raises HysgenError if the file is not a log, or was written by another state of the package.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return []
    except (OSError, UnicodeDecodeError) as fault:
        raise HysgenError(f"{path}: cannot be read as a log of the bank; choose another file") from fault
    whole = text.split("\n")[:-1]
    if not whole:
        return []
    head = _parsed(path, 1, whole[0])
    if head.get("hysgen bank") != FORM:
        raise HysgenError(f"{path}: row 1: not a log of the bank; choose another file")
    if head.get("sources") != sources_digest():
        raise HysgenError(f"{path}: judged by another state of hysgen; remove it, or choose another file")
    judgements = []
    for row, line in enumerate(whole[1:], start=2):
        try:
            judgements.append(_judgement(_parsed(path, row, line)))
        except (KeyError, TypeError) as fault:
            raise HysgenError(f"{path}: row {row}: not a judgement; remove the file, or choose another") from fault
    return judgements


class JudgementLog:
    """Appends judgements to a file; an incomplete last line is removed first. Without a path nothing is written."""

    def __init__(self, path: Path | None) -> None:
        self._path = path
        if path is None:
            return
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("a+b") as stream:
                stream.seek(0)
                whole = stream.read().rpartition(b"\n")
                stream.truncate(len(whole[0]) + len(whole[1]))
            if not whole[1]:
                self._append({"hysgen bank": FORM, "sources": sources_digest()})
        except OSError as fault:
            raise HysgenError(f"{path}: cannot be written ({fault.strerror}); choose another file") from fault

    def add(self, judgement: Judgement) -> None:
        """Append one line; it is on the disk when the function returns."""
        if self._path is not None:
            values = dataclasses.asdict(judgement)
            self._append({key: _finite(value) for key, value in values.items()})

    def _append(self, values: dict[str, Any]) -> None:
        assert self._path is not None
        with self._path.open("a", encoding="utf-8", newline="\n") as stream:
            stream.write(json.dumps(values, allow_nan=False) + "\n")
            stream.flush()
            os.fsync(stream.fileno())


def _judgement(values: dict[str, Any]) -> Judgement:
    names = {field.name for field in dataclasses.fields(Judgement)}
    if set(values) != names:
        raise KeyError(str(sorted(names ^ set(values))))
    lists = {key: tuple(values[key]) for key in ("planted", "required", "named", "allowed")}
    ratios = {key: math.nan if values[key] is None else float(values[key]) for key in RATIOS}
    return Judgement(**(values | lists | ratios))


def _parsed(path: Path, row: int, line: str) -> dict[str, Any]:
    try:
        values = json.loads(line)
    except json.JSONDecodeError as fault:
        raise HysgenError(f"{path}: row {row}: not JSON; remove the file, or choose another") from fault
    if not isinstance(values, dict):
        raise HysgenError(f"{path}: row {row}: not an object; remove the file, or choose another")
    return values


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _sources(folder: Traversable, prefix: str) -> Iterator[tuple[str, bytes]]:
    for entry in folder.iterdir():
        name = f"{prefix}{entry.name}"
        if entry.is_dir():
            if entry.name != "__pycache__":
                yield from _sources(entry, f"{name}/")
        elif name.endswith((".py", ".c", ".h")):
            yield name, entry.read_bytes()
