"""Figures of the layout and size of the source, read from the text alone: `python benchmarks/house.py [CHECKOUT]`.

A table with a row for each package below generator/, then figures of the product, generator/hysgen. Code is what is no
docstring, import, comment or blank line; a constant is a name in capitals that a module assigns at its top.

    --check            compare with [tool.house] of pyproject.toml: a line for each excess, exit code 1
    --words WORD ...   words to count (default: the names of the causes)
    --json             the same figures as JSON

An entry is a module or package directly below generator/hysgen. An arrow is a pair of entries (A, B) where a module
of A imports one of B, at the top of the file or inside a function, type-checking imports excepted. The floor of an
entry is 1 + the highest floor of the entries that it imports; entries on a circle of imports share a floor. The
package's own `__init__` and `__main__` are no entries, but count as floors where a chain of imports passes them.
"""

from __future__ import annotations

import argparse
import ast
import json
import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

CAUSES = (
    *("memory", "creep", "resonance", "delay", "saturation", "slew"),
    *("drift", "periodic", "aging", "outliers", "coupling"),
)
NO_ENTRY = {"__init__", "__main__"}
MOST_PARAMETERS = 6
PRONOUNS = {"one", "found", "each", "kept", "left", "told", "there"}
"""Words that are no names: a reader cannot search for them, and they do not say what they hold."""

Module = tuple[str, ...]


def figures(root: Path, words: tuple[str, ...]) -> dict[str, Any]:
    """Every figure of the checkout at `root`."""
    package = root / "generator" / "hysgen"
    if not package.is_dir():
        raise SystemExit(f"{root}: holds no generator/hysgen; name the root of a checkout")
    entries = {path.name.partition(".")[0] for path in package.iterdir() if path.name[0] != "." and _counts(path)}
    arrows = _arrows(package, entries)
    floors, circles = _floors(entries, arrows)
    files = {path: path.read_text(encoding="utf-8") for path in package.rglob("*") if _is_text(path)}
    texts = {path: text for path, text in files.items() if path.suffix == ".py"}
    functions = [
        (node.end_lineno - node.lineno + 1, _parameters(node), f"{path.relative_to(package)}:{node.name}")
        for path, text in texts.items()
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.FunctionDef) and node.end_lineno is not None
    ]
    packages = sorted(path.parent for path in package.parent.glob("*/__init__.py"))
    jinja = [(_lines(path), str(path.relative_to(root))) for path in (root / "templates").rglob("*.j2")]
    return {
        "packages": {path.name: _size(path) for path in packages},
        "entries": len(entries - NO_ENTRY),
        "floors": max(floors.values()),
        "arrows": sum(not NO_ENTRY & {*arrow} for arrow in arrows),
        "circles": [sorted(circle) for circle in circles],
        "files with the word": {word: _holding(word, files) for word in words},
        "lines": _all_lines(root),
        "longest functions": [f"{lines} {name}" for lines, _, name in sorted(functions, reverse=True)[:10]],
        "longest templates": [f"{lines} {name}" for lines, name in sorted(jinja, reverse=True)[:3]],
        "functions with many parameters": [
            f"{count} {name}"
            for _, count, name in sorted(functions, key=lambda f: (-f[1], f[2]))
            if count > MOST_PARAMETERS
        ],
    }


def _all_lines(root: Path) -> dict[str, int]:
    """Lines of the checkout by kind."""
    package, firmware = root / "generator", root / "firmware"
    return {
        "packages": sum(_lines(path) for path in package.rglob("*.py")),
        "C in packages": sum(_lines(path) for end in "chs" for path in package.rglob(f"*.{end}")),
        "C of firmware": sum(_lines(path) for end in "chs" for path in firmware.rglob(f"*.{end}")),
        "docs": sum(_lines(path) for path in (*(root / "docs").glob("*.md"), *root.glob("*.md"))),
        "templates": sum(_lines(path) for path in (root / "templates").rglob("*") if path.is_file()),
        "tests": sum(_lines(path) for path in (root / "tests").rglob("*.py")),
    }


