"""Copies of the tree to run tests in, and which tests reach a line; used by planted_faults.py."""

from __future__ import annotations

import ast
import contextlib
import functools
import importlib.util
import json
import os
import queue
import re
import shutil
import signal
import subprocess
import sys
import sysconfig
import time
import venv
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from reached_lines import SETUP

ROOT: Final = Path(__file__).resolve().parents[1]
PACKAGES: Final = "generator/"
WORKERS: Final = 2


@functools.cache
def committed() -> tuple[str, ...]:
    """The files of the commit."""
    call = ["git", "ls-tree", "-r", "--name-only", "HEAD"]
    return tuple(subprocess.run(call, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines())


@dataclass(frozen=True)
class Edit:
    """Text of a file, at or near a line, and what takes its place."""

    file: str
    line: int
    old: str
    new: str

    def applied(self, text: str) -> str:
        """Raises ValueError if the text does not stand in the file."""
        places = [found.start() for found in re.finditer(re.escape(self.old), text)]
        if not places:
            raise ValueError(f"{self.file}:{self.line}: no longer holds {self.old}")
        place = min(places, key=lambda place: abs(text.count("\n", 0, place) + 1 - self.line))
        return text[:place] + self.new + text[place + len(self.old) :]


def compiles(edit: Edit, text: str) -> bool:
    """Whether the changed file compiles, as far as that can be told alone; a template is told by its tests."""
    changed = edit.applied(text)
    if edit.file.endswith(".py"):
        try:
            compile(changed, edit.file, "exec", dont_inherit=True)
        except SyntaxError:
            return False
        return True
    if edit.file.endswith(".j2"):
        return True
    folders = [
        ROOT / "firmware/controller",
        ROOT / "firmware/board/host",
        *(ROOT / "firmware/models").glob("appendix_a*/**"),
    ]
    search = [f"-I{folder}" for folder in (Path(ROOT, edit.file).parent, *folders)]

    def errors(source: str) -> bool:
        call = ["gcc", "-fsyntax-only", "-w", "-std=gnu99", *search, "-x", "c", "-"]
        return subprocess.run(call, input=source, text=True, capture_output=True, check=False).returncode != 0

    return errors(text) or not errors(changed)


@dataclass(frozen=True)
class Place:
    """A copy of the tree, an environment that imports the package from there, and folders of its own for caches."""

    folder: Path

    @property
    def tree(self) -> Path:
        return self.folder / "tree"

    @property
    def cache(self) -> Path:
        return self.folder / "cache"

    def whole(self) -> bool:
        """Whether every file of the commit is there: a fault may delete files."""
        return all((self.tree / name).exists() for name in committed())

    def make(self, measured: bool) -> None:
        shutil.rmtree(self.folder, ignore_errors=True)
        for name in ("tree", "cache", "tmp", "measured"):
            (self.folder / name).mkdir(parents=True)
        archive = subprocess.run(["git", "archive", "HEAD"], cwd=ROOT, capture_output=True, check=True)
        subprocess.run(["tar", "-x"], cwd=self.tree, input=archive.stdout, check=True)
        venv.create(self.folder / "venv", symlinks=True)
        # The packages of this environment, but not its .pth files: they would import the package from this checkout.
        lines = [str(self.tree / "generator"), sysconfig.get_paths()["purelib"], str(Path(__file__).parent)]
        if measured:
            (self.folder / "measured" / "context").write_text("", encoding="utf-8")
            place = f"{str(self.tree)!r}, {str(self.folder / 'measured')!r}"
            lines.append(f"import reached_lines; reached_lines.start({place})")
        site = next((self.folder / "venv").glob("lib/python*/site-packages"))
        (site / "planted_faults.pth").write_text("\n".join(lines) + "\n", encoding="utf-8")

    def pytest(self, arguments: Sequence[str], most_s: float, **variables: str) -> tuple[int | None, str]:
        """The exit code of pytest, None after `most_s` seconds, and what it printed."""
        shutil.rmtree(self.folder / "tmp", ignore_errors=True)
        (self.folder / "tmp").mkdir()
        python = self.folder / "venv" / "bin" / "python"
        call = [str(python), "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-p", "reached_lines"]
        threads = dict.fromkeys(("HYSGEN_PROCESSES", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
        environment["PATH"] = f"{python.parent}:{Path(sys.executable).parent}:{os.environ['PATH']}"
        environment |= {"HYSGEN_CACHE": str(self.cache), "TMPDIR": str(self.folder / "tmp")}
        environment |= threads | variables
        with (self.folder / "output").open("w+") as output:
            process = subprocess.Popen(
                [*call, *arguments],
                cwd=self.tree,
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
            code: int | None = None
            with contextlib.suppress(subprocess.TimeoutExpired):
                code = process.wait(most_s)
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            output.seek(0)
            return code, output.read()


def in_threads(work: Callable[[int], None]) -> None:
    """work(0) and work(1) at the same time."""
    with ThreadPoolExecutor(WORKERS) as pool:
        list(pool.map(work, range(WORKERS)))


def measure(folder: Path) -> None:
    """Run every test file under coverage.py, each in its own process; its results go to a file in `folder`/reached."""
    if importlib.util.find_spec("coverage") is None:
        raise SystemExit("coverage is missing: pip install 'coverage>=7.6'")
    names = [f"HEAD:{name}" for name in ("generator", "templates", "firmware", "tests")]
    trees = subprocess.run(["git", "rev-parse", *names], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    measured = folder / "measured_trees.txt"
    if measured.exists() and measured.read_text(encoding="utf-8") != trees:
        raise SystemExit(f"{folder}: holds what the tests of another commit reach; name another folder")
    todo: queue.SimpleQueue[str | None] = queue.SimpleQueue()
    for name in ("reached", "cache"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    measured.write_text(trees, encoding="utf-8")
    files = [str(path.relative_to(ROOT)) for path in sorted((ROOT / "tests").rglob("test_*.py"))]
    for name in sorted(files, key=lambda name: "c674x" in name):
        if not (folder / "reached" / (name.replace("/", "+") + ".json")).exists():
            todo.put(name)
    if todo.empty():
        return
    for _ in range(WORKERS):
        todo.put(None)

    def work(number: int) -> None:
        place = Place(folder / f"measured-{number}")
        place.make(measured=True)
        for name in iter(todo.get, None):
            began = time.monotonic()
            code, output = place.pytest(["-m", "not proof", name], 3600.0, HYSGEN_CACHE=str(folder / "cache"))
            result = json.dumps(reached(place))
            (folder / "reached" / (name.replace("/", "+") + ".json")).write_text(result, encoding="utf-8")
            last = output.strip().splitlines()[-1:] or ["no output"]
            print(f"{name}: exit {code}, {time.monotonic() - began:.0f} s, {last[0]}", flush=True)

    in_threads(work)


def reached(place: Place) -> dict[str, Any]:
    """tests: seconds of each test that passed. lines, opened: numbers of these tests, -1 for all of the file."""
    from coverage import CoverageData

    folder = place.folder / "measured"
    results = folder / "tests"
    outcomes = json.loads(results.read_text(encoding="utf-8")) if results.exists() else {}
    tests = {name: round(test["seconds"], 3) for name, test in outcomes.items() if test["passed"]}
    numbers = {name: number for number, name in enumerate(tests)}

    def numbered(contexts: Iterable[str]) -> list[int]:
        return sorted({-1 if not name or name.endswith(SETUP) else numbers.get(name, -2) for name in contexts} - {-2})

    lines: dict[str, dict[int, set[str]]] = {}
    opened: dict[str, set[str]] = {}
    for path in folder.glob("lines.*"):
        data = CoverageData(str(path))
        data.read()
        for name in data.measured_files():
            at = lines.setdefault(str(Path(name).relative_to(place.tree)), {})
            for line, contexts in data.contexts_by_lineno(name).items():
                at.setdefault(line, set()).update(contexts)
        path.unlink()
    for path in folder.glob("opened.*"):
        for context, name in json.loads(path.read_text(encoding="utf-8")):
            opened.setdefault(name, set()).add(context)
        path.unlink()
    results.unlink(missing_ok=True)
    (folder / "context").write_text("", encoding="utf-8")
    return {
        "tests": tests,
        "lines": {name: {line: numbered(at) for line, at in found.items()} for name, found in lines.items()},
        "opened": {name: numbered(contexts) for name, contexts in opened.items()},
    }


class Reach:
    """Tests by what they reach, as `measure` found it."""

    def __init__(self, folder: Path) -> None:
        self.files = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.json"))]
        for file in self.files:
            file["names"] = list(file["tests"])
        self.seconds: dict[str, float] = {name: s for file in self.files for name, s in file["tests"].items()}
        self.sources = {
            str(path.relative_to(ROOT)): path.read_text(encoding="utf-8") for path in ROOT.glob(f"{PACKAGES}**/*.py")
        }
        self.trees = {name: ast.parse(text) for name, text in self.sources.items()}

    def tests(self, edit: Edit) -> dict[str, bool]:
        """Tests that reach the line of an edit: whether each does so itself, or another test of its file."""
        if edit.file.endswith(".py"):
            return dict.fromkeys(self._of_python(edit), True)
        if edit.file.startswith(PACKAGES):
            text = re.sub(r"/\*.*?\*/", "", (ROOT / edit.file).read_text(encoding="utf-8"), flags=re.DOTALL)
            functions = re.findall(r"^(?!static)[a-z_][\w \*]*?(\w+)\(", text, re.MULTILINE)
            by_name = self._naming(functions)
            if by_name:
                return dict.fromkeys(by_name, True)
        found: dict[str, bool] = {}
        for file in self.files:
            numbers = {n for name in (edit.file, "firmware/*") for n in file["opened"].get(name, ())}
            numbers -= set() if edit.file.startswith("firmware/") or edit.file in file["opened"] else numbers
            if numbers:
                found |= {name: -1 in numbers or n in numbers for n, name in enumerate(file["names"])}
        return found

    def _lines(self, name: str, lines: Iterable[int], imported: bool) -> set[str]:
        """Tests that run one of the lines. imported: a line that runs while a test file is imported counts, too."""
        wanted, found = {str(line) for line in lines}, set()
        for file in self.files:
            numbers = {n for line, at in file["lines"].get(name, {}).items() if line in wanted for n in at}
            found |= set(file["names"] if -1 in numbers and imported else (file["names"][n] for n in numbers if n >= 0))
        return found

    def _functions(self, name: str) -> set[int]:
        """The lines of a module that stand in functions."""
        bodies = [node.body for node in ast.walk(self.trees[name]) if isinstance(node, ast.FunctionDef)]
        return {line for body in bodies for line in range(body[0].lineno, (body[-1].end_lineno or 0) + 1)}

    def _naming(self, names: Iterable[str]) -> set[str]:
        """Tests that run a line in a function that holds one of these names, anywhere in the package."""
        pattern = re.compile(rf"\b(?:{'|'.join(map(re.escape, names)) or '(?!)'})\b")
        found: set[str] = set()
        for name, text in self.sources.items():
            lines = {number for number, line in enumerate(text.splitlines(), 1) if pattern.search(line)}
            if lines:
                found |= self._lines(name, lines & self._functions(name), imported=True)
        return found

    def _of_python(self, edit: Edit) -> set[str]:
        lines = set(range(edit.line, edit.line + edit.old.rstrip("\n").count("\n") + 1))

        def first(node: ast.stmt) -> int:
            return min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", ()))])

        nodes = [node for node in ast.walk(self.trees[edit.file]) if isinstance(node, ast.stmt)]
        around = [node for node in nodes if first(node) <= edit.line <= (node.end_lineno or 0)]
        # Of statements that begin and end together, the walk comes to the inner one last.
        statement = min(reversed(around), key=lambda node: (node.end_lineno or 0) - first(node))
        end = (statement.end_lineno or 0) + 1
        if isinstance(statement, ast.FunctionDef):
            return self._lines(edit.file, range(statement.body[0].lineno, end), imported=True)
        if body := getattr(statement, "body", None):
            end = max(body[0].lineno, statement.lineno + 1)
        if edit.line < end:
            lines |= set(range(statement.lineno, end))
        if any(isinstance(node, ast.FunctionDef) for node in around):
            return self._lines(edit.file, lines, imported=True)
        # At the top of a module or a class: run once, used by whoever names it.
        names = {
            node.id for node in ast.walk(statement) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        }
        direct = self._lines(edit.file, lines, imported=False) | self._naming(names)
        return direct | self._lines(edit.file, self._functions(edit.file), imported=True)

    def ordered(self, edits: Sequence[Edit], room: str) -> list[str]:
        """The tests to run: those of the room first, then those that reach the line themselves; short ones first."""
        tests: dict[str, bool] = {}
        for edit in edits:
            for name, itself in self.tests(edit).items():
                tests[name] = tests.get(name, False) or itself
        near = {room.partition("/")[0]}
        if room == "templates":
            near = {"codegen", {"proof": "checking"}.get(part := Path(edits[0].file).parts[1], part)}

        def place(name: str) -> tuple[bool, bool, float]:
            parts = name.partition("::")[0].split("/")
            return (parts[1] if len(parts) > 2 else "api") not in near, not tests[name], self.seconds[name]

        return sorted(tests, key=place)
