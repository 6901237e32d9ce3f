"""Every line that a verb says, its numbers those of its JSON; every option changes what it is there for.

inspect says what a file holds, and which causes its excitation can show.
"""

import dataclasses
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hysgen.cli import main
from hysgen.model.disturbances.drift import Drift
from hysgen.model.file import load_model, save_model
from hysgen.record import Record, record_csv
from hysgen.record.read import bundled_csv


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


@pytest.mark.slow
def test_refit_says_scores_changes_verdict_files_and_time(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = Said("refit @m.json @b.csv -o @n.json", folder, capsys)
    rms = said.json["scores"]["free_run"]["e_rms_um"]
    gain = next(each for each in said.json["comparison"]["changes"] if each["what"] == "DC gain, mid-range")
    said.lines(
        rf"free run +{rms:.5f} .*",
        rf"DC gain, mid-range \[um/V\] +{gain['old']:.5g}0* +{gain['new']:.5g}0* +{gain['percent']:+.1f} %",
        "structure: " + re.escape(said.json["why"]),
        "written: n.json",
        rf"{said.json['seconds']} s from record to answer",
    )
    assert said.code == 0
    diff = Said("diff @m.json @n.json --records @a.csv @b.csv", folder, capsys)
    (_, second) = diff.json["free_run_rms_um"]
    diff.lines("m.json -> n.json +old +new +change")
    shown = re.findall(r"^free run on b.csv \[um rms\] +(\S+) +(\S+)$", diff.out, re.M)
    assert [float(number) for number in shown[0]] == pytest.approx([second["old"], second["new"]], rel=1e-3)
    assert second["new"] == pytest.approx(rms, rel=0.2)
    # A model of the first record that was fitted far better than today's second one: the structure no longer fits.
    good = json.loads((folder / "m.json").read_text())
    good["scores"]["identification"]["free_run"]["of_span_percent"] = 0.01
    (folder / "good.json").write_text(json.dumps(good))
    refused = Said("refit @good.json @b.csv -o @never.json --no-diagnosis", folder, capsys)
    refused.lines("structure: .*", r"nothing is written \(--anyway writes the model all the same\)", r".* to answer")
    assert (refused.code, (folder / "never.json").exists()) == (1, False)


def test_generate_check_and_cost_follow_every_option(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = Said(
        "generate @m.json -o @o --no-inverse --clock 3e8 --cycles predict=99 --input-range 20 40", folder, capsys
    )
    for name, size in said.json["files"].items():
        assert (folder / "o" / name).stat().st_size == size
        said.lines(re.escape(f"written: o/{name} ({size} bytes)"))
    facts = json.loads((folder / "o/MANIFEST.json").read_text())
    assert facts["options"] == {"inverse": False, "clock_Hz": 3e8}
    assert facts["cost"]["cycles"]["predict"] == {"value": 99, "measured": True}
    header = (folder / "o/m.h").read_text()
    assert ("m_inverse(" in header, "m_predict(" in header) == (False, True)
    model = json.loads((folder / "o/m.json").read_text())
    assert sorted(model["input_range_V"] if "input_range_V" in model else [model["u_min_V"], model["u_max_V"]]) == [
        20,
        40,
    ]
    cost = Said("cost @o", folder, capsys)
    assert (cost.json["budget"], cost.code) == (6000, 0)
    stale = Said("generate @m.json -o @o --check", folder, capsys)
    assert (stale.code, stale.json["up_to_date"]) == (1, False)
    stale.lines(r"stale: o/m\.h: differs from line \d+ on", rf"o: {len(stale.json['stale'])} of 10 files are stale; .*")
    fresh = Said("generate @m.json -o @c --check", folder, capsys)
    fresh.lines("c: all 10 files are up to date")
    assert (fresh.code, fresh.json["up_to_date"], fresh.json["stale"]) == (0, True, [])


def test_verify_says_what_was_compared_and_an_altered_file_is_code_1(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = Said("verify @c --samples 1200 --seed 5", folder, capsys)
    assert (said.code, said.json["equal"]) == (0, True)
    assert 21_200 <= said.json["samples"] <= 21_212, "20 000 of `limits`; shares are rounded up"
    said.lines(rf"m: equal in every bit over {said.json['samples']} samples per build, [\d.]+ s")
    header = folder / "c/m.h"
    intact = header.read_text()
    header.write_text(intact + "\n")
    altered = Said("verify @c --samples 1200", folder, capsys)
    header.write_text(intact)
    assert (altered.code, altered.json["equal"]) == (1, False)
    altered.lines(r"ALTERED: c/m\.h: .*", "m: NOT EQUAL over .*")


@pytest.mark.slow
def test_compare_scores_models_on_the_same_records_and_describe_says_every_part(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = Said("compare appendix_a @m.json @b.csv --rows 100:", folder, capsys)
    assert list(said.json["models"]) == ["appendix_a", "m"]
    alone = Said("score @m.json @b.csv --rows 100:", folder, capsys).json
    assert said.json["models"]["m"] == {key: alone[key] for key in said.json["models"]["m"]}
    assert main(["compare", f"{folder}/m.json", f"{folder}/a.csv"]) == 0
    assert "warning: m: a.csv: is the record that was fitted;" in capsys.readouterr().err
    own = {}
    for name, scores in said.json["models"].items():
        free, own[name], ahead = (scores[key]["e_rms_um"] for key in ("free_run", "own", "one_step"))
        said.lines(rf"{name} +{free:.5f} +{own[name]:.5f} +{ahead:.5f} .*", "persistence .*", "least own error: m")
    assert said.json["best"] == min(own, key=lambda name: own[name])
    twice = Said(f"compare @m.json {folder}/c/../m.json @a.csv @b.csv", folder, capsys)
    assert len(twice.json["models"]) == 2, "models of one stem have their paths as names"
    assert main(["compare", "appendix_a", f"{folder}/m.json"]) == 2
    assert "2 models and 0 records given" in capsys.readouterr().err
    page, picture = folder / "page.html", folder / "picture.png"
    Said("compare appendix_a @m.json @b.csv --report @page.html", folder, capsys).lines("written: page.html")
    assert "appendix_a, m on b.csv" in page.read_text(encoding="utf-8")
    Said("score @m.json @b.csv --plot @picture.png --report @page.html", folder, capsys).lines(
        "written: page.html", "written: picture.png"
    )
    assert picture.read_bytes().startswith(b"\x89PNG")
    model = load_model("appendix_a")
    save_model(dataclasses.replace(model, terms=(Drift(0.01, 0.05),), weights=np.ones(1)), folder / "d.json")
    Said("describe @d.json", folder, capsys).lines("disturbance: drift: drift followed over 0.01 s, .*")
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
        ("generate @m.json -o x --assembler ti", "add --kernels c674x"),
        ("generate @m.json -o x --clock 0", "--clock and --budget are positive"),
        ("generate @m.json -o x --budget 0", "--clock and --budget are positive"),
        ("generate @m.json -o x --cycles predict", "'predict' is not FUNCTION=N"),
        ("generate @m.json -o x --cycles predict=-1", "'predict=-1' is not FUNCTION=N"),
        ("prove @c --only bits", "bits"),
        ("verify @c --prove --target c674x", "leave one of them out"),
        ("fit @a.csv --relaxation -o x", "--relaxation: is a property of the hysteresis; give --memory too"),
        ("diagnose @a.csv --drift-since 5nm -o x", "state both"),
        ("experiment @a.csv --range 0..120 -o x.csv", "--range '0..120' is not LOW:HIGH in V, as 0:120"),
        ("experiment @a.csv --range 0:x -o x.csv", "--range '0:x' is not LOW:HIGH in V, as 0:120"),
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


TS_S = 1e-4


def test_inspect_prints_rate_ranges_noise_and_requirements_and_writes_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("r.csv").write_text(bundled_csv())
    assert main(["inspect", "r.csv", "--rows", "0s:0.2s", "--json", "i.json", "--plot", "i.png"]) == 0
    shown = capsys.readouterr().out
    for phrase in ("10000 samples at 50 kHz, 0.2 s", "noise: 0.000", "swings of", "memory", "what would show"):
        assert phrase in shown
    told = json.loads(Path("i.json").read_text())
    assert (told["schema"], told["version"], told["samples"]) == ("hysgen-inspect", 1, 10_000)
    assert Path("i.png").read_bytes().startswith(b"\x89PNG")
    # A record that hysgen writes is read without a remark.
    Path("again.csv").write_text(record_csv(Record.from_arrays(np.arange(300.0) % 70, np.arange(300.0) % 60, TS_S)))
    assert main(["inspect", "again.csv"]) == 0
    assert "read as" not in capsys.readouterr().err
