"""The output that README and tutorial show is what their commands print."""

from __future__ import annotations

import difflib
import re
import shlex
from pathlib import Path

import pytest

from hysgen.cli import main
from hysgen.record.bundled import bundled_csv

ROOT = Path(__file__).resolve().parents[1]
BLOCK = re.compile(r"^```(python|)\n(.*?)^```", re.DOTALL | re.MULTILINE)
NUMBER = re.compile(r"\d+\.\d+(?:e[+-]\d+)?")


def plain(line: str) -> str:
    """The line without what the machine decides: widths of columns, times, compilers and their number."""
    line = re.sub(r"\b[\d.]+ s\b|^builds: .*|(?<=on this machine) \(.*?\)+(?=;)", "#", " ".join(line.split()))
    return re.sub(r"(?<=~)(\d+) [\d.]+$", r"\1 #", re.sub(r" \d+ equal$", " # equal", line))


def same(shown: str, printed: str) -> bool:
    """Equal but for the last digit of numbers with a point, which another processor's LAPACK may round otherwise."""
    a, b = plain(shown), plain(printed)
    if NUMBER.sub("#", a) != NUMBER.sub("#", b):
        return False
    numbers = zip(NUMBER.findall(a), NUMBER.findall(b), strict=True)
    return all(abs(float(x) - float(y)) <= 1.01 * last_digit(x) for x, y in numbers)


def last_digit(number: str) -> float:
    """What one in the last digit of a number with a point is worth."""
    mantissa, _, exponent = number.partition("e")
    return float(10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2])))


def closest(line: str, printed: list[str], first: int) -> int:
    """Index, not before `first`, of the printed line that is most like a shown one."""
    likeness = [difflib.SequenceMatcher(None, plain(line), plain(other)).ratio() for other in printed[first:]]
    return first + max(range(len(likeness)), key=likeness.__getitem__)


def as_printed(shown: str, printed: list[str]) -> str:
    """The shown lines as they should be: each run of lines between two "..." is a run of printed lines, the first from
    the beginning, the last to the end."""
    runs, after = re.split(r"^\.\.\.\n", shown, flags=re.MULTILINE), 0
    for index, run in enumerate(runs):
        lines = run.strip("\n").split("\n")
        if lines == [""]:
            continue
        start = closest(lines[0], printed, after) if index else 0
        after = closest(lines[-1], printed, start) + 1 if index < len(runs) - 1 else len(printed)
        right = printed[start:after]
        if len(right) != len(lines) or not all(map(same, lines, right)):
            runs[index] = run.replace("\n".join(lines), "\n".join(right))
    return "...\n".join(runs)


@pytest.mark.golden
@pytest.mark.proof
def test_each_block_of_output_is_what_its_command_prints(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], request: pytest.FixtureRequest
) -> None:
    """Update with `pytest tests/test_docs_output.py --update-golden` and look at the diff."""
    monkeypatch.chdir(tmp_path)
    Path("record.csv").write_text(bundled_csv())
    diagnosis: dict[str, list[str]] = {}
    stale, commands = [], 0
    for page in (ROOT / "README.md", ROOT / "docs" / "tutorial.md"):
        text = right = page.read_text()
        for language, block in BLOCK.findall(text):
            if language:
                exec(block, {})
            for command, shown in re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", block, re.MULTILINE):
                words = shlex.split(command.replace("hysgen-demo/", ""))
                if words[0] == "head":
                    printed = bundled_csv().split("\n")[: int(words[1][1:])]
                elif words[0] == "hysgen":
                    if (printed := diagnosis.get(shlex.join(words), [])) == []:
                        assert main(["-q", *words[1:]]) == 0, command
                        printed = capsys.readouterr().out.rstrip("\n").split("\n")
                    if words[1] == "diagnose":  # two minutes; both pages show the same
                        diagnosis[shlex.join(words)] = printed
                else:
                    assert (command, shown) == ("make run", "")
                    continue
                commands += 1
                if shown and (true := as_printed(shown, printed)) != shown:
                    stale += difflib.unified_diff(shown.split("\n"), true.split("\n"), page.name, command, n=0)
                    right = right.replace(f"$ {command}\n{shown}", f"$ {command}\n{true}")
        if request.config.getoption("--update-golden"):
            page.write_text(right)
            stale = []
    assert commands > 9
    assert stale == [], "\n".join(stale)


def test_a_line_that_is_not_printed_would_be_seen() -> None:
    printed = ["a 1.00", "b", "c", "d", "took 1.25 s"]
    shown = "a  1.01\n...\nc\nd\ntook 3 s\n"
    assert as_printed(shown, printed) == shown
    assert as_printed("a 1.02\n...\nc\ntook 3 s\n", printed) == "a 1.00\n...\nc\nd\ntook 1.25 s\n"
    assert not same("1.2e-03", "1.4e-03")
    assert not same("12 more", "13 more")
