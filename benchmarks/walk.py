"""How far a reader walks through the source on three ways: `python benchmarks/walk.py [CHECKOUT]`, from the text alone.

The reader follows every call in the order of the text, depth first, and reads each function once; a class stands for
its methods, in the order of the text. A stay is an unbroken run of functions in one module; a return is a stay in a
module that was read before. Calls that only the running program resolves (registries, methods of unknown objects) are
not followed.
"""

from __future__ import annotations

import ast
import itertools
import sys
from collections.abc import Iterator
from pathlib import Path

WAYS = {
    "record -> Record": ("record.read.load_record",),
    "record -> causes": ("api.diagnosing.diagnose", "api.diagnose"),
    "model -> C": ("codegen.generate",),
}
"""Way -> its first function, below `hysgen`, under its present name and earlier ones."""

Place = tuple[str, str]
"""Module and name of a function or class in it."""


class Source:
    """The functions, classes and imports of a package."""

    def __init__(self, package: Path) -> None:
        self.bodies: dict[Place, ast.AST] = {}
        self.names: dict[str, dict[str, Place]] = {}
        for path in sorted(package.rglob("*.py")):
            parts = (package.name, *path.relative_to(package).with_suffix("").parts)
            module = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            tree = ast.parse(path.read_text(encoding="utf-8"))
            names = self.names.setdefault(module, {})
            for node in ast.walk(tree):
                if isinstance(node, ast.ImportFrom) and node.module:
                    names |= {alias.asname or alias.name: (node.module, alias.name) for alias in node.names}
            for node in tree.body:
                if isinstance(node, ast.FunctionDef | ast.ClassDef):
                    self.bodies[module, node.name] = node
                    names[node.name] = (module, node.name)

    def resolved(self, module: str, name: str) -> Place | None:
        """The definition of a name in a module, through modules that only hand it on."""
        place = self.names.get(module, {}).get(name)
        while place and place not in self.bodies:
            follower = self.names.get(place[0], {}).get(place[1])
            place = None if follower in (None, place) else follower
        return place

    def calls(self, module: str, body: ast.AST) -> Iterator[Place]:
        """The definitions that a body names, in the order of the text."""
        nodes = [node for node in ast.walk(body) if isinstance(node, ast.Name | ast.Attribute)]
        for node in sorted(nodes, key=lambda node: (node.lineno, node.col_offset)):
            place = None
            if isinstance(node, ast.Name):
                place = self.resolved(module, node.id)
            elif isinstance(node.value, ast.Name):
                owner = self.names[module].get(node.value.id)
                place = self.resolved(".".join(owner), node.attr) if owner else None
            if place:
                yield place

    def walk(self, start: Place) -> list[str]:
        """The module of every function that is read, in this order."""
        read: dict[Place, None] = {}

        def visit(place: Place) -> None:
            if place not in read:
                read[place] = None
                for callee in self.calls(place[0], self.bodies[place]):
                    visit(callee)

        visit(start)
        return [module for module, _ in read]


def main() -> None:
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[1]
    sys.setrecursionlimit(10_000)
    source = Source(root / "generator" / "hysgen")
    print(f"{'way':20}{'functions':>10}{'modules':>9}{'stays':>7}{'returns':>9}")
    for way, starts in WAYS.items():
        places = [source.resolved(f"hysgen.{module}", name) for module, _, name in (s.rpartition(".") for s in starts)]
        modules = source.walk(next(place for place in places if place))
        stays, places_read = sum(1 for _ in itertools.groupby(modules)), len(set(modules))
        print(f"{way:20}{len(modules):>10}{places_read:>9}{stays:>7}{stays - places_read:>9}")


if __name__ == "__main__":
    main()
