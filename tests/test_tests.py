"""The tests themselves: a test file is imported by pytest alone."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

TESTS = Path(__file__).parent


def imported_tests(source: str) -> Iterator[str]:
    """Every import of a test module in a Python source, as written there."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import | ast.ImportFrom):
            module = (node.module or "") if isinstance(node, ast.ImportFrom) else ""
            parts = [part for name in (module, *(alias.name for alias in node.names)) for part in name.split(".")]
            if any(part.startswith("test_") for part in parts):
                yield ast.unparse(node)


def test_no_test_file_imports_another() -> None:
    found = {
        str(path.relative_to(TESTS)): found
        for path in sorted(TESTS.rglob("*.py"))
        if (found := list(imported_tests(path.read_text(encoding="utf-8"))))
    }
    assert found == {}, "what two test files share belongs in tests/fixtures/<what it is>.py"


@pytest.mark.parametrize(
    "planted",
    [
        "from diagnosis.test_signatures import LAG",
        "from c674x import test_packets as rules",
        "import c674x.test_packets",
        "from . import test_packets",
        "def late() -> None:\n    from test_api import results",
    ],
)
def test_an_import_of_a_test_file_is_found(planted: str) -> None:
    assert len(list(imported_tests(planted))) == 1
