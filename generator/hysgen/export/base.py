"""An export: the model as one component with a mode, the form that every export presents to its caller, and the
variables of its templates; files, build, the ways to run it; the samples of a run, and calls of the tools."""

import shlex
import shutil
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.codegen import Options
from hysgen.codegen.render import render
from hysgen.errors import BuildError
from hysgen.float32.coefficients import coefficients
from hysgen.machine.files import version
from hysgen.machine.native import default_toolchain
from hysgen.model.model import Model


@dataclass(frozen=True)
class Mode:
    """A mode of the component: its number in C, arguments of a step, and result."""

    number: int
    name: str
    arguments: str
    result: str
    about: str


MODES: Final = (
    Mode(0, "predict", "y(k) [um], u(k) [V]", "y(k+1) [um]", "one step ahead of a measured displacement"),
    Mode(1, "simulate", "u(k) [V]", "y(k+1) [um]", "free run"),
    Mode(2, "inverse", "y(k) [um], y(k+1) [um]", "u(k) [V]", "the voltage that takes y(k) to y(k+1)"),
    Mode(3, "learn", "y(k) [um], u(k) [V], commit", "y(k+1) [um]", "learn from y(k), u(k), commit on demand, predict"),
)


def modes_of(model: Model, options: Options) -> tuple[Mode, ...]:
    """The modes that the generated C of `model` has."""
    left_out = ([] if options.inverse else ["inverse"]) + ([] if model.learner else ["learn"])
    return tuple(mode for mode in MODES if mode.name not in left_out)


def component_facts(model: Model, options: Options) -> dict[str, Any]:
    """Variables of the templates in templates/export/."""
    numbers = coefficients(model)
    modes = modes_of(model, options)
    middle_V = 0.5 * (float(numbers.u_min_V) + float(numbers.u_max_V))
    upper = model.name.upper()
    return {
        "name": model.name,
        "NAME": upper,
        "version": version(),
        "Ts_us": f"{1e6 * model.Ts_s:.9g}",
        "Ts_text": repr(model.Ts_s),
        "stop_text": repr(1000 * model.Ts_s),
        "modes": modes,
        "all_modes": [mode.name for mode in MODES],
        "known": " || ".join(f"(mode == {upper}_COMPONENT_{mode.name.upper()})" for mode in modes),
        "inverse": options.inverse,
        "learns": model.learner is not None,
        "channels": model.channels,
        "u_min": exact(numbers.u_min_V),
        "u_max": exact(numbers.u_max_V),
        "y_min": exact(numbers.y_min_um),
        "y_max": exact(numbers.y_max_um),
        "reference_min": exact(numbers.reference_min_um),
        "reference_max": exact(numbers.reference_max_um),
        "rest_um": exact(numbers.rest_um),
        "middle_V": exact(np.float32(middle_V)),
        "quarter_V": exact(np.float32(0.25 * (float(numbers.u_max_V) - float(numbers.u_min_V)))),
    }


def exact(value: np.float32) -> str:
    """`value` with 9 significant digits and a decimal point: reads back to the same float32.

    >>> exact(np.float32(22))
    '22.0'
    """
    text = f"{float(value):.9g}"
    return text if "." in text or "e" in text else f"{text}.0"


def component_texts(facts: Mapping[str, Any]) -> dict[str, str]:
    """The component in C by file name."""
    return {f"{facts['name']}_component.{end}": render(f"export/component.{end}.j2", facts) for end in "hc"}


Words = NDArray[np.uint32]


@dataclass(frozen=True)
class Samples:
    """Inputs of one mode. rows: (n, 3 + channels) bits of y_um, input, auxiliary channels, and the commit flag."""

    mode: Mode
    y0_um: np.float32
    u0_V: np.float32
    rows: Words

    def column(self, place: int) -> NDArray[np.float32]:
        """One column as contiguous float32."""
        return np.ascontiguousarray(self.rows[:, place]).view(np.float32)

    @property
    def commit(self) -> Words:
        return np.ascontiguousarray(self.rows[:, -1])

    @property
    def aux(self) -> NDArray[np.float32]:
        """(n, channels) auxiliary channels."""
        return np.ascontiguousarray(self.rows[:, 2:-1]).view(np.float32)

    @property
    def start(self) -> list[str]:
        """Mode, first displacement [um] and first voltage [V] as arguments of a program."""
        return [str(self.mode.number), repr(float(self.y0_um)), repr(float(self.u0_V))]


