"""Checks that read generated C and do not run it: the wall of warnings, MISRA C:2012 by cppcheck's add-on.

The wall: the flags of gcc and clang under which generated C compiles, every warning an error.

The add-on checks most of the decidable rules. It reports rules by number, because their texts may not be copied. The
generated C follows every required rule, and every advisory rule except those of DEVIATIONS, which state the reason:
every finding is either a listed deviation or an error.
"""

import dataclasses
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from hysgen.codegen.manifest import c_files
from hysgen.errors import BuildError
from hysgen.machine.native import compiler_version


@contextmanager
def folder_of(texts: Mapping[str, str]) -> Iterator[Path]:
    """A folder with the C sources and headers among `texts`, gone afterwards."""
    with tempfile.TemporaryDirectory(prefix="hysgen-") as scratch:
        for file, text in c_files(texts).items():
            Path(scratch, file).write_text(text, encoding="utf-8", newline="\n")
        yield Path(scratch)


COMPILERS: Final = ("gcc", "clang")

BASIC: Final = ("-Wall", "-Wextra", "-Werror")
"""Warnings of the cross compilers, whose headers and versions differ."""

# fmt: off
COMMON: Final = (
    *BASIC, "-Wpedantic", "-Wconversion", "-Wsign-conversion", "-Wfloat-conversion", "-Wdouble-promotion",
    "-Wfloat-equal", "-Wshadow", "-Wundef", "-Wunused", "-Wunused-macros", "-Wuninitialized", "-Winit-self",
    "-Wcast-qual", "-Wcast-align", "-Wpointer-arith", "-Wstrict-prototypes", "-Wmissing-prototypes",
    "-Wmissing-declarations", "-Wold-style-definition", "-Wnested-externs", "-Wredundant-decls",
    "-Wbad-function-cast", "-Wwrite-strings", "-Wvla", "-Wformat=2", "-Wswitch-default", "-Wswitch-enum",
    "-Wnull-dereference", "-Wstrict-overflow=2", "-Wstrict-aliasing=2", "-Wdisabled-optimization", "-Winline",
)
GCC_ONLY: Final = (
    "-Wlogical-op", "-Wduplicated-cond", "-Wduplicated-branches", "-Wjump-misses-init", "-Wstack-usage=8192",
)
# Declarations after statements are C99; padding is no fault.
CLANG_ONLY: Final = ("-Weverything", "-Wno-declaration-after-statement", "-Wno-padded")
# fmt: on


def wall_flags(compiler: str, level: str = "-O2") -> tuple[str, ...]:
    """Flags of the warning wall for gcc or clang at one optimisation level."""
    return ("-std=c99", level, *COMMON, *(CLANG_ONLY if "clang" in compiler else GCC_ONLY))


@dataclass(frozen=True)
class Walled:
    """Result of one file under one compiler; complaints: its warning and error lines."""

    compiler: str
    file: str
    complaints: tuple[str, ...]


@dataclass(frozen=True)
class Wall:
    """Results of every file under every installed compiler.

    flags: of all compilers together. skipped: compilers that are not installed.
    """

    model: str
    flags: tuple[str, ...]
    compilers: tuple[str, ...]
    skipped: tuple[str, ...]
    files: tuple[Walled, ...]

    @property
    def clean(self) -> bool:
        """Whether files were compiled and no compiler warned."""
        return bool(self.files) and not any(walled.complaints for walled in self.files)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return dataclasses.asdict(self) | {"clean": self.clean}

    def lines(self) -> list[str]:
        """The report as text."""
        text = [f"{'; '.join(self.compilers)}: {len(self.flags)} flags, {len(self.files)} files compiled"]
        text += [f"NOT COMPILED: {reason}" for reason in self.skipped]
        text += [f"{walled.compiler}: {line}" for walled in self.files for line in walled.complaints]
        return [*text, f"{self.model}: {'no warning' if self.clean else 'WARNINGS'}"]


