"""An export is one file: written into a copy of the tree, it stands in the help, is exported and compared."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FILE = "generator/hysgen/export/stream.py"
ADDED = '''
"""A program that steps the component over standard input."""

from hysgen.export.base import Export, Option, output_of, results


def run_stream(model, folder, samples):
    output_of(["cc", "-o", "stream", "-Imodel", "-I.", "run.c", f"{model.name}_component.c",
               f"model/{model.name}.c"], folder)
    program = str((folder / "stream").resolve())
    return results(output_of([program, *samples.start], folder, samples.rows.tobytes()))


def finish(written):
    (written.folder / "GREETING").write_text(written.given["greeting"] + " from {{ name }}")
    return ["GREETING"]


EXPORT = Export(
    "stream", "Stream", {"run.c": "run.c", "{name}.txt": "{{ name }} at {{ Ts_us }} us\\n"},
    readme="Build run.c.\\n", ways={"cc": run_stream},
    options=(Option("greeting", "TEXT", "first line of the file GREETING"),), finish=finish,
)
'''


@pytest.mark.slow
def test_a_new_export_requires_one_file(tmp_path: Path) -> None:
    for folder in ("generator", "templates"):
        shutil.copytree(ROOT / folder, tmp_path / folder)
    assert not (tmp_path / FILE).exists()
    (tmp_path / FILE).write_text(ADDED)

    def hysgen(*words: str) -> str:
        done = subprocess.run(
            [sys.executable, "-m", "hysgen", "export", *words],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(tmp_path / "generator")},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert "--greeting TEXT" in hysgen("--help")
    said = hysgen("appendix_a", "--to", "stream", "-o", "out", "--greeting", "Hello", "--check", "300")
    assert "cc             inverse   300 samples, 0 differ" in said
    assert (tmp_path / "out" / "appendix_a.txt").read_text() == "appendix_a at 20 us\n"
    assert (tmp_path / "out" / "GREETING").read_text().startswith("Hello")
    readme = (tmp_path / "out" / "README.md").read_text()
    assert readme.startswith("# Stream of model `appendix_a`")
    assert readme.endswith("Build run.c.\n")
