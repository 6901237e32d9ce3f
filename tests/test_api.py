"""The Python interface: one import, results as text and HTML, pictures on request."""

import importlib
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import hysgen
from fixtures.bank_records import record_of
from fixtures.tools import library
from hysgen.checking.proof import CheckSettings
from hysgen.cli.verbs import NAMES
from hysgen.display import Displayed
from hysgen.firmware import Label
from hysgen.report.plots.results import Drawing
from hysgen_lab.stage import Stage, run
from hysgen_lab.stage.signals import nested_amplitudes

TS_S = 1e-4


@pytest.fixture(scope="module")
def record() -> hysgen.Record:
    u_V = nested_amplitudes(TS_S, (50.0, 20.0), 40.0, 25.0, 4)
    y_um = run(Stage.nominal(), u_V, TS_S, seed=7).displacement_um
    return hysgen.Record.from_arrays(u_V, y_um, TS_S, source="<axis & one>")


@pytest.fixture(scope="module")
def model(record: hysgen.Record) -> hysgen.Model:
    return hysgen.fit(record, memory=True)


@pytest.fixture(scope="module")
def results(record: hysgen.Record, model: hysgen.Model) -> dict[str, Displayed]:
    code = hysgen.generate(model)
    return {
        "record": record,
        "model": model,
        "scores": hysgen.score(model, record),
        "code": code,
        "report": hysgen.verify(code, samples=2000),
        "cost": hysgen.cost(code),
    }


