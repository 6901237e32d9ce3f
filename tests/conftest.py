"""Fixtures of the whole suite: the folder of the measured records, and results that are computed once per run."""

import fcntl
import json
import os
import pickle
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import hypothesis
import jsonschema
import pytest

from fixtures.tools import missing, not_tested

# As the command line does, before NumPy: its BLAS reads once how many threads it may have.
for _threads in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_threads, "1")
# Output folds at the width of a terminal, which pytest-xdist states here.
os.environ.pop("COLUMNS", None)
# `make` of a test is no part of the `make` that started the run: it would warn of the other's job server.
os.environ.pop("MAKEFLAGS", None)
# The processes of pytest-xdist use the cores.
os.environ.setdefault("HYSGEN_PROCESSES", "1")


# The same examples in every run, and no deadline that a busy machine would miss.
hypothesis.settings.register_profile("hysgen", deadline=None, derandomize=True)
hypothesis.settings.load_profile("hysgen")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--update-golden", action="store_true", help="write golden files instead of comparing with them")


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """The last lines of the run: which promises were not tested, and the packages that would test them."""
    reasons = [report.longrepr[2] for report in terminalreporter.getreports("skipped")]
    if reasons:
        terminalreporter.section("not tested here")
        for line in not_tested(reasons):
            terminalreporter.write_line(line)


@pytest.fixture(autouse=True, scope="session")
def _every_json_has_its_schema() -> Iterator[None]:
    """The JSON of every verb that a test runs is held to the published schema (`hysgen schema`)."""
    import hysgen
    from hysgen.cli.console import Console

    write = Console.write_json

    def checked(self: Console, result: Mapping[str, Any]) -> None:
        if not self.verb:
            return write(self, result)
        plain = json.loads(json.dumps(self.with_head(result)))
        jsonschema.validate(
            plain, hysgen.schema(f"{plain['schema']}-{plain['version']}"), jsonschema.Draft202012Validator
        )
        return write(self, result)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Console, "write_json", checked)
        yield


@pytest.fixture(scope="session")
def measured() -> Path:
    """Folder of the measured records, from the environment variable HYSGEN_DATA."""
    folder = os.environ.get("HYSGEN_DATA")
    if not folder:
        missing("HYSGEN_DATA")
    return Path(folder)


@pytest.fixture(scope="session")
def once_per_run(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, Callable[[], Any]], Any]:
    """`once_per_run(name, make)`: the result of make(), computed by one process of the run and read by the others.

    With pytest-xdist every process has its own session fixtures; the result is pickled into the folder above theirs,
    and a lock on a file makes the others wait for it.
    """
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent
    read: dict[str, Any] = {}

    def once(name: str, make: Callable[[], Any]) -> Any:
        if name not in read:
            path = folder / f"{name}.pickle"
            with (folder / f"{name}.lock").open("w") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX)
                if not path.exists():
                    path.write_bytes(pickle.dumps(make()))
            read[name] = pickle.loads(path.read_bytes())
        return read[name]

    return once


@pytest.fixture(autouse=True, scope="session")
def _facts_of_generated_c(once_per_run: Callable[[str, Callable[[], Any]], Any]) -> Iterator[None]:
    """The costly facts of a generated folder, and the C of an export, are made once per run for each model.

    They are pure functions of the model. Tests of these functions import them from their own modules and compute.
    """
    from hysgen import codegen, export
    from hysgen.machine.files import digest
    from hysgen.model.file import dump_model
    from hysgen.model.model import Model

    def remembered(name: str, compute: Callable[..., Any]) -> Callable[..., Any]:
        def made(*given: Any, **options: Any) -> Any:
            parts = [dump_model(one) if isinstance(one, Model) else repr(one) for one in (*given, *options.items())]
            key = digest("\0".join([name, *parts]).encode())[:32]
            return once_per_run(f"{name}-{key}", lambda: compute(*given, **options))

        return made

    with pytest.MonkeyPatch.context() as patch:
        for name in ("accuracy", "figures", "chains", "learning"):
            patch.setattr(codegen, name, remembered(name, getattr(codegen, name)))
        generated = remembered("generate", export.generate)
        patch.setattr(export, "generate", lambda model, options: dict(generated(model, options)))
        yield
