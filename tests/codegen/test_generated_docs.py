"""The comments of generated C are its reference: Doxygen finds every public name documented, warnings are errors."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from fixtures import proof_models as proof_models
from fixtures.tools import need
from hysgen.codegen import write

DOXYFILE = """
QUIET = YES
WARN_IF_UNDOCUMENTED = YES
WARN_NO_PARAMDOC = YES
WARN_AS_ERROR = FAIL_ON_WARNINGS
OPTIMIZE_OUTPUT_FOR_C = YES
JAVADOC_AUTOBRIEF = YES
GENERATE_LATEX = NO
HAVE_DOT = NO
INPUT = c
OUTPUT_DIRECTORY = out
"""


def doxygen(folder: Path) -> subprocess.CompletedProcess[str]:
    need("doxygen")
    (folder / "Doxyfile").write_text(DOXYFILE)
    return subprocess.run(["doxygen"], cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("name", ["appendix_a", "extended", "everything"])
@pytest.mark.slow
def test_generated_c_is_documented_for_doxygen(name: str, tmp_path: Path) -> None:
    write(proof_models.texts(name), tmp_path / "c")
    done = doxygen(tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    pages = "".join(page.read_text() for page in (tmp_path / "out" / "html").glob("*.html"))
    for function in ("init", "predict", "simulate", "inverse", "selftest"):
        assert f"{name}_{function}" in pages


def test_a_parameter_without_a_word_is_found(tmp_path: Path) -> None:
    texts = dict(proof_models.texts("appendix_a"))
    texts["appendix_a.h"] = texts["appendix_a.h"].replace(" * @param u_V   input that acts [V] */", " */")
    write(texts, tmp_path / "c")
    done = doxygen(tmp_path)
    assert done.returncode != 0
    assert "u_V" in done.stderr