@dataclass(frozen=True)
class Draft:
    """A folder before its texts. generated: the C of the model; facts: variables of the templates."""

    model: Model
    options: Options
    generated: Mapping[str, str]
    facts: Mapping[str, Any]

    def rendered(self, files: Mapping[str, str]) -> dict[str, str]:
        """Text by path; files: template by path, both as in `Export.files`."""
        return {path.format(name=self.model.name): self.text(template) for path, template in files.items()}

    def text(self, template: str) -> str:
        """A template of templates/export/ by its name without .j2, or with line ends the template itself."""
        return render(template if "\n" in template else f"export/{template}.j2", self.facts)

    def readme(self, body: str) -> str:
        """The README: a head that all exports share, and the template `body` below it."""
        return replace(self, facts={**self.facts, "body": self.text(body)}).text("README.md")


@dataclass(frozen=True)
class Written:
    """A folder with its texts. texts: by path in the folder. given: values of the export's own options, "" for none."""

    draft: Draft
    folder: Path
    texts: Mapping[str, str]
    given: Mapping[str, str]


@dataclass(frozen=True)
class Option:
    """An option that one export has: `--NAME METAVAR`, "" where it is not given."""

    name: str
    metavar: str
    help: str


Runner = Callable[[Model, Path, Samples], Words]
"""(model, folder, samples) -> (n, 2) bits of results and status words. Raises BuildError without the tools."""


def _component(draft: Draft) -> Mapping[str, str]:
    return component_texts(draft.facts)


@dataclass(frozen=True)
class Export:
    """A folder for another tool. title: its name in the README.

    files: path in the folder, {name} standing for the model's name -> template (`Draft.text`). readme: template of the
    README below its head; "" where `finish` writes it. ways: name of a way to run the folder -> the function that runs
    it; an export without ways is not compared. facts: further variables of the templates. sources: the C beside the
    model's, by default the component. options: those of this export alone, under `options_title` in the help. finish:
    writes the files that are built from the texts, and returns their paths in the folder; raises BuildError.
    """

    name: str
    title: str
    files: Mapping[str, str]
    readme: str = ""
    ways: Mapping[str, Runner] = field(default_factory=dict)
    facts: Callable[[Draft], Mapping[str, Any]] = lambda draft: {}
    sources: Callable[[Draft], Mapping[str, str]] = _component
    options: tuple[Option, ...] = ()
    options_title: str = ""
    finish: Callable[[Written], Sequence[str]] = lambda written: ()


def make(folder: Path, goal: str) -> None:
    """Build `goal` by the Makefile of the folder. Raises BuildError with the first error message."""
    command = ["make", "-C", str(folder), goal, f"CC={shlex.join(default_toolchain().call)}"]
    try:
        run = subprocess.run(command, capture_output=True, text=True, check=False)
    except FileNotFoundError as fault:
        raise BuildError("make is not installed; install it, or build the folder by other means") from fault
    if run.returncode != 0:
        raise BuildError(f"{folder}: make {goal}: {(run.stderr.strip().splitlines() or ['no message'])[0]}")


def output_of(call: list[str], folder: Path, data: bytes = b"") -> bytes:
    """Standard output of a command. Raises BuildError if the tool is missing or fails."""
    if shutil.which(call[0]) is None and not Path(call[0]).exists():
        raise BuildError(f"{call[0]} is not installed: this target was not compared")
    done = subprocess.run(call, cwd=folder, input=data, capture_output=True, check=False)
    if done.returncode != 0:
        message = (done.stderr or done.stdout).decode(errors="replace").strip().splitlines()
        raise BuildError(f"{' '.join(call[:3])}: {(message or [f'exit code {done.returncode}'])[-1]}")
    return done.stdout


def results(data: bytes) -> Words:
    """(n, 2) result and status of rows of result, status, answer."""
    return np.frombuffer(data, np.uint32).reshape(-1, 3)[:, :2]
