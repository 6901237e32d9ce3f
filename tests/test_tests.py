"""The tests themselves: imported by pytest alone, the same in every run, and green on a slow or bare machine."""

import ast
import functools
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from fixtures.tools import TOOLS

TESTS = Path(__file__).parent
COMMANDS = {name for name, tool in TOOLS.items() if tool.source.startswith("apt: ")}
CLOCKS = {"time.monotonic", "time.perf_counter", "time.time"}
PATIENCE_S = 60
"""Least time after which a test may give up: a busy machine can be twenty times slower than an idle one."""


@functools.lru_cache(maxsize=1)
def parsed(source: str) -> ast.Module:
    return ast.parse(source)


@functools.lru_cache(maxsize=256)
def walked(node: ast.AST) -> tuple[ast.AST, ...]:
    """The node and all below it: of a file and of its functions, which several rules read."""
    return tuple(ast.walk(node))


def imported_tests(source: str) -> Iterator[str]:
    """Every import of a test module in a Python source, as written there."""
    for node in walked(parsed(source)):
        if isinstance(node, ast.Import | ast.ImportFrom):
            module = (node.module or "") if isinstance(node, ast.ImportFrom) else ""
            parts = [part for name in (module, *(alias.name for alias in node.names)) for part in name.split(".")]
            if any(part.startswith("test_") for part in parts):
                yield ast.unparse(node)


def calls(tree: ast.AST) -> Iterator[tuple[str, ast.Call]]:
    """Every call, with the name of what is called: `pytest.mark.slow`, `.encode` of what has no name."""
    return ((dotted(node.func), node) for node in walked(tree) if isinstance(node, ast.Call))


def dotted(node: ast.expr) -> str:
    """The name that an expression is, or nothing."""
    if isinstance(node, ast.Attribute):
        return f"{dotted(node.value)}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else ""


def undeclared_tools(source: str) -> Iterator[str]:
    """Every look at what is installed, tool without a package, and tool of a command line that nobody asks for."""
    tree = parsed(source)
    for argument in (argument for name, node in calls(tree) if name == "need" for argument in node.args):
        if isinstance(argument, ast.Constant) and argument.value not in TOOLS:
            yield ast.unparse(argument)
    for node in walked(tree):
        if isinstance(node, ast.Constant | ast.Attribute | ast.Name):
            named = node.value if isinstance(node, ast.Constant) else getattr(node, "attr", getattr(node, "id", ""))
            if named in ("HYSGEN_REQUIRE_TOOLS", "importorskip", "which"):
                yield ast.unparse(node)
    for function in (node for node in tree.body if isinstance(node, ast.FunctionDef)):
        lines = [node.elts for node in walked(function) if isinstance(node, ast.List)]
        lines += [node.elts for node in walked(function) if isinstance(node, ast.Tuple) and len(node.elts) > 1]
        lines += [node.args[1:] for name, node in calls(function) if name == "run"]
        used = {line[0].value for line in lines if line and isinstance(line[0], ast.Constant)} & COMMANDS
        asked = [argument for name, node in calls(function) if name in ("need", "exported") for argument in node.args]
        if all(isinstance(argument, ast.Constant) for argument in asked):
            yield from sorted(used - {argument.value for argument in asked if isinstance(argument, ast.Constant)})
        elif not asked:
            yield from sorted(used)


def ids_of_bytes(source: str) -> Iterator[str]:
    """Every list of cases that holds bytes and has no ids: an id would be made from the bytes."""
    for name, node in calls(parsed(source)):
        if name.endswith("parametrize") and not any(keyword.arg == "ids" for keyword in node.keywords):
            cases = [inner for case in node.args[1:] for inner in walked(case)]
            if any(isinstance(inner, ast.Constant) and isinstance(inner.value, bytes) for inner in cases) or any(
                called.endswith((".encode", ".compress", "bytes"))
                for case in node.args[1:]
                for called, _ in calls(case)
            ):
                yield ast.unparse(node.args[0])


