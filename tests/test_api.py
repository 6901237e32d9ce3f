"""The Python interface: one import, results as text and HTML, pictures on request."""

from __future__ import annotations

import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import hysgen
from fixtures.bank_records import record_of
from hysgen.display import Displayed
from hysgen.report.plots.results import Drawing
from hysgen.stage import Stage, run
from hysgen.stage.signals import nested_amplitudes

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


def test_names_of_the_api_stand_at_the_top_and_are_loaded_when_they_are_used() -> None:
    code = (
        "import sys, hysgen; assert 'numpy' not in sys.modules, 'loaded too early'\n"
        "import hysgen.fitting.settings, hysgen.checking.bits, hysgen.c674x.cost, hysgen.diagnosis\n"
        "from hysgen import fit, score, diagnose, generate, verify, load_record, cost\n"
        "from hysgen.fitting import FitSettings\n"
        "assert all(callable(f) for f in (fit, score, diagnose, generate, verify, load_record, cost))\n"
        "assert hysgen.FitSettings is FitSettings\n"
        "assert hysgen.fit is fit and 'diagnose' in dir(hysgen)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


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
    folder = code.write(tmp_path / "c")
    assert (folder / "stage.h").read_text() == code["stage.h"]
    assert hysgen.verify(folder, samples=2000).equal
    assert hysgen.cost(folder).budget == 37500  # 100 us at 375 MHz


def test_diagnosis_shows_its_ladder_and_draws_what_is_asked_for() -> None:
    study = hysgen.diagnose(record_of("none", 2))
    assert study.names == ()
    assert "no cause" in repr(study)
    assert "noise floor" in str(study)
    assert study.plot("time")._repr_png_() == study.plot("time")._repr_png_()
    with pytest.raises(hysgen.HysgenError, match="there is no such picture; choose one of loops-before"):
        study.plot("moon")
    assert np.isfinite(study.model.parameters).all()