def wall(
    name: str,
    texts: Mapping[str, str],
    *,
    compilers: Sequence[str] = COMPILERS,
    progress: Callable[[float, str], None] | None = None,
) -> Wall:
    """Compile every C file of model `name` under the wall. Raises BuildError if no compiler is installed."""
    installed = [compiler for compiler in compilers if shutil.which(compiler)]
    if not installed:
        raise BuildError(f"none of {', '.join(compilers)} is installed; install one to check warnings with")
    skipped = tuple(f"{compiler}: not installed" for compiler in compilers if compiler not in installed)
    sources = sorted(file for file in c_files(texts) if file.endswith(".c"))
    runs = []
    with folder_of(texts) as scratch:
        for place, compiler in enumerate(installed):
            if progress is not None:
                progress(place / len(installed), f"warnings of {compiler}")
            runs += [_compile(compiler, file, scratch) for file in sources]
    flags = dict.fromkeys(flag for compiler in installed for flag in wall_flags(compiler))
    return Wall(name, tuple(flags), tuple(map(compiler_version, installed)), skipped, tuple(runs))


def _compile(compiler: str, file: str, folder: Path) -> Walled:
    call = [compiler, *wall_flags(compiler), "-c", "-o", "out.o", file]
    run = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)
    complaints = tuple(line for line in run.stderr.splitlines() if ": error:" in line or ": warning:" in line)
    if run.returncode != 0 and not complaints:
        complaints = (run.stderr.strip()[:200] or f"exit code {run.returncode}",)
    return Walled(compiler, file, complaints)


@dataclass(frozen=True)
class Deviation:
    """A rule that the generated C does not follow. about: the rule in own words. reason: for the deviation."""

    rule: str
    about: str
    reason: str


DEVIATIONS: Final = (
    Deviation(
        "8.9",
        "an object used in one function only is defined inside it",
        "<name>_params.h holds every number, so that identifying a model again changes that file and no other",
    ),
    Deviation(
        "10.5",
        "a value is not cast to an inappropriate kind of type",
        "0 or 1 from a comparison becomes a mask of bits: what limits an input without a branch",
    ),
    Deviation(
        "12.1",
        "precedence is made explicit by parentheses",
        "products in sums follow the equations; parentheses stand where the order of additions matters to the bits",
    ),
    Deviation(
        "15.5",
        "a function returns at its end only",
        "a learner or commit that has to stop early says so where it happens, instead of carrying a flag through",
    ),
    Deviation(
        "19.2",
        "unions are not used",
        "the bits of a float are read and written through a union in two functions: C defines it, without a library",
    ),
)

# fmt: off
ADVISORY: Final = frozenset((
    "2.3", "2.4", "2.5", "2.6", "2.7", "4.2", "5.9", "8.7", "8.9", "8.11", "8.13", "10.5", "11.4", "11.5", "12.1",
    "12.3", "12.4", "13.3", "13.4", "15.1", "15.4", "15.5", "17.5", "17.8", "18.4", "18.5", "19.2", "20.1", "20.5",
    "21.12",
))
# fmt: on
"""Advisory rules; all others are required or mandatory."""

_LIMITS: Final = {"CHAR_BIT": 8, "FLT_RADIX": 2, "FLT_MANT_DIG": 24, "FLT_MIN_EXP": -125, "FLT_MAX_EXP": 128}
CONFIGURATION: Final = (
    "--std=c99",
    "-D__GNUC__=12",
    "-D__FLT_EVAL_METHOD__=0",
    *(f"-D{macro}={value}" for macro, value in _LIMITS.items()),
)
"""As gcc sees the files: the other branches of the preprocessor differ in a pragma or an attribute only.

cppcheck reads no standard header, so the macros of limits.h and float.h stand here.
"""

_FINDING: Final = re.compile(r"^\[(?P<file>[^:\]]+):(?P<line>\d+)\].*\[misra-c2012-(?P<rule>[\d.]+)\]$")
_ADDONS: Final = (
    "/usr/lib/x86_64-linux-gnu/cppcheck/addons",
    "/usr/lib/aarch64-linux-gnu/cppcheck/addons",
    "/usr/share/cppcheck/addons",
    "/usr/local/share/Cppcheck/addons",
)


@dataclass(frozen=True)
class Finding:
    """A place where a rule is not followed."""

    rule: str
    file: str
    line: int

    def __str__(self) -> str:
        kind = "advisory" if self.rule in ADVISORY else "required"
        return f"{self.file}:{self.line}: rule {self.rule} ({kind})"


