"""Show of generated C, without running it on the target, what can be shown: warnings, MISRA rules, sanitizers, proofs.

warnings: gcc and clang under one wall of flags. misra: cppcheck's add-on; every finding of a required rule is red.
sanitize: the C runs under gcc's sanitizers on every kind of input. eva: Frama-C proves, for every input and every state
inside the certified box, that nothing fails, that no float becomes infinite or NaN, and that the state is then inside
the box again. docs/proof.md says what is assumed.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, Protocol

from hysgen.checking.proof.eva.report import prove
from hysgen.checking.proof.misra import misra
from hysgen.checking.proof.sanitize import sanitize
from hysgen.checking.proof.warnings import wall
from hysgen.cli.console import Console
from hysgen.codegen.manifest import Folder, read_folder
from hysgen.errors import HysgenError


class Answer(Protocol):
    """What every check reports."""

    def lines(self) -> list[str]: ...

    def to_json(self) -> dict[str, Any]: ...


Checked = tuple[Answer, bool]


def _warnings(folder: Folder, arguments: argparse.Namespace, console: Console) -> Checked:
    found = wall(folder.model.name, folder.texts, progress=console.progress)
    return found, found.clean


def _misra(folder: Folder, arguments: argparse.Namespace, console: Console) -> Checked:
    found = misra(folder.model.name, folder.texts, progress=console.progress)
    return found, found.clean


def _sanitize(folder: Folder, arguments: argparse.Namespace, console: Console) -> Checked:
    found = sanitize(folder.model, folder.texts, samples=arguments.samples, progress=console.progress)
    return found, found.equal


def _eva(folder: Folder, arguments: argparse.Namespace, console: Console) -> Checked:
    calls = [function for function in arguments.calls.split(",") if function]
    found = prove(folder.model, folder.texts, calls=calls, take_out=arguments.take_out, progress=console.progress)
    return found, found.holds


CHECKS: Final[dict[str, Callable[[Folder, argparse.Namespace, Console], Checked]]] = {
    "warnings": _warnings,
    "misra": _misra,
    "sanitize": _sanitize,
    "eva": _eva,
}


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", metavar="DIR", help="folder that `hysgen generate` wrote")
    parser.add_argument(
        "--only", default=",".join(CHECKS), metavar="CHECKS", help="some of them, with commas (default %(default)s)"
    )
    parser.add_argument("--samples", type=int, default=100_000, help="sanitize: of each function (default %(default)s)")
    parser.add_argument(
        "--calls", default="", metavar="CALLS", help="eva: functions to prove, with commas (default all)"
    )
    parser.add_argument(
        "--take-out", action="store_true", help="eva: also without each guard in turn, to see that it is missed"
    )


def run(arguments: argparse.Namespace, console: Console) -> int:
    chosen = arguments.only.split(",")
    for name in chosen:
        if name not in CHECKS:
            raise HysgenError(f"--only {name}: is not a check; choose among {', '.join(CHECKS)}")
    folder = read_folder(Path(arguments.folder))
    result: dict[str, Any] = {"model": folder.model.name, "altered": list(folder.altered)}
    for line in folder.altered:
        console.warn(line)
    clean = True
    for name in chosen:
        answer, holds = CHECKS[name](folder, arguments, console)
        console.say(f"{name}: " + "\n".join(answer.lines()) + "\n")
        result[name] = answer.to_json()
        clean = clean and holds
    console.write_json(result | {"clean": clean})
    return 0 if clean else 1
