"""The house: no import hides in a string, the model alone simulates, the product stands alone, a target is one file."""

import ast
import functools
import json
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

GENERATOR = Path(__file__).parents[1] / "generator"
IMPORTING = {"import_module", "__import__", "find_spec", "find_module", "resolve_name", "run_module", "files"}
WITHOUT = """
import sys

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name in ("hysgen_c674x", "hysgen_lab"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Missing())
"""
"""Makes the plug-in and the laboratory unimportable, as where they are not installed."""


@functools.cache
def packages() -> set[str]:
    return {path.name for path in GENERATOR.iterdir() if (path / "__init__.py").is_file()}


def is_module(name: str) -> bool:
    """Whether a text names a module below generator/, or a package there."""
    if not re.fullmatch(r"\w+(\.\w+)*", name) or name.split(".")[0] not in packages():
        return False
    path = GENERATOR.joinpath(*name.split("."))
    return "." in name and (path.is_dir() or path.with_suffix(".py").is_file())


def hidden_imports(source: str) -> Iterator[str]:
    """Texts that name a module, docstrings excepted, and calls that import by a text that starts with a package."""
    nodes = list(ast.walk(ast.parse(source)))
    said = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    for node in nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in said:
            if is_module(node.value):
                yield node.value
        elif isinstance(node, ast.Call) and node.args:
            called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            text = node.args[0].values[0] if isinstance(node.args[0], ast.JoinedStr) else node.args[0]
            first = text.value if isinstance(text, ast.Constant) else ""
            if called in IMPORTING and isinstance(first, str) and first.split(".")[0] in packages():
                yield ast.unparse(node)


def test_no_import_hides_in_a_string() -> None:
    hidden = {
        str(path.relative_to(GENERATOR)): texts
        for path in sorted(GENERATOR.rglob("*.py"))
        if (texts := [text for text in hidden_imports(path.read_text(encoding="utf-8")) if text != "hysgen.targets"])
    }
    assert hidden == {}, "import it in the function that needs it; hysgen/upward.py serves methods of a lower entry"


@pytest.mark.parametrize(
    "planted",
    [
        'importlib.import_module("hysgen.model.file")',
        'ROOM = "hysgen.report.plots.results"\nimportlib.import_module(ROOM)',
        '__import__("hysgen")',
        'importlib.import_module(f"hysgen.{room}")',
        'resources.files("hysgen")',
        'ROOMS = {"plots": "hysgen.report.plots"}',
    ],
)
def test_a_hidden_import_is_found(planted: str) -> None:
    assert list(hidden_imports(planted))


def modules_after(code: str) -> set[str]:
    """Names of the modules of hysgen that a fresh process has imported after `code`."""
    code += "\nimport json, sys; print(json.dumps([name for name in sys.modules if name.startswith('hysgen')]))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(json.loads(done.stdout.splitlines()[-1]))


def test_simulation_and_prediction_in_float64_import_the_model_alone() -> None:
    code = "import hysgen; model = hysgen.load_model('appendix_a'); model.simulate([0.0, 10.0, 20.0])"
    names = modules_after(f"{code}; model.predict([0.7, 0.8, 0.9], [0.0, 10.0, 20.0]); model.to_json()")
    rooms = {name.split(".")[1] for name in names if "." in name}
    assert {"model", "record"} <= rooms <= {"display", "errors", "machine", "model", "record", "upward"}
    assert names == modules_after("import hysgen; hysgen.load_model('appendix_a')"), "the first call imports more"


@pytest.mark.slow
def test_a_name_of_the_interface_imports_what_it_needs() -> None:
    everything = modules_after("import hysgen.api.code, hysgen.api.diagnosing")
    assert len(modules_after("import hysgen; hysgen.load_record")) < len(everything) / 4
    assert modules_after("import hysgen") == {"hysgen", "hysgen.upward"}


@pytest.mark.slow
def test_the_demo_needs_the_product_alone(tmp_path: Path) -> None:
    """On the first rows of its record; `make run` takes all of them."""
    code = (
        f"{WITHOUT}from hysgen.cli import main\nfrom hysgen.cli.verbs import demo\n"
        "text = ''.join(demo.bundled_csv().splitlines(keepends=True)[:6001])\n"
        "demo.bundled_csv, demo.IDENTIFICATION_ROWS = lambda: text, 4000\n"
        "sys.exit(main(['demo', '-o', 'out', '--samples', '2000']))"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "report.html").is_file()


@pytest.mark.parametrize(
    "words",
    [
        ["generate", "appendix_a", "-o", "c", "--kernels", "c674x"],
        ["verify", "c", "--target", "c674x"],
        ["cost", "c", "--target", "c674x"],
    ],
)
@pytest.mark.slow
def test_a_target_that_is_not_installed_is_one_line_that_says_what_to_install(words: list[str], tmp_path: Path) -> None:
    code = f"{WITHOUT}from hysgen.cli import main\nsys.exit(main({words}))"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "c674x: this target is in the package hysgen_c674x, which is missing; install hysgen whole" in line


CORTEX = '''
"""A Cortex-M4: estimates from the cycles of its operations."""
from hysgen.codegen.operations import Weights
from hysgen.targets import Target
TARGET = Target("cortexm4", about="nothing yet", weights=Weights("Cortex-M4", 30.0, 1.5, 3.0, {}))
'''


@pytest.mark.slow
def test_a_new_target_is_one_file(tmp_path: Path) -> None:
    for name in ("generator", "templates"):
        shutil.copytree(GENERATOR.parent / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "generator" / "hysgen" / "targets" / "cortexm4.py").write_text(CORTEX)
    code = (
        f"import sys; sys.path.insert(0, {str(tmp_path / 'generator')!r})\n"
        "from hysgen.cli import main\n"
        "assert main(['generate', 'appendix_a', '-o', 'c']) == 0\n"
        "sys.exit(main(['cost', 'c', '--target', 'cortexm4']))"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    head = next(line for line in done.stdout.splitlines() if line.startswith("function"))
    assert "Cortex-M4" in head
    assert "C674x" not in head


@pytest.mark.parametrize(
    ("planted", "said"),
    [
        ("found = 1\n", "hysgen/plain: 1 names say nothing, 0 are allowed: plain.py:1 found"),
        ("def one(each): ...\n", "hysgen/plain: 2 names say nothing, 0 are allowed: plain.py:1 each, plain.py:1 one"),
        ("left, right = 1, 2\n", ""),
        ("a = 1\n" * 21, "hysgen: 21 lines, the budget is 20: delete as much as you add"),
    ],
)
def test_style_refuses_a_pronoun_as_a_name_and_a_package_above_its_budget(
    planted: str, said: str, tmp_path: Path
) -> None:
    for name in ("hysgen/__init__.py", "hysgen/plain.py"):
        (tmp_path / "generator" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "generator" / name).write_text(planted if "plain" in name else "")
    limits = "[tool.house.budget]\nhysgen = { lines = 20, files = 2 }\n[tool.house.pronouns]\n"
    (tmp_path / "pyproject.toml").write_text(limits)
    done = subprocess.run(
        [sys.executable, str(GENERATOR.parent / "benchmarks" / "house.py"), str(tmp_path), "--check"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.stdout.strip(), done.returncode) == (said, bool(said)), done.stderr
