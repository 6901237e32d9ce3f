"""What each test reaches: lines of Python, and the C files and templates that it reads. Used by planted_faults.py.

`start` runs in every Python process of the measured tree, through a .pth file of its environment: processes that a test
starts are measured whatever environment variables it gives them. In the process of pytest this module is a plugin too,
which says which test is running; a process that a test starts reads that from the file `context`.
"""

from __future__ import annotations

import atexit
import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

SETUP = "\tsetup"
"""End of the context of a fixture: what it computes, other tests of the file may read."""

_running: dict[str, Any] = {}


def start(tree: str, folder: str) -> None:
    """Measure this process: the package's lines go to `folder`/lines.*, files that are opened to `folder`/opened.*."""
    if _running:
        return
    import coverage

    context = Path(folder, "context").read_text(encoding="utf-8")
    measured = coverage.Coverage(
        data_file=str(Path(folder, "lines")),
        data_suffix=True,
        include=[f"{tree}/generator/*"],
        config_file=False,
        context=context or None,
        messages=False,
    )
    opened: set[tuple[str, str]] = set()
    _running.update(coverage=measured, folder=Path(folder), opened=opened, context=context, tree=tree)
    sys.addaudithook(_opens)
    measured.start()
    process = os.getpid()

    def end() -> None:
        if os.getpid() == process:
            measured.stop()
            measured.save()
            Path(folder, f"opened.{process}").write_text(json.dumps(sorted(opened)), encoding="utf-8")

    atexit.register(end)


def _opens(event: str, arguments: tuple[Any, ...]) -> None:
    tree = _running["tree"]
    if event == "open" and isinstance(arguments[0], str | os.PathLike):
        name = os.fspath(arguments[0])
        if isinstance(name, str) and name.startswith(tree) and name.endswith((".c", ".h", ".j2")):
            _running["opened"].add((_running["context"], name[len(tree) + 1 :]))
    elif event == "subprocess.Popen" and f"{tree}/firmware" in repr(arguments[1:3]):
        # A compiler or a `make` that reads the sources itself.
        _running["opened"].add((_running["context"], "firmware/*"))


def _enter(context: str) -> None:
    _running["context"] = context
    _running["coverage"].switch_context(context)
    (_running["folder"] / "context").write_text(context, encoding="utf-8")


def pytest_configure() -> None:
    """Every use of a template counts: Jinja reads its file once."""
    if not _running:
        return
    import jinja2

    load = jinja2.Environment._load_template

    def noted(self: Any, name: str, *rest: Any) -> Any:
        _running["opened"].add((_running["context"], f"templates/{name}"))
        return load(self, name, *rest)

    jinja2.Environment._load_template = noted  # type: ignore[method-assign]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    try:
        return (yield)
    finally:
        if _running:
            _enter("")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    if _running:
        _enter(item.nodeid + SETUP)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_call(item: pytest.Item) -> None:
    if _running:
        _enter(item.nodeid)


_tests: dict[str, dict[str, Any]] = {}


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    test = _tests.setdefault(report.nodeid, {"passed": True, "seconds": 0.0})
    test["passed"] &= report.outcome == "passed"
    test["seconds"] += report.duration


def pytest_sessionfinish() -> None:
    if _running:
        (_running["folder"] / "tests").write_text(json.dumps(_tests), encoding="utf-8")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Of the tests that are collected, run those that the file $PLANTED_TESTS lists, in its order."""
    listed = os.environ.get("PLANTED_TESTS")
    if not listed:
        return
    order = {name: place for place, name in enumerate(json.loads(Path(listed).read_text(encoding="utf-8")))}
    functions: dict[str, int] = {}
    for name, place in order.items():
        functions.setdefault(name.partition("[")[0], place)
    names = {item.nodeid for item in items}
    # A planted fault may change the name of a case: then all cases of its function stand for it.
    renamed = {name.partition("[")[0] for name in order if name not in names}
    wanted = [item for item in items if item.nodeid in order or item.nodeid.partition("[")[0] in renamed]
    items[:] = sorted(wanted, key=lambda item: order.get(item.nodeid, functions[item.nodeid.partition("[")[0]]))
