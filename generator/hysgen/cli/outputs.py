"""Files that a verb is about to write: checked before the computation, so that no file of the user is lost.

Refused are an output that is an input of the same call, two outputs of one name, an output that exists and was not
written by hysgen (unless --force), a suffix of another format, and a folder that cannot be written.
"""

import argparse
import os
import stat
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from hysgen.errors import HysgenError
from hysgen.machine.files import is_special

HEAD = 16_384
"""Bytes at the beginning of a file in which hysgen names itself."""

MARKS = (b"hysgen", b"HYSI")
"""Words of which every file that hysgen writes has one in its head; the second begins a parameter image."""

INPUTS = ("records", "holdout", "model", "old", "new", "flashed", "record", "files", "learn")
"""Names of the arguments that are files to read."""

PAGES, PICTURES = (".html", ".htm"), (".png",)


@dataclass(frozen=True)
class Output:
    """An option that names an output. suffixes: its formats, any if empty; folder: whether it is a folder."""

    option: str
    suffixes: tuple[str, ...] = ()
    folder: bool = False


COMMON: Mapping[str, Output] = {
    "json": Output("--json"),
    "report": Output("--report", PAGES),
    "plot": Output("--plot", PICTURES),
    "plots": Output("--plots", folder=True),
}
"""Outputs by the name of their argument, of every verb that has it."""


def check_outputs(arguments: argparse.Namespace, own: Mapping[str, Output]) -> None:
    """Check the outputs that a call names. own: those of the verb beside COMMON. Raises HysgenError."""
    inputs = {path.resolve(): path for path in _inputs(arguments)}
    taken: dict[Path, str] = {}
    for name, output in {**COMMON, **own}.items():
        text = getattr(arguments, name, None)
        if (
            text is None
            or (name == "json" and text == "-")
            or (name == "output" and getattr(arguments, "check", False))
        ):
            continue
        if str(text) == "-":
            raise HysgenError(f"{output.option} -: is written to a file only; name one, and --json - for the result")
        path = Path(text)
        if path.resolve() in inputs:
            raise HysgenError(f"{output.option} {text}: is an input of this call; choose another name, nothing is lost")
        if path.resolve() in taken:
            raise HysgenError(
                f"{output.option} {text}: is the file of {taken[path.resolve()]} too; choose another name"
            )
        taken[path.resolve()] = output.option
        if output.suffixes and path.suffix.lower() not in output.suffixes:
            raise HysgenError(f"{output.option} {text}: writes {output.suffixes[0]}; give the name that suffix")
        if output.folder:
            if path.exists() and not path.is_dir():
                raise HysgenError(f"{output.option} {text}: is a file; name a folder")
            check_writable(path)
        else:
            check_file(path, output.option, force=getattr(arguments, "force", False))


def check_file(path: Path, option: str, force: bool = False) -> None:
    """Raise HysgenError if `path` cannot be written, or holds what hysgen did not write and `force` is not set."""
    if path.is_dir():
        raise HysgenError(f"{option} {path}: is a folder; name a file in it")
    if is_special(path):
        check_device(path, option)
        return
    if path.exists() and not force and not written_by_hysgen(path):
        raise HysgenError(f"{option} {path}: exists, and hysgen did not write it; choose another name, or add --force")
    check_writable(path.parent)


def check_device(path: Path, option: str) -> None:
    """Try to write nothing to a device: one that is full says so then. Raises HysgenError, for a disk too.

    A pipe is not opened: its reader would see the end of the file.
    """
    mode = path.stat().st_mode
    if stat.S_ISBLK(mode):
        raise HysgenError(f"{option} {path}: is a disk; name a file")
    if not stat.S_ISCHR(mode):
        return
    try:
        device = os.open(path, os.O_WRONLY | getattr(os, "O_NOCTTY", 0))
        try:
            os.write(device, b"")
        finally:
            os.close(device)
    except OSError as fault:
        raise HysgenError(f"{option} {path}: cannot be written ({fault.strerror}); choose another place") from fault


def check_files(folder: Path, names: Iterable[str], option: str, force: bool) -> None:
    """`check_file` for files of these names in a folder; what its manifest lists was written by hysgen."""
    from hysgen.codegen.manifest import MANIFEST, listed  # imports NumPy, which a refusal does without

    _, ours = listed(folder / MANIFEST)
    for name in names:
        check_file(folder / name, option, force or name in ours)


def written_by_hysgen(path: Path) -> bool:
    """Whether a file has the mark of hysgen's own files. False for records: they belong to the user."""
    try:
        with path.open("rb") as stream:
            head = stream.read(HEAD)
    except OSError:
        return False
    return not head or any(mark in head for mark in MARKS)


def check_writable(folder: Path) -> None:
    """Try to write a file in a folder, or in the nearest folder above it that exists. Raises HysgenError."""
    existing = folder
    while not existing.exists() and existing != existing.parent:
        existing = existing.parent
    if not existing.is_dir():
        raise HysgenError(f"{folder}: cannot be written ({existing} is no folder); choose another folder")
    try:
        with tempfile.TemporaryFile(dir=existing) as trial:
            trial.write(b"\0")
            trial.flush()
            os.fsync(trial.fileno())
    except OSError as fault:
        raise HysgenError(f"{folder}: cannot be written ({fault.strerror}); choose another folder") from fault


def _inputs(arguments: argparse.Namespace) -> Iterator[Path]:
    for name in INPUTS:
        value = getattr(arguments, name, None)
        for text in value if isinstance(value, list) else [value]:
            if isinstance(text, str) and text != "-":
                yield Path(text)