@dataclass(frozen=True)
class Misra:
    """findings: of rules without a deviation; deviating: number of findings per rule with one."""

    model: str
    tool: str
    findings: tuple[Finding, ...]
    deviating: Mapping[str, int]

    @property
    def clean(self) -> bool:
        """Nothing but listed deviations."""
        return not self.findings

    @property
    def required(self) -> int:
        """Findings of required and mandatory rules, deviations or not."""
        listed = sum(count for rule, count in self.deviating.items() if rule not in ADVISORY)
        return listed + sum(finding.rule not in ADVISORY for finding in self.findings)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        reasons = {deviation.rule: dataclasses.asdict(deviation) for deviation in DEVIATIONS}
        told = [reasons[rule] | {"findings": count} for rule, count in sorted(self.deviating.items())]
        findings = [dataclasses.asdict(finding) for finding in self.findings]
        return {
            "model": self.model,
            "tool": self.tool,
            "required": self.required,
            "findings": findings,
            "deviations": told,
        }

    def lines(self) -> list[str]:
        """The report as text."""
        text = [f"{self.tool}, MISRA C:2012 add-on"]
        for deviation in DEVIATIONS:
            count = self.deviating.get(deviation.rule, 0)
            text.append(
                f"deviation {deviation.rule:>5} (advisory, {count:>4} x): {deviation.about}. {deviation.reason}."
            )
        text += [f"NOT ALLOWED: {finding}" for finding in self.findings]
        verdict = "listed deviations only" if self.clean else "FINDINGS"
        return [*text, f"{self.model}: {self.required} findings of required rules; {verdict}"]


def misra(name: str, texts: Mapping[str, str], *, progress: Callable[[float, str], None] | None = None) -> Misra:
    """Check every C file of model `name`. Raises BuildError if cppcheck or its add-on is not installed, or fails."""
    addon = _addon()
    sources = sorted(file for file in c_files(texts) if file.endswith(".c"))
    findings: list[Finding] = []
    with folder_of(texts) as scratch:
        for place, source in enumerate(sources):
            if progress is not None:
                progress(place / len(sources), f"MISRA rules in {source}")
            _run(["cppcheck", "--dump", *CONFIGURATION, "--quiet", source], scratch)
            output = _run([sys.executable, str(addon), "--no-summary", f"{source}.dump"], scratch)
            findings += _findings(output)
    listed = {deviation.rule for deviation in DEVIATIONS}
    version = _run(["cppcheck", "--version"], Path()).strip()
    # A header is read with each source that includes it; what it holds is told once.
    unique = list(dict.fromkeys(findings))
    rest = tuple(finding for finding in unique if finding.rule not in listed)
    return Misra(name, version, rest, dict(Counter(finding.rule for finding in unique if finding.rule in listed)))


def _findings(output: str) -> list[Finding]:
    """Each line that names a rule. Raises BuildError if there is a complaint of another kind."""
    matches = [_FINDING.match(line) for line in output.splitlines()]
    for line, match in zip(output.splitlines(), matches, strict=True):
        if match is None and not line.startswith("Checking ") and line.strip():
            raise BuildError(f"cppcheck's MISRA add-on: {line}")
    return [Finding(match["rule"], Path(match["file"]).name, int(match["line"])) for match in matches if match]


def _addon() -> Path:
    if shutil.which("cppcheck") is None:
        raise BuildError("cppcheck: not installed; apt-get install cppcheck")
    for folder in _ADDONS:
        if Path(folder, "misra.py").exists():
            return Path(folder, "misra.py")
    raise BuildError(f"cppcheck: its add-on misra.py is in none of {', '.join(_ADDONS)}")


def _run(call: Sequence[str], folder: Path) -> str:
    """Standard output and error of a command. Raises BuildError if the command fails."""
    run = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)
    # The add-on ends with 1 where it found something; what it cannot read it says in a traceback.
    if run.returncode not in (0, 1) or "Traceback" in run.stderr:
        raise BuildError(f"{call[0]}: {(run.stderr.strip().splitlines() or ['no message'])[-1]}")
    return run.stdout + run.stderr
