"""The command line: from record to C, JSON, exit codes, one-line errors."""

import json
from pathlib import Path

import numpy as np
import pytest

from hysgen.cli import main
from hysgen_lab.stage import Stage, run
from hysgen_lab.stage.signals import nested_amplitudes

TS_S = 1e-4


@pytest.fixture(scope="session")
def record(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A record of the virtual stage at 10 kHz: nested loops at two frequencies, twice."""
    u_V = nested_amplitudes(TS_S, (50.0, 20.0), 40.0, 25.0, 4)
    measured = run(Stage.nominal(), np.concatenate([u_V, u_V]), TS_S, seed=7)
    lines = [
        f"{t:.4f},{u:.6f},{y:.5f}"
        for t, u, y in zip(measured.time_s, measured.voltage_V, measured.displacement_um, strict=True)
    ]
    path = tmp_path_factory.mktemp("record") / "stage.csv"
    path.write_text("\n".join(["time_s,voltage_V,displacement_um", *lines]) + "\n")
    return path


@pytest.fixture(scope="session")
def model(record: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "axis one.json"
    assert main(["fit", str(record), "--rows", "0:6000", "--memory", "-o", str(path)]) == 0
    return path


@pytest.mark.slow
def test_a_record_becomes_a_scored_model_and_its_c(
    record: Path, model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scores = tmp_path / "scores.json"
    call = ["score", str(model), str(record), "--rows", "6000:", "--rivals", "0:6000", "--json", str(scores)]
    assert main(call) == 0
    shown = capsys.readouterr().out
    for line in ("free run", "one step", "persistence", "noise floor", "Prandtl-Ishlinskii"):
        assert line in shown
    told = json.loads(scores.read_text())
    rivals = told["rivals_free_run"]
    assert told["free_run"]["e_rms_um"] < rivals["Prandtl-Ishlinskii, 20 plays"]["e_rms_um"]
    assert told["free_run"]["e_rms_um"] < rivals["paper's model"]["e_rms_um"]
    assert main(["generate", str(model), "-o", str(tmp_path / "c")]) == 0
    # The name of the model is the name of its file as a C identifier.
    assert {"axis_one.h", "axis_one.c", "axis_one_params.h"} <= {path.name for path in (tmp_path / "c").iterdir()}


@pytest.mark.slow
def test_a_model_worse_than_the_papers_is_said_first(
    record: Path, model: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """The path of the model gets twice the voltage that it was fitted to."""
    loud, good = tmp_path / "loud.csv", [line.split(",") for line in record.read_text().splitlines()]
    loud.write_text("\n".join([",".join(good[0]), *(f"{t},{float(u) / 2.0!r},{y}" for t, u, y in good[1:])]) + "\n")
    for file, worse in ((loud, True), (record, False)):
        capfd.readouterr()
        assert main(["score", str(model), str(file), "--rows", "6000:", "--rivals", "0:6000"]) == 0
        said = " ".join(capfd.readouterr().err.split())
        assert ("the model is worse than the paper's model, fitted to rows 0:6000" in said) == worse


@pytest.mark.slow
def test_a_learner_is_asked_for_when_fitting_or_when_generating(record: Path, model: Path, tmp_path: Path) -> None:
    """--learn generates `_learn` and `_commit` for the parameters that it names; --learn none removes them."""
    learning = tmp_path / "learning.json"
    fit = ["fit", str(record), "--method", "batch", "--learn", "bias", "--learn-noise", "0.001", "-o", str(learning)]
    assert main(fit) == 0
    settings = json.loads(learning.read_text())["learner"]
    assert (settings["learned"], settings["noise_um"]) == (["bias"], 0.001)
    calls = {"kept": (learning, []), "none": (learning, ["--learn", "none"]), "gain": (model, ["--learn", "gain"])}
    for name, (path, options) in calls.items():
        assert main(["generate", str(path), *options, "-o", str(tmp_path / name)]) == 0
    assert "#define LEARNING_LEARNED 1u " in (tmp_path / "kept" / "learning.h").read_text()
    assert "_learn(" not in (tmp_path / "none" / "learning.h").read_text()
    assert "#define AXIS_ONE_LEARNED 6u " in (tmp_path / "gain" / "axis_one.h").read_text()


def test_the_same_call_writes_the_same_bytes(record: Path, tmp_path: Path) -> None:
    for name in ("first", "second"):
        assert main(["fit", str(record), "--method", "batch", "--name", "m", "-o", str(tmp_path / f"{name}.json")]) == 0
    assert (tmp_path / "first.json").read_bytes() == (tmp_path / "second.json").read_bytes()


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (["fit", "no-such-file.csv", "-o", "x.json"], "no-such-file.csv"),
        (["fit", "{record}", "--rows", "9000:10", "-o", "x.json"], "rows: '9000:10'"),
        (["fit", "{record}", "--forgetting", "1.5", "-o", "x.json"], "forgetting: 1.5"),
        (["fit", "{record}", "--columns", "speed=u_V", "-o", "x.json"], "speed"),
        (["score", "{record}", "{record}"], "stage.csv"),
        (["score", "no_such_model", "{record}"], "no_such_model"),
        (["describe", "appendix_z"], "appendix_z"),
        (["generate", "appendix_a"], "-o"),
        (["generate", "appendix_a", "--learn", "rules", "--learn-forgetting", "1.5", "-o", "x"], "forgetting 1.5"),
        (["polish"], "hysgen polish: polish: is no verb"),
        (["fti", "{record}"], "fti: is no verb (did you mean 'fit'?)"),
        (["fit", "{record}", "--memory", "1000", "-o", "x.json"], "--memory 1000: is not supported; choose 0 to 64"),
        (["fit", "{record}", "--memory", "-1", "-o", "x.json"], "--memory -1: is not supported; choose 0 to 64"),
        (["fit", "{record}", "--time", "t", "-o", "x.json"], "columns are named by --columns time=NAME"),
        (["fit", "{record}", "time=t", "-o", "x.json"], "columns are named by --columns time=t"),
        (["cost", "{record}"], "is a file; give the folder that hysgen generate wrote"),
    ],
)
def test_every_error_of_the_user_is_one_line_and_exit_code_2(
    call: list[str],
    told: str,
    record: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    try:
        code = main([word.format(record=record) for word in call])
    except SystemExit as exit_:  # argparse leaves by itself
        code = exit_.code
    captured = capsys.readouterr()
    assert code == 2
    assert captured.err.count("\n") == 1, captured.err
    assert told in captured.err
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_is_reported_and_leaves_no_partial_file(
    record: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("hysgen.cli.verbs.fit.fit", interrupted)
    assert main(["fit", str(record), "-o", str(tmp_path / "m.json")]) == 130
    assert "interrupted" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