def excesses(root: Path) -> list[str]:
    """Every figure above its limit in [tool.house] of pyproject.toml, with place and numbers."""
    limits = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["house"]
    sizes = {name: {"lines": lines} for name, lines in _all_lines(root).items()}
    for package in (root / "generator").glob("*/__init__.py"):
        files = list(package.parent.rglob("*.py"))
        sizes[package.parent.name] = {"lines": sum(map(_lines, files)), "files": len(files)}
    lines = [
        f"{name}: {sizes[name][unit]} {unit}, the budget is {most}: delete as much as you add"
        for name, budget in limits["budget"].items()
        for unit, most in budget.items()
        if sizes[name][unit] > most
    ]
    rooms: dict[str, list[str]] = {}
    for path in sorted((root / "generator").rglob("*.py")):
        parts = path.relative_to(root / "generator").with_suffix("").parts
        rooms.setdefault("/".join(parts[:2]), []).extend(_pronouns(path))
    for room, places in rooms.items():
        most = limits["pronouns"].get(room, 0)
        if len(places) > most:
            lines.append(f"{room}: {len(places)} names say nothing, {most} are allowed: {', '.join(places[-5:])}")
    return lines


def _pronouns(path: Path) -> list[str]:
    """Place and name of every variable, argument, function or class of a file that is named by a pronoun.

    `left` beside `right` is a side.
    """
    text = path.read_text(encoding="utf-8")
    if not PRONOUNS & set(re.findall(r"\w+", text)):
        return []
    names = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.append((node.lineno, node.id))
        elif isinstance(node, ast.arg):
            names.append((node.lineno, node.arg))
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.append((node.lineno, node.name))
    said = PRONOUNS - ({"left"} if any(name == "right" for _, name in names) else set())
    return [f"{path.name}:{line} {name}" for line, name in sorted(names) if name in said]


def _size(package: Path) -> dict[str, float]:
    """Lines, files, statements, dataclasses, constants of a package, and its lines of code per line of imports."""
    texts = [path.read_text(encoding="utf-8") for path in package.rglob("*.py")]
    trees = [ast.parse(text) for text in texts]
    nodes = [node for tree in trees for node in ast.walk(tree)]
    docs = [node.value for node in nodes if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)]
    imports = sum(_length(node) for node in nodes if isinstance(node, ast.Import | ast.ImportFrom))
    bare = sum(not line.strip() or line.lstrip().startswith("#") for text in texts for line in text.splitlines())
    bare -= sum(not line.strip() for doc in docs for line in str(doc.value).splitlines()[1:-1])
    lines = sum(len(text.splitlines()) for text in texts)
    return {
        "lines": lines,
        "files": len(texts),
        "statements": sum(isinstance(node, ast.stmt) for node in nodes) - len(docs),
        "dataclasses": sum(
            any("dataclass" in ast.unparse(mark) for mark in node.decorator_list)
            for node in nodes
            if isinstance(node, ast.ClassDef)
        ),
        "constants": sum(_constants(statement) for tree in trees for statement in tree.body),
        "code per import": round((lines - bare - imports - sum(map(_length, docs))) / max(imports, 1), 1),
    }


def _length(node: ast.stmt | ast.expr) -> int:
    return (node.end_lineno or node.lineno) - node.lineno + 1


def _constants(statement: ast.stmt) -> int:
    """Names in capitals that a statement at the top of a module assigns."""
    targets = statement.targets if isinstance(statement, ast.Assign) else [getattr(statement, "target", None)]
    names = [node.id for target in targets if target for node in ast.walk(target) if isinstance(node, ast.Name)]
    return sum(name.lstrip("_").isupper() for name in names)


def _counts(path: Path) -> bool:
    """A Python module, or a folder that holds any text (a folder of data is an entry, too)."""
    return any(map(_is_text, path.rglob("*"))) if path.is_dir() else path.suffix == ".py"


def _is_text(path: Path) -> bool:
    return path.is_file() and path.suffix in (".py", ".c", ".h", ".json", ".csv", ".s", ".ld", ".txt", ".md", ".j2")


