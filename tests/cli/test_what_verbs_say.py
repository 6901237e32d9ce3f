"""Every line that a verb says, its numbers those of its JSON; every option changes what it is there for."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from hysgen.cli import main
from hysgen.stage.demo_record import bundled_csv


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two records of 40 ms, a model of three rules fitted to the first, and its C."""
    folder = tmp_path_factory.mktemp("verbs")
    head, *rows = bundled_csv().splitlines()
    (folder / "a.csv").write_text("\n".join([head, *rows[:2000]]) + "\n")
    (folder / "b.csv").write_text("\n".join([head, *rows[4000:6000]]) + "\n")
    assert main(["fit", f"{folder}/a.csv", "--method", "batch", "--rules", "3", "-o", f"{folder}/m.json", "-q"]) == 0
    assert main(["generate", f"{folder}/m.json", "-o", f"{folder}/c", "-q"]) == 0
    return folder


class Said:
    """Exit code, standard output and JSON of a call of the command line."""

    def __init__(self, call: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        path = folder / "said.json"
        words = [str(folder / word[1:]) if word.startswith("@") else word for word in call.split()]
        capsys.readouterr()
        self.code = main(["-q", *words, "--json", str(path), "--force"])
        captured = capsys.readouterr()
        self.out, self.err = captured.out.replace(f"{folder}/", ""), captured.err
        self.json: dict[str, Any] = json.loads(path.read_text())

    def lines(self, *patterns: str) -> None:
        """Each pattern matches a whole line, in this order."""
        rest = iter(self.out.splitlines())
        for pattern in patterns:
            assert any(re.fullmatch(pattern, line) for line in rest), f"{pattern}\n{self.out}"


def test_verify_says_what_was_compared_and_an_altered_file_is_code_1(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = Said("verify @c --samples 1200 --structures 0 --seed 5", folder, capsys)
    assert (said.code, said.json["equal"]) == (0, True)
    assert 21_200 <= said.json["samples"] <= 21_212, "20 000 of `limits`; shares are rounded up"
    said.lines(rf"m: equal in every bit over {said.json['samples']} samples per build, [\d.]+ s")
    header = folder / "c/m.h"
    intact = header.read_text()
    header.write_text(intact + "\n")
    altered = Said("verify @c --samples 1200 --structures 0", folder, capsys)
    header.write_text(intact)
    assert (altered.code, altered.json["equal"]) == (1, False)
    altered.lines(r"ALTERED: c/m\.h: .*", "m: NOT EQUAL over .*")


def test_score_sets_models_beside_each_other_and_describe_says_every_part(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = Said("score @m.json @b.csv --rows 100: --settle 50 --beside appendix_a", folder, capsys)
    rows = {"m": said.json, "appendix_a": said.json["beside"]["appendix_a"]}
    for name in ("appendix_a", "m"):
        said.lines("beside each other", rf"{name}, free run +{rows[name]['free_run']['e_rms_um']:.5f} .*")
        said.lines("beside each other", rf"{name}, one step +{rows[name]['one_step']['e_rms_um']:.5f} .*")
    assert Said("score @m.json @b.csv", folder, capsys).json["free_run"] != said.json["free_run"]
    told = Said("describe extended", folder, capsys)
    certificates = told.json["certificates"]
    told.lines(
        "extended: .*", r"path: hysteresis: .*", r"path: creep: .*", r"gain .*: holds", r"slope at most .*", ".*"
    )
    assert re.search(rf"^gain {certificates['gain']['lowest']['value']:.4g} ", told.out, re.M)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("verify @c --machine arm", "--machine"),
        ("verify @c --updates 5", "--updates belongs to --target c674x; add it"),
        ("verify @c --fused", "--machine and --fused: they belong to --target emulated; add it"),
        ("cost @c --budget x.json", "--budget FILE belongs to --target c674x"),
        ("cost @c --target c674x --update-budget", "--update-budget to --budget; add what is missing"),
        ("generate @m.json -o x --assembler ti", "add --kernels c674x"),
        ("generate @m.json -o x --clock 0", "--clock and --budget are positive"),
        ("generate @m.json -o x --budget 0", "--clock and --budget are positive"),
        ("generate @m.json -o x --cycles predict", "'predict' is not FUNCTION=N"),
        ("generate @m.json -o x --cycles predict=-1", "'predict=-1' is not FUNCTION=N"),
        ("prove @c --only bits", "bits"),
    ],
)
def test_options_that_do_not_belong_together_are_refused(
    call: str, message: str, folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    try:
        code: Any = main([str(folder / word[1:]) if word.startswith("@") else word for word in call.split()])
    except SystemExit as left:
        code = left.code
    error = capsys.readouterr().err
    assert (code, error.count("\n")) == (2, 1)
    assert message in error
    assert not (folder / "x").exists()
