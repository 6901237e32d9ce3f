"""The checks of generated C by name: warnings, MISRA rules, sanitizers, proofs by Frama-C (docs/proof.md).

`sanitize`: the C is compiled with gcc's sanitizers, which stop the program at the first fault. It runs the self-test
and the samples of `hysgen verify`: random, smooth, edge values and arbitrary bit patterns, with NaN, infinities and
denormal numbers among them; its bits are compared as well. A run shows that no fault occurred; `proof.eva` proves that
none can occur.
"""

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Protocol

from hysgen.checking.proof.emulated import EmulatedReport, EmulationSettings, Platform, equality
from hysgen.checking.proof.eva import prove as prove_by_eva
from hysgen.checking.proof.static import misra, wall
from hysgen.checking.proof.translation import translation
from hysgen.display import Displayed, Summary
from hysgen.errors import HysgenError
from hysgen.model.model import Model

SANITIZERS: Final = (
    "-g",
    "-fsanitize=undefined,address,float-divide-by-zero,float-cast-overflow,bounds-strict",
    "-fno-sanitize-recover=all",
    "-fno-omit-frame-pointer",
)

SANITIZED: Final = Platform(
    "sanitizers", "gcc", "", "<" if sys.byteorder == "little" else ">", ("gcc", "libasan8", "libubsan1"), SANITIZERS
)


def sanitize(
    model: Model,
    texts: Mapping[str, str],
    *,
    samples: int = 100_000,
    seed: int = 1,
    progress: Callable[[float, str], None] | None = None,
) -> EmulatedReport:
    """Run the C under gcc's sanitizers and compare its bits; samples: per function.

    Raises BuildError with the sanitizer's first line if it stops the program, or if gcc or its libraries are missing.
    """
    flags = ("-O1", "-ffp-contract=off")
    return equality(model, texts, EmulationSettings(samples, [SANITIZED], flags, seed), progress)


Progress = Callable[[float, str], None]


class Answer(Protocol):
    """The result of a check, as text and as JSON."""

    def lines(self) -> Sequence[str]: ...

    def to_json(self) -> dict[str, Any]: ...


@dataclass(frozen=True)
class CheckSettings:
    """samples: of the sanitizers, of each function. calls: functions that are proved (equal, eva), all if empty."""

    samples: int = 100_000
    calls: tuple[str, ...] = ()


@dataclass(frozen=True)
class Checked:
    """The answer of one check, and whether it holds."""

    answer: Answer
    holds: bool


@dataclass(frozen=True, eq=False, repr=False)
class Proof(Displayed):
    """The answers of several checks of the C of a model, by name."""

    model: str
    checks: Mapping[str, Checked]

    @property
    def clean(self) -> bool:
        """Whether every check holds."""
        return all(check.holds for check in self.checks.values())

    def summary(self) -> Summary:
        rows = [[name, "holds" if check.holds else "DOES NOT HOLD"] for name, check in self.checks.items()]
        notes = [line for check in self.checks.values() for line in check.answer.lines()]
        return Summary(f"Checks of the C of model {self.model}", ["check", ""], rows, notes)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        answers = {name: check.answer.to_json() for name, check in self.checks.items()}
        return {"model": self.model, **answers, "clean": self.clean}


def _warnings(model: Model, texts: Mapping[str, str], settings: CheckSettings, progress: Progress) -> Checked:
    report = wall(model.name, texts, progress=progress)
    return Checked(report, report.clean)


def _misra(model: Model, texts: Mapping[str, str], settings: CheckSettings, progress: Progress) -> Checked:
    report = misra(model.name, texts, progress=progress)
    return Checked(report, report.clean)


def _sanitize(model: Model, texts: Mapping[str, str], settings: CheckSettings, progress: Progress) -> Checked:
    report = sanitize(model, texts, samples=settings.samples, progress=progress)
    return Checked(report, report.equal)


def _equal(model: Model, texts: Mapping[str, str], settings: CheckSettings, progress: Progress) -> Checked:
    report = translation(model, texts, calls=settings.calls, progress=progress)
    return Checked(report, report.equal)


def _eva(model: Model, texts: Mapping[str, str], settings: CheckSettings, progress: Progress) -> Checked:
    report = prove_by_eva(model, texts, calls=settings.calls, progress=progress)
    return Checked(report, report.holds)


CHECKS: Final[Mapping[str, Callable[[Model, Mapping[str, str], CheckSettings, Progress], Checked]]] = {
    "warnings": _warnings,
    "misra": _misra,
    "sanitize": _sanitize,
    "equal": _equal,
    "eva": _eva,
}


def known_checks(names: Sequence[str]) -> list[str]:
    """The names as a list. Raises HysgenError for one that is no check."""
    for name in names:
        if name not in CHECKS:
            raise HysgenError(f"--only {name}: is not a check; choose among {', '.join(CHECKS)}")
    return list(names)