def _arrows(package: Path, entries: set[str]) -> set[tuple[str, str]]:
    """(importing entry, imported entry). Where X is no entry, `from hysgen import X` is an arrow to `__init__`."""
    found = set()
    for path in package.rglob("*.py"):
        importer: Module = ("hysgen", *path.relative_to(package).with_suffix("").parts)
        for imported in _imports(ast.parse(path.read_text(encoding="utf-8")), importer):
            target = imported[1] if len(imported) > 1 and imported[1] in entries else "__init__"
            if imported[0] == "hysgen" and target != importer[1]:
                found.add((importer[1], target))
    return found


def _imports(tree: ast.AST, importer: Module) -> Iterator[Module]:
    """Dotted names that a file imports, each as its parts; blocks under `if TYPE_CHECKING` are left out."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            continue
        if isinstance(node, ast.Import):
            yield from (tuple(alias.name.split(".")) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = (*importer[: -node.level],) if node.level else ()
            base = (*base, *(node.module.split(".") if node.module else ()))
            yield from ((*base, alias.name) for alias in node.names)
        else:
            yield from _imports(node, importer)


def _floors(entries: set[str], arrows: set[tuple[str, str]]) -> tuple[dict[str, int], list[set[str]]]:
    """Floor of each entry, and the circles: sets of entries each of which reaches the others by imports."""
    below = {entry: {b for a, b in arrows if a == entry} for entry in entries}
    reached = {entry: set(below[entry]) for entry in entries}
    for middle in entries:
        for entry in entries:
            if middle in reached[entry]:
                reached[entry] |= reached[middle]
    group = {e: frozenset({e} | {o for o in reached[e] if e in reached[o]}) for e in entries}
    floors: dict[str, int] = {}

    def floor(entry: str) -> int:
        if entry not in floors:
            under = {b for member in group[entry] for b in below[member]} - group[entry]
            height = 1 + max((floor(b) for b in under), default=0)
            floors.update(dict.fromkeys(group[entry], height))
        return floors[entry]

    for entry in entries:
        floor(entry)
    return floors, [set(members) for members in set(group.values()) if len(members) > 1]


def _holding(word: str, texts: dict[Path, str]) -> int:
    """Files that hold the word as a whole word (`creep`, not `creeps`), those named after it excepted."""
    pattern = re.compile(rf"(?<![A-Za-z]){word}(?![A-Za-z])", re.IGNORECASE)
    return sum(1 for path, text in texts.items() if word not in path.stem and pattern.search(text))


def _parameters(node: ast.FunctionDef) -> int:
    spec = node.args
    names = [argument.arg for argument in (*spec.posonlyargs, *spec.args, *spec.kwonlyargs)]
    return sum(name not in ("self", "cls") for name in names)


def _lines(path: Path) -> int:
    return len(path.read_text(encoding="utf-8", errors="replace").splitlines())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkout", nargs="?", type=Path, default=Path(__file__).resolve().parents[1])
    parser.add_argument("--words", nargs="+", default=CAUSES, metavar="WORD")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    if arguments.check:
        lines = excesses(arguments.checkout)
        print(*lines, sep="\n", end="\n" if lines else "")
        sys.exit(bool(lines))
    found = figures(arguments.checkout, tuple(arguments.words))
    if arguments.json:
        print(json.dumps(found, indent=2))
        return
    for number, (name, size) in enumerate(found.pop("packages").items()):
        if not number:
            print(f"{'package':16}", *(f"{head:>15}" for head in size))
        print(f"{name:16}", *(f"{value:>15}" for value in size.values()))
    for name, value in found.items():
        if isinstance(value, dict):
            print(f"{name}: {', '.join(f'{key} {count}' for key, count in value.items())}")
        elif isinstance(value, list):
            print(f"{name}: {len(value)}", *(f"  {item}" for item in value), sep="\n")
        else:
            print(f"{name}: {value}")


if __name__ == "__main__":
    main()