def deadlines(source: str) -> Iterator[str]:
    """Every assertion about a time that a clock of the machine measured, and every time-out of a few seconds."""
    tree = parsed(source)
    for _, node in calls(tree):
        for keyword in node.keywords:
            value = keyword.value.value if isinstance(keyword.value, ast.Constant) else None
            short = isinstance(value, int | float) and value < PATIENCE_S
            if (keyword.arg == "deadline" and value is not None) or (keyword.arg == "timeout" and short):
                yield ast.unparse(keyword)
    for function in (node for node in walked(tree) if isinstance(node, ast.FunctionDef)):
        timed = {
            ast.unparse(target)
            for node in walked(function)
            if isinstance(node, ast.Assign) and any(name in CLOCKS for name, _ in calls(node.value))
            for target in node.targets
        }
        for node in walked(function):
            if isinstance(node, ast.Assert) and (
                any(name in CLOCKS for name, _ in calls(node.test))
                or any(isinstance(inner, ast.Name) and inner.id in timed for inner in walked(node.test))
            ):
                yield ast.unparse(node)


REMEDIES = {
    imported_tests: "what two test files share belongs in tests/fixtures/<what it is>.py",
    undeclared_tools: "a test asks fixtures.tools for a tool: need(...), library(...)",
    ids_of_bytes: "ids=... gives the cases names",
    deadlines: "a busy machine misses a deadline: test what happens, not how soon",
}


def test_no_test_file_holds_what_is_forbidden() -> None:
    wrong = [
        f"{path.relative_to(TESTS)}: {text}: {remedy}"
        for path in sorted(TESTS.rglob("*.py"))
        if path != TESTS / "fixtures" / "tools.py"
        for forbidden, remedy in REMEDIES.items()
        if path != Path(__file__) or forbidden is imported_tests
        for text in forbidden(path.read_text(encoding="utf-8"))
    ]
    assert wrong == []


def test_no_id_is_made_from_bytes(request: pytest.FixtureRequest) -> None:
    items = [item for item in request.session.items if hasattr(item, "callspec")]
    cases = [(item.nodeid, item.callspec.params.values()) for item in items]
    found = [name for name, values in cases if "\\x" in name and any(isinstance(value, bytes) for value in values)]
    assert found == []


@pytest.mark.slow
def test_two_collections_are_the_same(request: pytest.FixtureRequest) -> None:
    """That of this run, and one that is seconds later and has another order of sets."""
    first = [item.nodeid for item in request.session.items]
    call = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-o", "addopts=--import-mode=importlib", "--"]
    seed = {**os.environ, "PYTHONHASHSEED": "1" if os.environ.get("PYTHONHASHSEED") == "2" else "2"}
    files = list(dict.fromkeys(name.partition("::")[0] for name in first))
    done = subprocess.run([*call, *files], cwd=TESTS.parent, env=seed, capture_output=True, text=True, check=True)
    chosen = set(first)
    assert [name for name in done.stdout.splitlines() if name in chosen] == first


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


@pytest.mark.parametrize(
    ("forbidden", "planted"),
    [
        (undeclared_tools, "if shutil.which('frama-c'):\n    pass"),
        (undeclared_tools, "from shutil import which\nassert which('cc')"),
        (undeclared_tools, "GTC = pytest.importorskip('GTC')"),
        (undeclared_tools, "def test_c() -> None:\n    need('gcc', 'no-such-tool')"),
        (undeclared_tools, "strict = os.environ.get('HYSGEN_REQUIRE_TOOLS')"),
        (undeclared_tools, "def test_c() -> None:\n    subprocess.run(['clang', '-c', 'a.c'])"),
        (undeclared_tools, "def test_c() -> None:\n    need('gcc')\n    run(folder, 'clang', '-c', 'a.c')"),
        (ids_of_bytes, "@pytest.mark.parametrize('data', [b'PK'])\ndef test_a(data: bytes) -> None: ..."),
        (ids_of_bytes, "@pytest.mark.parametrize('data', [gzip.compress(text)])\ndef test_a(data: bytes) -> None: ..."),
        (deadlines, "@settings(deadline=200)\ndef test_a(x: int) -> None: ..."),
        (deadlines, "def test_a() -> None:\n    subprocess.run(call, timeout=5)"),
        (deadlines, "def test_a() -> None:\n    begun = time.monotonic()\n    assert time.monotonic() - begun < 5"),
        (deadlines, "def test_a() -> None:\n    spent = time.time() - begun\n    assert spent < 5"),
    ],
)
def test_what_is_forbidden_is_found(forbidden: Callable[[str], Iterator[str]], planted: str) -> None:
    assert list(forbidden(planted))
