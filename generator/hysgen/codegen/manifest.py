"""MANIFEST.json: the files of a generated folder with digests, model, options, certificates, errors and cost."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from hysgen.errors import HysgenError
from hysgen.machine.files import digest, only_writer, version, write_whole
from hysgen.model.file import load_model
from hysgen.model.model import Model

MANIFEST: Final = "MANIFEST.json"
SCHEMA: Final = "hysgen-manifest"
VERSION: Final = 1
CMAKE: Final = "CMakeLists.txt"
EXAMPLE: Final = "example/main.c"
"""A program that calls the model, in its own folder: a build of every *.c in the model's folder must not include it."""


def manifest(model: Model, texts: Mapping[str, str], facts: Mapping[str, Any]) -> str:
    """The text of MANIFEST.json: digests of all `texts`, then `facts` (options, certificates, errors, cost)."""
    data = {
        "schema": SCHEMA,
        "version": VERSION,
        "hysgen": version(),
        "model": model.name,
        "model_file": model_file(model),
        "files": {name: digest(texts[name].encode()) for name in sorted(texts)},
        **facts,
    }
    return json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def model_file(model: Model) -> str:
    """Name of the model file in the folder."""
    return f"{model.name}.json"


def c_files(texts: Mapping[str, str]) -> dict[str, str]:
    """The C sources and headers of the model among generated `texts`, without the example."""
    return {name: text for name, text in texts.items() if name.endswith((".c", ".h")) and "/" not in name}


@dataclass(frozen=True)
class Folder:
    """A generated folder: model, texts by file name, manifest `facts`, one message per file with another digest."""

    model: Model
    texts: Mapping[str, str]
    facts: Mapping[str, Any]
    altered: tuple[str, ...]


def read_folder(folder: Path) -> Folder:
    """Read a generated folder. Raises HysgenError if manifest, model or a listed file is missing or cannot be read."""
    facts = _read_manifest(folder / MANIFEST)
    texts: dict[str, str] = {}
    altered = []
    for name, expected in facts["files"].items():
        path = folder / name
        try:
            data = path.read_bytes()
            texts[name] = data.decode("utf-8")
        except (OSError, UnicodeDecodeError) as fault:
            raise HysgenError(f"{path}: cannot be read ({fault}); generate the folder again") from fault
        if digest(data) != expected:
            altered.append(f"{path}: is not what was generated (its digest differs from {MANIFEST})")
    texts[MANIFEST] = (folder / MANIFEST).read_text(encoding="utf-8")
    return Folder(load_model(folder / facts["model_file"]), texts, facts, tuple(altered))


def _read_manifest(path: Path) -> dict[str, Any]:
    try:
        facts = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as fault:
        raise HysgenError(f"{path}: is missing; this is not a folder that hysgen generate wrote") from fault
    except NotADirectoryError as fault:
        raise HysgenError(f"{path.parent}: is a file; give the folder that hysgen generate wrote") from fault
    except (OSError, ValueError) as fault:
        raise HysgenError(f"{path}: cannot be read ({fault}); generate the folder again") from fault
    if not isinstance(facts, dict) or facts.get("schema") != SCHEMA or facts.get("version") != VERSION:
        raise HysgenError(f"{path}: is not a manifest of version {VERSION}; generate the folder again")
    named = facts.get("files")
    plain = isinstance(named, dict) and all(Path(name).name == name or name == EXAMPLE for name in named)
    if not plain or facts.get("model_file") not in set(named or {}):
        raise HysgenError(f"{path}: names no files of a model; generate the folder again")
    return facts


def listed(path: Path) -> tuple[str, frozenset[str]]:
    """Model and files that a manifest names; "" and none where there is no manifest."""
    try:
        facts = json.loads(path.read_text(encoding="utf-8"))
        known = facts["schema"] == SCHEMA
        return (str(facts["model"]), frozenset(facts["files"])) if known else ("", frozenset())
    except (OSError, ValueError, LookupError, TypeError):
        return "", frozenset()


def require_model(path: Path, name: str) -> None:
    """Raise HysgenError if the manifest at `path` is of a model of another name: their files would mix."""
    before, _ = listed(path)
    if before not in ("", name):
        raise HysgenError(f"{path.parent}: holds the C of {before}, not of {name}; name another folder")


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


def _first_difference(old: bytes, new: bytes) -> int:
    """Number of the first different line, counted from 1."""
    mine, theirs = old.split(b"\n"), new.split(b"\n")
    pairs = enumerate(zip(mine, theirs, strict=False), start=1)
    return next((number for number, (a, b) in pairs if a != b), min(len(mine), len(theirs)) + 1)


def write(texts: Mapping[str, str], folder: Path) -> None:
    """Write the files into `folder`, the manifest last; an interrupted write leaves no partial file.

    Processes take turns. Raises HysgenError, with nothing written, if the folder holds the C of another model.
    """
    with only_writer(folder):
        for place in (name for name in texts if name.endswith(MANIFEST)):
            require_model(folder / place, json.loads(texts[place])["model"])
        for name in sorted(texts, key=lambda name: name.endswith(MANIFEST)):
            write_whole(folder / name, texts[name])


NAMES_HOLD = "names that end in _um hold um, in _V V"
"""What the identifiers of the C hold, which are the same for all quantities."""


def in_quantities(model: Model, path: str, text: str) -> str:
    """The text of a file in the model's quantities; in C, comments and strings. A line says what identifiers hold.

    The C of one structure is the same for all quantities but for its comments, so firmware that calls it is, too.
    """
    stated = model.quantities
    if not stated.other:
        return text
    if not path.endswith((".c", ".h")):
        return stated.text(text)
    text = re.sub(r'/\*.*?\*/|"[^"\n]*"', lambda part: stated.text(part[0]), text, flags=re.DOTALL)
    return re.sub(r"\A/\*(.*?)( ?\*/)", rf"/*\1\n * Here {stated.text(NAMES_HOLD)}.\2", text, count=1, flags=re.DOTALL)
