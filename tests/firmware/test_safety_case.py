"""The safety case of docs/firmware.md: each requirement names the code that meets it and the tests that show it."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "firmware.md"


def marked(*folders: str) -> dict[str, list[str]]:
    """Names of the files that bear each mark such as [S1], sorted."""
    found: dict[str, list[str]] = {}
    paths = [path for folder in folders for path in (ROOT / folder).glob("*.*") if path != Path(__file__)]
    for path in sorted(paths, key=lambda path: path.name):
        for mark in set(re.findall(r"\[(S\d+)\]", path.read_text(encoding="utf-8"))):
            found.setdefault(mark, []).append(path.name)
    return found


def test_every_requirement_is_met_in_code_and_shown_by_tests_as_the_table_says() -> None:
    rows = re.findall(r"^\| (S\d+) \| [^|]+ \| ([^|]+) \| ([^|]+) \|$", PAGE.read_text(encoding="utf-8"), re.M)
    assert [name for name, *_ in rows] == [f"S{i}" for i in range(1, len(rows) + 1)]
    assert len(rows) == 14
    code, tests = marked("firmware/controller", "firmware/board/c6748"), marked("tests/firmware")
    assert {name: met.split(", ") for name, met, _ in rows} == code
    assert {name: shown.split(", ") for name, _, shown in rows} == tests