@pytest.mark.slow
def test_names_of_the_api_stand_at_the_top_and_are_loaded_when_they_are_used() -> None:
    code = (
        "import sys, hysgen; assert 'numpy' not in sys.modules, 'loaded too early'\n"
        "import hysgen.fitting.settings, hysgen.checking.bits, hysgen.checking.cost, hysgen.diagnosis\n"
        "from hysgen import fit, score, diagnose, generate, verify, load_record, cost\n"
        "from hysgen.fitting import FitSettings\n"
        "assert all(callable(f) for f in (fit, score, diagnose, generate, verify, load_record, cost))\n"
        "assert hysgen.FitSettings is FitSettings\n"
        "assert hysgen.fit is fit and 'diagnose' in dir(hysgen)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_every_result_shows_itself_on_one_line_as_text_and_as_html(results: dict[str, Displayed]) -> None:
    for name, result in results.items():
        assert "\n" not in repr(result), name
        assert str(result).startswith(result.summary().title), name
        assert len(str(result).splitlines()) > 2, name
        page = result._repr_html_()
        opened: list[str] = []
        reader = HTMLParser()
        reader.handle_starttag = lambda tag, _, opened=opened: opened.append(tag)  # type: ignore[method-assign]
        reader.feed(page)
        assert {"table", "th", "td"} <= set(opened), name
        assert page.count("<td>") == page.count("</td>"), name
        # The name of a record is chosen by the user and may hold any characters.
        assert "axis & one" not in page, name


def test_dynamics_certificates_and_comparison_are_printed_as_text_with_one_line_as_repr() -> None:
    model = hysgen.load_model("appendix_a")
    for result in (hysgen.describe(model), hysgen.certificates(model), hysgen.diff(model, model)):
        assert "\n" not in repr(result)
        assert len(repr(result)) < 200
        assert len(str(result).splitlines()) > 2
        assert max(map(len, str(result).splitlines())) < 200
        assert "<p><strong>" in result._repr_html_()


def test_results_say_what_matters(results: dict[str, Displayed], record: hysgen.Record) -> None:
    assert f"{record.samples} samples at 10 kHz" in repr(results["record"])
    assert "8 plays of degree 3" in str(results["model"])
    assert "equal in every bit" in repr(results["report"])
    assert "stage.h" in str(results["code"])
    assert "cycles" in repr(results["cost"])


@pytest.mark.parametrize("name", ["record", "model", "scores", "cost"])
def test_results_plot_on_request(name: str, results: dict[str, Displayed], tmp_path: Path) -> None:
    drawing = results[name].plot()
    assert isinstance(drawing, Drawing)
    assert drawing._repr_png_().startswith(b"\x89PNG")
    assert drawing.save(tmp_path / "p.svg").read_text().startswith("<?xml")


def test_model_plots_its_free_run_beside_the_record(model: hysgen.Model, record: hysgen.Record) -> None:
    assert len(model.plot(record).figure.axes) == 2


def test_nothing_to_plot_and_no_matplotlib_are_told_in_one_line(
    results: dict[str, Displayed], monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(hysgen.HysgenError, match="nothing to plot"):
        results["report"].plot()
    for name in [name for name in sys.modules if name.startswith(("matplotlib", "hysgen.report.plots"))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(hysgen.HysgenError, match="matplotlib is not installed; pip install matplotlib"):
        results["record"].plot()


def test_code_is_written_and_read_back(results: dict[str, Displayed], tmp_path: Path) -> None:
    code = results["code"]
    assert isinstance(code, hysgen.Generated)
    assert (dict(code), list(code), len(code)) == (dict(code.texts), [*code.texts], len(code.texts))
    folder = code.write(tmp_path / "c")
    assert (folder / "stage.h").read_text() == code["stage.h"]
    assert hysgen.verify(folder, samples=2000).equal
    assert hysgen.cost(folder).budget == 37500  # 100 us at 375 MHz


@pytest.mark.slow
def test_diagnosis_shows_its_ladder_and_draws_what_is_asked_for() -> None:
    study = hysgen.diagnose(record_of("none", 2)[:2000])
    assert study.names == ("curve",)
    assert "curve" in repr(study)
    assert "noise floor" in str(study)
    assert study.plot("time")._repr_png_() == study.plot("time")._repr_png_()
    with pytest.raises(hysgen.HysgenError, match="there is no such picture; choose one of record, free-run"):
        study.plot("moon")
    assert np.isfinite(study.model.parameters).all()


def test_a_model_runs_on_arrays(model: hysgen.Model, record: hysgen.Record) -> None:
    """Free run, one step and inverse of arrays and columns; the inverse takes the simulation to its reference."""
    u_V, y_um = record.u_V, record.y_um
    y_hat = model.simulate(u_V)
    # Rest under the first voltage is not where the plays of the measured stage stand: the first stroke is left out.
    assert np.sqrt(np.mean((y_hat - y_um)[2000:] ** 2)) < 0.01
    np.testing.assert_array_equal(model.simulate(u_V[:, None]), y_hat)
    ahead = model.predict(y_um, u_V)
    assert ahead[0] == y_um[0]
    assert np.sqrt(np.mean((ahead - y_um) ** 2)) < 0.002
    # Flat at first: the simulation starts at rest under the first voltage.
    reference = 3.3 - 0.8 * np.cos(2 * np.pi * 20.0 * TS_S * np.arange(2000))
    drive_V = model.inverse(reference)
    assert drive_V.shape == (1999,)
    reached = model.simulate(drive_V, y0_um=float(reference[0]))
    # 5 nm: the inverse is float32, the simulation float64, and both start at rest under nearly the same voltage.
    assert np.sqrt(np.mean((reached - reference[:-1])[1000:] ** 2)) < 0.005
    for wrong, said in (
        (["a"], "holds no numbers"),
        (np.zeros((3, 3)), r"shape \(3, 3\)"),
        ([1.0, np.nan], "index 1 is nan"),
    ):
        with pytest.raises(hysgen.HysgenError, match=said):
            model.simulate(wrong)


def test_models_are_compared_hashed_and_written_by_name(
    model: hysgen.Model, record: hysgen.Record, tmp_path: Path
) -> None:
    hysgen.save_model(model, str(tmp_path / "m.json"))
    again = hysgen.load_model(str(tmp_path / "m.json"))
    assert again == model
    assert hash(again) == hash(model)
    assert len({again, model}) == 1
    assert model != hysgen.fit(record, method="batch")
    assert model != 3
    assert again.to_json()["schema"] == "hysgen-model"


def test_data_frames_come_in_and_go_out(record: hysgen.Record) -> None:
    pandas = library("pandas")
    frame = pandas.DataFrame({"t": record.time_s, "drive [V]": record.u_V, "sensor [nm]": 1e3 * record.y_um})
    made = hysgen.Record.from_dataframe(frame)
    assert made.Ts_s == pytest.approx(TS_S)
    np.testing.assert_allclose(made.y_um, record.y_um, rtol=1e-12)
    indexed = frame.set_index(pandas.to_timedelta(frame.pop("t"), unit="s"))
    assert hysgen.Record.from_dataframe(indexed).Ts_s == pytest.approx(TS_S)
    assert list(record.to_dataframe().columns) == ["time_s", "voltage_V", "displacement_um"]
    assert hysgen.fit(record.to_dataframe(), method="batch", rules=4).grid.rules == 4


@pytest.mark.slow
def test_every_function_of_a_record_takes_a_frame_or_a_file_and_of_a_model_a_file(
    record: hysgen.Record, model: hysgen.Model, tmp_path: Path
) -> None:
    library("pandas")
    frame, file = record.to_dataframe(), tmp_path / "stage.json"
    hysgen.save_model(model, file)
    expected = hysgen.score(model, hysgen.Record.from_dataframe(frame)).to_json()
    assert expected["free_run"] == hysgen.score(model, record).to_json()["free_run"]
    assert hysgen.score(file, frame).to_json() == expected
    assert str(hysgen.inspect(frame)).splitlines()[1:] == str(hysgen.inspect(record)).splitlines()[1:]
    assert hysgen.rivals(frame[:3000], frame[3000:]).keys() == hysgen.rivals(record[:3000], record[3000:]).keys()
    assert hysgen.describe(str(file)).describe() == hysgen.describe(model).describe()
    assert hysgen.generate(file).texts == hysgen.generate(model).texts
    assert hysgen.diff(file, model, [frame]).scores[0][1] == expected["free_run"]["e_rms_um"]


def test_numbers_as_text_in_a_data_frame_are_numbers(record: hysgen.Record) -> None:
    library("pandas")
    frame = record.to_dataframe()
    frame["voltage_V"] = frame["voltage_V"].map(repr)
    np.testing.assert_array_equal(hysgen.Record.from_dataframe(frame).u_V, record.u_V)


def test_a_number_as_memory_is_that_of_the_plays(record: hysgen.Record) -> None:
    assert "4 plays" in str(hysgen.fit(record[:3000], memory=4, method="batch"))


def test_a_data_frame_with_dates_as_index_of_any_name_is_a_record(record: hysgen.Record) -> None:
    pandas = library("pandas")
    stamps = pandas.Timestamp("2026-11-23") + pandas.to_timedelta(record.time_s, unit="s").round("us")
    frame = pandas.DataFrame({"voltage": record.u_V, "position": record.y_um}, index=stamps.rename("when"))
    assert hysgen.Record.from_dataframe(frame).Ts_s == pytest.approx(TS_S)


def test_a_record_is_cut_like_an_array(record: hysgen.Record) -> None:
    part = record[1000:3000]
    assert (len(part), part.past_samples) == (2000, (1000,))
    np.testing.assert_array_equal(part.u_V, record.u_V[1000:3000])
    assert hysgen.Record.from_arrays(record.u_V[:, None], record.y_um, fs_Hz=1.0 / TS_S).fs_Hz == pytest.approx(1e4)


def test_every_error_of_the_interface_is_a_hysgen_error(record: hysgen.Record, model: hysgen.Model) -> None:
    frame = library("pandas").DataFrame({"a": record.u_V, "b": record.y_um})
    calls = {
        "rulez: is not known \\(did you mean 'rules'": lambda: hysgen.fit(record, rulez=8),
        "a dict is no record": lambda: hysgen.fit({"u": 1}),
        "a int is no name of a file": lambda: hysgen.load_record(3),
        "columns: 'volts' is not known": lambda: hysgen.load_record("x.csv", {"volts": "u"}),
        "a float is no description of columns": lambda: hysgen.load_record("x.csv", 3.0),
        "give either Ts_s in seconds or fs_Hz": lambda: hysgen.Record.from_arrays([1.0], [1.0]),
        "index a record by rows": lambda: record[5],
        "rules: '8' is no number; give a whole one": lambda: hysgen.fit(record, rules="8"),
        "rules: 2.5 is no number; give a whole one": lambda: hysgen.fit(record, rules=2.5),
        "memory: 'yes' is no size": lambda: hysgen.fit(record, memory="yes"),
        "a int is no name of a model": lambda: hysgen.load_model(3),
        "a dict is no model": lambda: hysgen.generate({}),
        "mine.json: cannot be read": lambda: hysgen.score("mine.json", record),
        "a float is no record": lambda: hysgen.inspect(3.0),
        "Ts_s: is missing": lambda: hysgen.HysteresisRegressor().fit(record.u_V, record.y_um),
        'it holds a, b; say which one it is: columns="time=NAME,volt': lambda: hysgen.Record.from_dataframe(frame),
        "nothing to plot": lambda: hysgen.score(model, record).plot("bode"),
    }
    for said, call in calls.items():
        with pytest.raises(hysgen.HysgenError, match=said):
            call()


@pytest.mark.slow
def test_what_the_command_line_does_is_in_the_interface(
    model: hysgen.Model, record: hysgen.Record, tmp_path: Path
) -> None:
    assert "memory" in str(hysgen.inspect(record))
    assert "time constant" in hysgen.describe(model).describe()
    assert hysgen.certificates(model).inverse_holds
    again, scores = hysgen.refit(model, record)
    assert hysgen.diff(model, again, [record]).scores[0][1] == pytest.approx(scores.free_run.e_rms_um, rel=0.5)
    assert set(hysgen.rivals(record[:3000], record[3000:])) == {
        "paper's model",
        "Prandtl-Ishlinskii, 20 plays",
        "proportional",
        "ARX(2,2,0)",
    }
    saved = hysgen.page((model, scores, record)).save(tmp_path / "page.html")
    assert saved.read_text().startswith("<!DOCTYPE html>")
    several = hysgen.page(({"first": model, "second": again}, record)).html()
    assert all(f"{name}, {kind}" in several for name in ("first", "second") for kind in ("free run", "one step"))
    proof = hysgen.prove(hysgen.generate(model), ["sanitize"], CheckSettings(samples=500))
    assert proof.clean
    assert proof.to_json()["model"] == model.name
    with pytest.raises(hysgen.HysgenError, match="--only misa: is not a check"):
        hysgen.prove(hysgen.generate(model), ["misa"])


def test_every_verb_has_a_name_in_python() -> None:
    """The table of docs/api.md: each verb of the command line, and names that exist."""
    page = (Path(__file__).parents[1] / "docs" / "api.md").read_text(encoding="utf-8")
    table = page.partition("Each verb of the command line in Python")[2].partition("\n\n`record.split")[0]
    cells = [line.strip("|").split("|") for line in table.splitlines() if line.startswith("| `")]
    both = [pair for row in cells for pair in zip(row[::2], row[1::2], strict=True)]
    pairs = {verb.strip(" `"): names for verb, names in both if verb.strip()}
    assert set(pairs) == set(NAMES)
    for names in pairs.values():
        for name in names.replace("`", "").split(","):
            room, _, function = name.strip().rpartition(".")
            assert callable(getattr(importlib.import_module(room or "hysgen"), function))


@pytest.mark.slow
def test_a_model_goes_into_other_tools_and_to_the_firmware(
    model: hysgen.Model, record: hysgen.Record, tmp_path: Path
) -> None:
    written = hysgen.write_export(model, "cmake", tmp_path / "cmake")
    assert (tmp_path / "cmake" / "CMakeLists.txt") in written
    with pytest.raises(hysgen.HysgenError, match=r"cmaek: is no target \(did you mean 'cmake'\?\); choose from"):
        hysgen.write_export(model, "cmaek", tmp_path)
    files = hysgen.firmware_files(model)
    assert files.model.learner is not None
    assert "model.h" in files.texts
    assert hysgen.image(model, b"k" * 16, Label(device=3)) != hysgen.image(model, b"k" * 16)
    assert hysgen.schema("score")["$id"] == "hysgen-score-1"
    with pytest.raises(hysgen.HysgenError, match="scores: no such schema"):
        hysgen.schema("scores")
    assert len(hysgen.demo_record()) == 67_248


@pytest.mark.slow
def test_importing_hysgen_leaves_the_threads_of_the_notebook_alone() -> None:
    code = (
        "import os; os.environ.pop('OPENBLAS_NUM_THREADS', None); before = dict(os.environ)\n"
        "import hysgen; hysgen.Record; assert dict(os.environ) == before\n"
        "assert set(dir(hysgen)) - {'__version__', '__doc__', '__all__'} == set(hysgen.__all__)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
