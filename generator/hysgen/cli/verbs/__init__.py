"""The verbs of the command line, and the files that a verb is about to write.

A module is imported when one of its verbs is used: some import most of SciPy.

Outputs are checked before the computation, so that no file of the user is lost. Refused are an output that is an input
of the same call, two outputs of one name, an output that exists and was not written by hysgen (unless --force), a
suffix of another format, and a folder that cannot be written.
"""

import argparse
import importlib
import os
import stat
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from hysgen.cli.console import Console
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


GROUPS: Mapping[str, Mapping[str, tuple[str, str]]] = {
    "look at a record, fit a model": {
        "inspect": ("inspect", "what a file holds: channels, units, rate, noise, excitation, which causes would show"),
        "diagnose": ("diagnose", "what the simulation gets wrong, the causes, an extended model and its gain"),
        "experiment": ("diagnose", "the voltage to play next, for what a record cannot tell"),
        "fit": ("fit", "fit a model to one or several records"),
        "score": ("fit", "errors of a model: one step, against the horizon, in free run"),
        "compare": ("fit", "several models on the same records: the errors of each, the best"),
        "describe": ("fit", "a model as a dynamic system: time constant, gain, loop, certificates"),
    },
    "from a trajectory to a voltage": {
        "simulate": ("waveform", "the displacement of a model under the voltages of a file"),
        "waveform": ("waveform", "the voltage that takes the stage along a displacement, inside its limits"),
        "loop": ("waveform", "a feedback loop around the inverse of a model, with its certificate"),
    },
    "from the model to C": {
        "generate": ("generate", "the C of a model"),
        "export": ("generate", "the model for Simulink, FMI, A2L tools, CMake, any C program, a Cortex-M"),
        "verify": ("verify", "compare generated C with its reference, bit for bit"),
        "prove": ("verify", "warnings, MISRA rules, sanitizers, proofs of generated C"),
        "cost": ("generate", "operations, cycles and bytes of generated C"),
    },
    "later": {
        "refit": ("refit", "identify a model again from a new record: same structure, new numbers"),
        "diff": ("refit", "what changed from one model to another"),
        "image": ("firmware", "a model's numbers as a parameter image for running firmware"),
        "firmware": ("firmware", "the files that the firmware needs of a model, and the cost of its image"),
        "schema": ("inspect", "the JSON Schema of the result of a verb, of a model file, of a manifest"),
        "link": ("firmware", "commands to running firmware: state, start, stop, reference, parameter images"),
    },
    "an example": {
        "demo": ("demo", "the whole way on the bundled record"),
    },
}
"""Module and summary of each verb, by group, in the order of the work and of `hysgen --help`."""

MODULES = {name: module for verbs in GROUPS.values() for name, (module, _) in verbs.items()}
"""Module by verb."""

NAMES = tuple(MODULES)


@dataclass(frozen=True)
class Verb:
    """help: text of `hysgen VERB --help`; run: does the work, returns the exit code; outputs: options that name files
    to write, by argument, beside those of `outputs.COMMON`; examples: command lines, shown below the options."""

    help: str
    arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace, Console], int]
    outputs: Mapping[str, Output] = field(default_factory=dict)
    examples: tuple[str, ...] = ()


@dataclass(frozen=True)
class Program:
    """A command with verbs: `hysgen`, or one beside it that shares its manners.

    groups: as GROUPS. verb: the verb of a name. first: commands to begin with, each with what it does; below: text at
    the end of the overview.
    """

    name: str
    description: str
    groups: Mapping[str, Mapping[str, tuple[str, str]]]
    verb: Callable[[str], Verb]
    first: Mapping[str, str] = field(default_factory=dict)
    below: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        """Every verb, in the order of the overview."""
        return tuple(name for verbs in self.groups.values() for name in verbs)


def verb(name: str) -> Verb:
    """The verb of this name; imports its module."""
    chosen: Verb = importlib.import_module(f"{__name__}.{MODULES[name]}").VERBS[name]
    return chosen
