"""The documents are true where that can be checked: commands, links, paths and modules that they name exist, and the
output that README and tutorial show is what their commands print."""

import ast
import difflib
import functools
import importlib
import re
import shlex
import tomllib
from pathlib import Path

import pytest

import hysgen
from hysgen.cli.main import HYSGEN, main, parser
from hysgen.record.read import bundled_csv
from hysgen_lab.verbs import LABORATORY

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
COMMAND = re.compile(r"^(?:    |\$ )?((?:python -m hysgen_lab|hysgen) [a-z].*)$", re.MULTILINE)
BLOCK = re.compile(r"^```(python|)\n(.*?)^```", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\((?!https?:)([^)#]+)")
PATH = re.compile(r"(?<![\w/.<>:-])(?:[\w.-]+/)+[\w.-]*\w")
MODULE = re.compile(r"(?<![\w/])hysgen(?:_c674x|_lab)?(?:\.\w+)+")
SOURCES = ("generator", "templates", "firmware", "tests", "benchmarks", "docs")
OF_THE_READER = {"firmware/stage", "kick", "toml"}
"""Folders and files that a page tells the reader to make, and the cause of docs/extend.md."""

by_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)


def commands(text: str) -> list[str]:
    """Commands shown in blocks, without the remark behind them; continued lines joined."""
    blocks = re.findall(r"```[a-z]*\n(.*?)```|((?:^    .*\n)+)", text.replace("\\\n", " "), re.DOTALL | re.MULTILINE)
    lines = [found.group(1) for block in blocks for found in COMMAND.finditer("".join(block))]
    return [line.partition(" #")[0].rstrip() for line in lines]


@by_page
def test_every_command_shown_is_one_that_the_program_has(page: Path) -> None:
    for command in commands(page.read_text()):
        words = shlex.split(command.removeprefix("python -m "))
        program = LABORATORY if words.pop(0) == "hysgen_lab" else HYSGEN
        if "..." in words or any(word.isupper() for word in words):
            continue  # a pattern, not a command
        try:
            parser(program.names, program).parse_args(words)
        except SystemExit as exit_:
            if exit_.code != 0:  # --help and --version leave with 0
                raise AssertionError(f"{page.name}: {command}") from exit_


@by_page
def test_every_link_leads_to_a_file(page: Path) -> None:
    for link in LINK.findall(page.read_text()):
        assert (page.parent / link).exists(), f"{page.name}: {link}"


@functools.cache
def source_paths() -> frozenset[str]:
    """Every file and folder of the sources as a path from the root, with and without its endings."""
    found = set()
    for top in SOURCES:
        for path in [ROOT / top, *(ROOT / top).rglob("*")]:
            if "__pycache__" not in path.parts:
                whole = path.relative_to(ROOT).as_posix()
                found |= {whole, whole.removesuffix(".py"), whole.removesuffix(".c.j2")}
    return frozenset(found)


def unknown_paths(text: str) -> list[str]:
    """Paths in the text that end no path of the sources. Only those count that begin with a folder of the sources, or
    end like a source file."""
    folders = {part for path in source_paths() for part in path.split("/")[:-1]} | {*SOURCES}
    named = {
        token for token in PATH.findall(text) if token.split("/")[0] in folders or token.endswith((".py", ".j2", ".sh"))
    }
    return sorted(
        token
        for token in named
        if not any(name in token for name in OF_THE_READER)
        and not any(path == token or path.endswith(f"/{token}") for path in source_paths())
    )


def unknown_modules(text: str) -> list[str]:
    """Dotted names below `hysgen` in the text that are no module and no attribute of one."""
    return sorted(
        name for name in set(MODULE.findall(text)) if not (_exists(name) or OF_THE_READER & {*name.split(".")})
    )


def _exists(name: str) -> bool:
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            found: object = importlib.import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        try:
            for part in parts[count:]:
                found = getattr(found, part)
        except AttributeError:
            return False
        return True
    return False


@by_page
def test_every_path_and_module_that_a_page_names_exists(page: Path) -> None:
    text = page.read_text()
    assert not unknown_paths(text), page.name
    assert not unknown_modules(text), page.name


def test_a_path_or_module_that_is_not_there_would_be_found() -> None:
    text = "`fit/spread.py`, `hysgen/emit`, `generator/hysgen/fitting`, `codegen/manifest.py`; df/dy; `c/stage.h`"
    assert unknown_paths(text) == ["fit/spread.py", "hysgen/emit"]
    text = "`hysgen.diagnose.FitSettings`, `hysgen.fitting.FitSettings`, `hysgen.fit`, `hysgen.emit.render`"
    assert unknown_modules(text) == ["hysgen.diagnose.FitSettings", "hysgen.emit.render"]


def test_readme_lists_the_entries_of_the_package_in_the_order_of_the_import_contract() -> None:
    layers = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"][0]["layers"]
    layout = (ROOT / "README.md").read_text().partition("## Layout")[2]
    listed = re.findall(r"^    (\w+)(?:/|\.py)  ", layout, re.MULTILINE)
    assert listed == layers[::-1]


def test_a_command_that_is_not_there_would_be_found() -> None:
    assert commands("```\nhysgen polish x.csv   # shine\n```\n\n    hysgen cost c\n") == [
        "hysgen polish x.csv",
        "hysgen cost c",
    ]
    with pytest.raises(SystemExit):
        parser().parse_args(["polish", "x.csv"])


def test_each_format_is_tested_on_files_of_the_library_that_the_table_names() -> None:
    tests = "\n".join(path.read_text() for path in (ROOT / "tests" / "record").glob("*.py"))
    cells = re.findall(r"^\|.*\| ([^|]*) \|$", (ROOT / "docs" / "records.md").read_text(), re.MULTILINE)
    libraries = set(re.findall(r"`(\w+)`", " ".join(cells)))
    assert {"nptdms", "asammdf", "pyuff", "openpyxl", "matio"} <= libraries
    unused = [name for name in libraries if not re.search(rf'(import|from) {name}\b|library\("{name}"\)', tests)]
    assert unused == []


def test_reference_of_the_python_interface_names_all_of_it() -> None:
    tree = ast.parse(Path(hysgen.__file__).with_suffix(".pyi").read_text())
    typed = {alias.asname for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert set(hysgen.__all__) == typed
    assert all(getattr(hysgen, name) for name in hysgen.__all__)
    page = (ROOT / "docs" / "api.md").read_text()
    missing = [name for name in hysgen.__all__ if not re.search(rf"\b{name}\b", page)]
    assert not missing


def plain(line: str) -> str:
    """The line without what the machine decides: widths of columns, times, compilers and their number."""
    line = re.sub(r"\b[\d.]+ s\b|^builds: .*|(?<=on this machine) \(.*?\)+(?=;)", "#", " ".join(line.split()))
    return re.sub(r"(?<=~)(\d+) [\d.]+$", r"\1 #", re.sub(r" \d+ equal$", " # equal", line))


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
        if list(map(plain, lines)) != list(map(plain, right)):
            runs[index] = run.replace("\n".join(lines), "\n".join(right))
    return "...\n".join(runs)


@pytest.mark.golden
@pytest.mark.proof
def test_each_block_of_output_is_what_its_command_prints(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], request: pytest.FixtureRequest
) -> None:
    """Update with `pytest tests/test_docs.py --update-golden` and look at the diff."""
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
    assert as_printed("a  1.00\n...\nc\nd\ntook 3 s\n", printed) == "a  1.00\n...\nc\nd\ntook 3 s\n"
    assert as_printed("a 1.02\n...\nc\ntook 3 s\n", printed) == "a 1.00\n...\nc\nd\ntook 1.25 s\n"
