"""The comments of generated C are its reference: Doxygen finds every public name documented, warnings are errors."""

import dataclasses
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from fixtures import proof_models as proof_models
from fixtures.tools import need
from hysgen.codegen.manifest import write
from hysgen.float32.coefficients import coefficients
from hysgen.float32.learner_numbers import learner_numbers
from hysgen.float32.reference.instance import Instance
from hysgen.float32.reference.learner import Learner
from hysgen.model.file import load_model
from hysgen.model.learner_settings import BIAS, GROUPS, LearnerSettings

LEARNING = Path(__file__).parents[2] / "docs" / "learning.md"

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


@pytest.mark.parametrize(("option", "learned"), [("rules", GROUPS), ("gain", ("gain",)), ("bias", BIAS)])
def test_the_table_of_learned_parameters_says_where_each_stands(option: str, learned: tuple[str, ...]) -> None:
    rows = re.findall(
        rf"^\| `{option}` \| (.+?) \| .+? \| (.+?) \|", LEARNING.read_text(encoding="utf-8"), re.MULTILINE
    )
    model = dataclasses.replace(load_model("appendix_a"), learner=LearnerSettings(learned=learned))
    numbers = coefficients(model)
    found = learner_numbers(model, numbers)
    step = len(rows)
    for j, parameter in enumerate(found.parameters):
        place, member = rows[j % step]
        expected = {"3 l": 3 * (j // 3), "l": j, "0": 0}.get(place.split(" + ")[0], -1)
        assert expected + int((*place.split(" + "), "0")[1]) == j
        assert member == (parameter.group if parameter.group != "bias" else "-")
    if learned == BIAS:
        return
    # theta_j is scale_j times the parameter times the strength of its rule.
    lane = np.full(1, 1.0, np.float32)
    theta = np.array(Learner(model, Instance(model, lane, 20.0 * lane)).theta).ravel()
    columns = {"slope": 0, "gain": 1, "offset": 2}
    q = np.array([model.consequents[p.index, columns[p.group]] for p in found.parameters])
    strength = np.array([numbers.strength[p.index] for p in found.parameters])
    assert theta == pytest.approx(found.scale * q * strength, rel=1e-6)
