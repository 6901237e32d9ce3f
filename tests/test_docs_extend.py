"""The first two files printed in docs/extend.md add a block of the path, from the fit to equal bits.

With `make prove`; tests/diagnosis/test_made_up_cause.py uses the same two files on every run.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

USE = """
import numpy as np
from hysgen import FitSettings, Record, cost, fit, generate, load_model, save_model, score, verify
from hysgen.checking.proof.eva.states import instance_words
from hysgen.model.path.kick import Kick

t_s = 1e-4 * np.arange(6000)  # sines: the steps of a triangle would all be of one size
u_V = 40.0 - 25.0 * np.cos(2.0 * np.pi * 37.0 * t_s) * np.cos(2.0 * np.pi * 3.0 * t_s)
y_um = np.full(u_V.size, 0.6)
for k in range(1, u_V.size - 1):
    kicked_V = u_V[k] + 0.1 * abs(u_V[k - 1] - u_V[k - 2] if k > 1 else 0.0)
    y_um[k + 1] = 0.9 * y_um[k] + 4e-3 * kicked_V
record = Record.from_arrays(u_V, y_um, 1e-4)
plain = fit(record, FitSettings(name="axis", method="batch"))
model = fit(record, FitSettings(name="axis", method="batch", blocks=(Kick(0.1),)))
assert score(model, record).free_run.e_rms_um < 0.1 * score(plain, record).free_run.e_rms_um
save_model(model, __import__("pathlib").Path("axis.json"))
assert load_model("axis.json").blocks == (Kick(0.1),)
report = verify(generate(model), samples=30_000)
assert report.equal and {run.function for run in report.runs} >= {"predict", "simulate", "inverse"}, str(report)
assert cost(generate(model)).per_sample.value > cost(generate(plain)).per_sample.value
proved = {word.path: word.demanded for word in instance_words(model, generate(model))}
assert proved["self.inputs.kick.last_V"].startswith("\\\\is_finite(self.inputs.kick.last_V)"), proved
print("equal in every bit")
"""


@pytest.mark.slow
@pytest.mark.proof
def test_the_two_files_of_the_page_are_all_that_a_new_block_takes(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "extend.md").read_text()
    blocks = re.findall(r"```(?:python|c)\n(.*?)```", page, re.DOTALL)
    shutil.copytree(ROOT / "generator" / "hysgen", tmp_path / "generator" / "hysgen")
    shutil.copytree(ROOT / "templates", tmp_path / "templates")
    (tmp_path / "generator" / "hysgen" / "model" / "path" / "kick.py").write_text(blocks[0])
    (tmp_path / "templates" / "path" / "kick.c.j2").write_text(blocks[1])
    done = subprocess.run(
        [sys.executable, "-c", USE],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path / "generator")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == "equal in every bit\n"
