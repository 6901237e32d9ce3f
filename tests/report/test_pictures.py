"""Pictures read back from their figures: lines, labels, limits and the numbers of their alt texts."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from hysgen.record import Record
from hysgen.report.page import PageSection, PageTable
from hysgen.report.plots import plain_number
from hysgen.report.plots.traces import (
    Simulated,
    envelope,
    fit_percent,
    free_run_pictures,
    loop_pictures,
    record_picture,
    response_pictures,
    spectra,
    thinned,
    time_picture,
    validation,
)
from hysgen_lab.studies.paper.results import loops, tracking

TS_S = 1e-3
T_S = TS_S * np.arange(1000)
U_V = 20.0 + 10.0 * np.random.default_rng(2).standard_normal(1000)
Y_UM = 0.1 * U_V + 0.5
LINES = {"a": {"color": "#111111"}, "b": {"color": "#222222"}}


def shown() -> Simulated:
    """Model a has twice the gain; model b is right but for 0.4 um at row 700."""
    wrong = Y_UM.copy()
    wrong[700] += 0.4
    return Simulated(T_S, U_V, Y_UM, {"a": 0.2 * U_V + 0.5, "b": wrong}, LINES)


def labels(figure: Figure) -> list[tuple[str, str]]:
    return [(axis.get_xlabel(), axis.get_ylabel()) for axis in figure.axes]


def lines(figure: Figure, axis: int = 0) -> dict[Any, Any]:
    return {line.get_label(): line for line in figure.axes[axis].lines}


def test_record_is_drawn_with_its_cut() -> None:
    record = Record.from_arrays(U_V, Y_UM, TS_S)
    study: Any = SimpleNamespace(record=record, cut=650)
    picture = record_picture(study)
    assert picture.wide
    assert picture.alt.endswith("held out from 0.65 s on.")
    above, below = picture.figure.axes
    np.testing.assert_array_equal(above.lines[0].get_ydata(), U_V)
    np.testing.assert_array_equal(below.lines[0].get_ydata(), Y_UM)
    np.testing.assert_allclose(below.lines[0].get_xdata(), T_S)
    assert [list(axis.lines[1].get_xdata()) for axis in (above, below)] == [[0.65, 0.65]] * 2
    assert [note.get_text() for note in above.texts] == ["identified", "held out"]
    assert [note.get_ha() for note in above.texts] == ["right", "left"]
    assert below.get_xlim() == pytest.approx((0.0, 0.999))
    assert labels(picture.figure) == [("", "voltage [V]"), ("time [s]", "displacement [µm]")]


def test_spectrum_of_a_sine_has_its_peak_and_a_linear_stage_its_gain() -> None:
    sine = np.sin(2 * np.pi * 100.0 * T_S)
    f_Hz, (uu, yy, uy) = spectra(TS_S, sine, 3.0 * np.roll(sine, 2))
    peak = int(np.argmax(uu))
    # A window of 153 samples: its lines are 6.5 Hz apart.
    assert f_Hz[peak] == pytest.approx(100.0, abs=3.3)
    assert f_Hz[1] == pytest.approx(1.0 / (153 * TS_S))
    assert yy[peak] / uu[peak] == pytest.approx(9.0, rel=1e-2)
    assert abs(uy[peak] / uu[peak]) == pytest.approx(3.0, rel=1e-2)
    assert np.angle(uy[peak]) == pytest.approx(-2 * np.pi * 100.0 * 2 * TS_S, abs=0.05)
    assert plain_number(5e-5) == "0.00005"


def test_free_runs_are_drawn_and_zoomed_at_the_largest_error_of_the_last_model() -> None:
    whole, zoom = free_run_pictures(shown())
    assert list(lines(whole.figure)) == ["measured", "a", "b"]
    np.testing.assert_array_equal(lines(whole.figure)["a"].get_ydata(), shown().runs["a"])
    np.testing.assert_array_equal(lines(whole.figure)["measured"].get_xydata(), np.column_stack([T_S, Y_UM]))
    # Half the zoom is 3 % of 1000 samples.
    np.testing.assert_allclose(lines(zoom.figure)["b"].get_xdata(), T_S[670:730])
    assert zoom.alt == "Zoom at 0.7 s: b is wrong by 0.4 µm."
    assert f"over 1000 samples; fit (NRMSE): a {fit_percent(Y_UM, shown().runs['a']):.4g} %, b 9" in whole.alt
    assert len(whole.figure.axes[0].patches) == 1
    assert labels(whole.figure) == [("time [s]", "displacement [µm]")]
    assert fit_percent(np.array([0.0, 2.0]), np.array([0.0, 1.0])) == pytest.approx(100 * (1 - 1 / math.sqrt(2)))
    for number, (name, picture) in enumerate(zip("ab", loop_pictures(shown()), strict=True), start=1):
        assert picture.name == f"loops-{number}"
        np.testing.assert_array_equal(lines(picture.figure)[name].get_xdata(), U_V)
        np.testing.assert_array_equal(lines(picture.figure)[name].get_ydata(), shown().runs[name])
        assert f"by {np.sqrt(np.mean((shown().runs[name] - Y_UM) ** 2)):.3g} µm rms" in picture.alt


def test_error_in_time_is_simulated_less_measured() -> None:
    picture = time_picture(shown())
    np.testing.assert_allclose(lines(picture.figure, 0)["a"].get_ydata(), 0.1 * U_V)
    assert lines(picture.figure, 1)["b"].get_ydata()[700] == pytest.approx(0.4)
    assert picture.alt == f"Error of the free run: a at most {0.1 * np.abs(U_V).max():.3g} µm; b at most 0.4 µm."
    assert [axis.get_xlabel() for axis in picture.figure.axes] == ["", "time [s]"]


def test_gain_and_phase_are_those_of_the_stage_where_it_is_coherent() -> None:
    late = np.roll(Y_UM, 1)
    gain, phase = response_pictures(Simulated(T_S, U_V, late, {"a": 0.2 * U_V}, LINES))
    np.testing.assert_allclose(lines(gain.figure)["a"].get_ydata(), 0.2, rtol=1e-9)
    np.testing.assert_allclose(lines(gain.figure)["measured"].get_ydata(), 0.1, rtol=0.2)
    f_Hz = lines(phase.figure)["measured"].get_xdata()
    assert f_Hz.min() > 0.0
    np.testing.assert_allclose(lines(phase.figure)["measured"].get_ydata(), -360.0 * f_Hz * TS_S, atol=15.0)
    np.testing.assert_allclose(lines(phase.figure)["a"].get_ydata(), 0.0, atol=1e-6)
    assert "a 0.2 to 0.2 µm/V" in gain.alt
    assert "a 0 to 0 degrees" in phase.alt or "a -0 to" in phase.alt
    noise = np.random.default_rng(9).standard_normal(1000)
    assert response_pictures(Simulated(T_S, U_V, noise, {}, LINES))[0].alt.startswith("Gain nowhere above 0.8 coherent")


def test_reduced_curves_keep_their_peaks_and_their_order() -> None:
    t_s, y = np.arange(12.0), np.array([0, 5, 1, 2, -3, 0, 7, 1, 2, 2, 2, 2.0])
    assert [list(part) for part in envelope(t_s, y, 3)] == [[0, 1, 4, 6, 8], [0, 5, -3, 7, 2]]
    assert envelope(t_s, y, 6)[1] is y
    assert (thinned(20_000).step, thinned(20_001).step) == (1, 2)


def test_validation_and_tracking_draw_errors_in_their_units() -> None:
    record, runs, colours = Record.from_arrays(U_V, Y_UM, TS_S), shown().runs, {"a": "red", "b": "blue"}
    figure = validation(record, runs, "title", colours)
    np.testing.assert_allclose(figure.axes[1].lines[0].get_ydata(), runs["a"] - Y_UM)
    assert figure.axes[2].lines[0].get_label() == f"b: {0.4 / math.sqrt(1000):.2g} µm rms"
    assert (figure.axes[0].get_title(loc="left"), figure.axes[2].get_xlabel()) == ("title", "time [s]")
    figure = loops(record, runs, "title", colours)
    for place, name in enumerate(runs):
        assert figure.axes[place].get_title(loc="left") == name
        np.testing.assert_array_equal(lines(figure, place)["measured"].get_ydata(), Y_UM)
        np.testing.assert_array_equal(lines(figure, place)[name].get_ydata(), runs[name])
    assert labels(figure) == [("voltage [V]", "displacement [µm]"), ("voltage [V]", "")]
    figure = tracking(T_S, Y_UM, runs, "title", colours)
    assert figure.axes[1].lines[1].get_ydata()[700] == pytest.approx(400.0)
    assert labels(figure)[1] == ("time [s]", "reached - reference [nm]")
    assert labels(figure)[2] == ("reference [µm]", "reached [µm]")
    assert [text.get_text() for text in figure.axes[2].get_legend().get_texts()] == ["a", "b"]
    np.testing.assert_array_equal(figure.axes[2].lines[0].get_xdata(), Y_UM)


def test_tables_of_a_page_know_their_numbers_and_sections_their_anchor() -> None:
    made = PageTable(["a", "b", "c", "d"], [["w", "1", "2", "x"]], left=1, right=1)
    assert list(made.numbers) == [2, 3]
    assert list(PageTable(["a", "b"], [], left=1).numbers) == [2]
    assert list(PageTable(["a", "b"], []).numbers) == []
    assert made.rows == [[("a", "w"), ("b", "1"), ("c", "2"), ("d", "x")]]
    assert PageSection("Cost, 2 ways").anchor == "cost--2-ways"
