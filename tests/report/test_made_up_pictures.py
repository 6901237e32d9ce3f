"""A diagnosis with made-up numbers in pictures: every number stands where it belongs, by hand."""

import dataclasses
import re
from typing import Any

import numpy as np
import pytest
from matplotlib.text import Text
from matplotlib.ticker import ScalarFormatter

from fixtures.made_up_study import (
    BASE,
    BOTH,
    COST,
    CREEP,
    EQUAL,
    HUM,
    LABEL,
    T_S,
    TS_S,
    U_V,
    Y_UM,
    N,
    cause,
    error_map,
    lines_of,
    model,
    scored,
    study,
    text_of,
)
from hysgen.diagnosis.ladder import Gain
from hysgen.errors import HysgenError
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen.report import plots, words
from hysgen.report.pages import diagnosis_page
from hysgen.report.plots.results import BAR, draw, horizon_picture, ladder_picture, profiles_picture, spectrum_picture


def test_horizon_and_spectrum_are_drawn_in_their_units() -> None:
    shown = [(BASE, error_map(0.5)), (LABEL, error_map(0.1))]
    picture = horizon_picture(shown, BOTH)
    (axis,) = picture.figure.axes
    drawn = lines_of(picture.figure)
    np.testing.assert_allclose(drawn[BASE].get_xdata(), [1.0, 10.0, 100.0])
    np.testing.assert_allclose(drawn[LABEL].get_ydata(), [0.01, 0.03, 0.1])
    assert (drawn[BASE].get_color(), drawn[LABEL].get_color()) == (plots.SIMULATED, plots.EXTENDED)
    assert [text.get_text() for text in axis.get_legend().get_texts()] == [BASE, LABEL]
    levels = {name: text.xy for name, text in text_of(axis).items()}
    assert levels == {"noise floor": (1.0, 0.01), "persistence, 1 step": (1.0, 0.05)}
    assert [line.get_ydata()[0] for line in axis.lines[2:]] == [0.01, 0.05]
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("horizon [ms]", "error rms [µm]")
    assert (axis.get_xscale(), axis.get_yscale()) == ("log", "log")
    assert [tick(2e-5, 0) for tick in (axis.xaxis.get_major_formatter(), axis.yaxis.get_major_formatter())] == [
        "0.00002"
    ] * 2
    ends = "paper's model 0.05 to 0.5 µm; extended model 0.01 to 0.1 µm"
    assert picture.alt == f"Error rms from 1 to 100 samples ahead: {ends}."
    picture = spectrum_picture(shown)
    np.testing.assert_array_equal(lines_of(picture.figure)[LABEL].get_ydata(), [0.1, 0.1, 0.05])
    np.testing.assert_array_equal(lines_of(picture.figure)[LABEL].get_xdata(), [5.0, 50.0, 200.0])
    assert picture.alt == "Largest bands: paper's model 0.5 µm at 50 Hz; extended model 0.1 µm at 5 Hz."
    assert picture.figure.axes[0].xaxis.get_major_formatter()(2e-5, 0) == "0.00002"
    assert picture.figure.axes[0].get_legend() is not None


def test_profiles_have_gaps_decades_and_directions_on_one_scale_in_one_row() -> None:
    shown = [(BASE, error_map(0.5)), (LABEL, error_map(0.1))]
    picture = profiles_picture(shown)
    axes = picture.figure.axes
    assert [axis.get_xscale() for axis in axes] == ["linear", "linear", "log", "linear", "linear"]
    assert len({axis.get_ylim() for axis in axes}) == 1
    assert axes[0].get_ylim() == pytest.approx((0.01, 1.0))
    heights = [step.get_data() for step in axes[0].patches]
    assert [list(step.values) for step in heights] == [[0.1, 0.5], pytest.approx([0.02, 0.1])]
    assert list(heights[0].edges) == [0.0, 50.0, 100.0]
    assert isinstance(axes[0].xaxis.get_major_formatter(), ScalarFormatter)
    names = [
        "level [V]",
        "direction of the input",
        "frequency [Hz]",
        "time in the record [s]",
        "since the last turn [s]",
    ]
    assert [axis.get_xlabel() for axis in axes] == names
    assert [text.get_text() for text in picture.figure.legends[0].get_texts()] == [BASE, LABEL]
    assert [tick.get_text() for tick in axes[1].get_xticklabels()] == ["down", "still", "up"]
    # A bin without error is a gap on a logarithmic axis.
    assert np.isnan(axes[2].patches[0].get_data().values[0])
    assert axes[2].xaxis.get_major_formatter()(2e-5, 0) == "0.00002"
    assert "By direction: paper's model 0.2 um (up) .. 0.5 um (down); extended model 0.04 um (up)" in picture.alt
    nothing = dataclasses.replace(
        error_map(0.5), profiles=(dataclasses.replace(error_map(0.5).profiles[0], rms_um=(0.0, 0.0)),) * 2
    )
    assert profiles_picture([(BASE, nothing)]).figure.axes[0].get_ylim() == pytest.approx((1e-9, 2e-9))


def test_ladder_is_drawn_row_by_row_with_numbers_beside_its_frame() -> None:
    doubtful = dataclasses.replace(CREEP, price=None)
    picture = ladder_picture(study(HUM, doubtful))
    (axis,) = picture.figure.axes
    points = [line for line in axis.lines if line.get_marker() == "o"]
    assert [(line.get_xdata()[0], line.get_ydata()[0]) for line in points] == [(0.5, 0), (0.2, 1), (0.1, 2)]
    assert [line.get_color() for line in points] == [plots.SIMULATED, plots.EXTENDED, plots.EXTENDED]
    bars = [line for line in axis.lines if line.get_linewidth() == BAR]
    # After the step plus the interval of its gain: 0.2 + (0.25, 0.35) and 0.1 + (-0.02, 0.15).
    assert [list(bar.get_xdata()) for bar in bars] == [pytest.approx([0.45, 0.55]), pytest.approx([0.08, 0.25])]
    assert [list(bar.get_ydata()) for bar in bars] == [[1, 1], [2, 2]]
    steps = [line for line in axis.lines if line.get_color() == plots.NOTE]
    assert [list(step.get_xdata()) for step in steps] == [[0.5, 0.2], [0.2, 0.1]]
    # From 0.6 of the noise to 1.5 times the highest end of a bar.
    assert axis.get_xlim() == pytest.approx((0.006, 0.825))
    assert axis.get_ylim() == pytest.approx((2.5, -0.5))
    assert [tick.get_text() for tick in axis.get_yticklabels()] == [BASE, "+ periodic", "+ creep"]
    found = [text.get_text() for text in axis.texts]
    assert found == ["noise floor", "rms [µm]", "0.5", "0.2", "0.1", "cycles", "", "+40", "?"]
    cells_at = [text.get_position() for text in axis.texts if text.get_text() in ("0.5", "0.2", "0.1", "+40", "?")]
    assert [row for _, row in cells_at] == [0, 1, 2, 1, 2]
    assert all(1.0 < place < 1.25 for place, _ in cells_at)
    assert text_of(axis)["noise floor"].xy == (0.01, 1.0)
    assert [line.get_xdata()[0] for line in axis.lines if line.get_linestyle() == ":"] == [0.01]
    assert axis.get_xlabel() == "free run, held out, rms [µm]"
    assert axis.get_xscale() == "log"
    assert picture.alt.endswith("paper's model 0.5 µm, + periodic 0.2 µm, + creep 0.1 µm; noise floor 0.01 µm.")
    assert picture.wide
    # A gain that may be as large as the error itself: its bar begins at the frame.
    wide = ladder_picture(study(cause("drift", Gain(0.5, 0.2, -0.3, 0.1, 0.5), 0.1))).figure.axes[0]
    (bar,) = [line for line in wide.lines if line.get_linewidth() == BAR]
    assert list(bar.get_xdata()) == pytest.approx([0.006, 0.3])
    taller = ladder_picture(study()).figure.get_size_inches()[1]
    assert 0.3 < (picture.figure.get_size_inches()[1] - taller) / 2 < 0.45


def test_labels_of_a_logarithmic_axis_are_few_over_decades_and_never_one() -> None:
    for low, high, most, labels in (
        (0.01, 1.0, 9, [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0]),
        (1e-4, 1e4, 9, [1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4]),
        (1e-4, 1e4, 3, [1e-4, 1.0, 1e4]),
        (0.061, 0.079, 9, [0.064, 0.068, 0.072, 0.076]),
    ):
        axis = plots.axes("", "")[1]
        axis.set(xscale="log", xlim=(low, high))
        plots.decimal_ticks_of(axis.xaxis, most)
        places = [place for place in axis.get_xticks() if low * 0.999 <= place <= high * 1.001]
        assert places == pytest.approx(labels), (low, high)


def test_top_of_a_page_says_the_main_cause_its_share_and_what_changes_the_verdict() -> None:
    page = diagnosis_page(BOTH, proof=(EQUAL, COST))
    assert page.headline == "periodic is 80 % of the error"
    assert [(part.name, part.words) for part in page.shares] == [
        ("periodic", "80.0 %"), ("creep", "15.0 %"), ("not explained", "4.0 %")
    ]  # fmt: skip
    assert list(page.lead) == [
        "The paper's model is wrong by 6.2 % of the stroke, 0.5 um; the model with these causes by 1.2 %, 0.1 um: "
        "5 times less, 10 times the noise."
    ]
    assert list(page.warnings) == []
    html = page.html()
    top = html.partition("<nav")[0]
    assert "<h1>Periodic is 80 % of the error</h1>" in top
    assert re.findall(r"flex-grow: ([\d.]+);", top) == ["0.8000", "0.1500", "0.0396"]
    swapped = study(dataclasses.replace(HUM, share=0.1), CREEP, unknown="a jump")
    assert words.headline(swapped) == "creep is 15 % of the error"
    assert words.warnings(swapped) == ["None of the known causes explains the following: a jump."]
    assert words.headline(study()) == "No cause stands out"
    assert words.headline(study(unknown="a jump")) == "No known cause explains the error"
    lost = study(dataclasses.replace(HUM, extended=False))
    assert words.headline(lost) == "periodic: named, and no large part of the error"
    assert words.in_one_sentence(lost) == (
        "The paper's model is wrong by 6.2 % of the stroke, 0.5 um, 50 times the noise."
    )
    record = Record.from_arrays(U_V, 0.1 * np.random.default_rng(3).normal(size=N), TS_S)
    loose = dataclasses.replace(study(HUM), record=record)
    assert words.headline(loose) == "The displacement does not follow the voltage"
    assert words.warnings(loose)[0].startswith("The displacement does not follow the voltage: a linear")


@pytest.mark.parametrize(("swing_px", "points"), [(0.2, range(100)), (3.0, range(190, 210))])
def test_curves_of_a_page_lose_only_what_nobody_sees(swing_px: float, points: range) -> None:
    fig = plots.figure(2.0, 2.0)
    axis = fig.add_axes((0.0, 0.0, 1.0, 1.0))
    axis.plot(np.arange(200.0), 0.5 + swing_px / 144.0 * (np.arange(200) % 2), gid="curve")
    axis.set(xlim=(0, 199), ylim=(0, 1))
    axis.axis("off")
    path = re.search(rb'id="curve">\s*<path d="([^"]*)"', plots.svg_bytes(fig))
    assert path is not None
    assert path.group(1).count(b"L") in points


@pytest.mark.slow
def test_results_are_drawn_with_their_own_numbers(tmp_path: Any) -> None:
    record = Record.from_arrays(U_V, Y_UM, TS_S, source="a.csv")
    above, below, side = draw(record).figure.axes
    np.testing.assert_allclose(above.lines[0].get_xydata(), np.column_stack([T_S, U_V]))
    np.testing.assert_allclose(below.lines[0].get_xydata(), np.column_stack([T_S, Y_UM]))
    np.testing.assert_allclose(side.lines[0].get_xydata(), np.column_stack([U_V, Y_UM]))
    assert above.get_title(loc="left") == "a.csv"
    assert [axis.get_xlabel() for axis in (above, below, side)] == ["", "time [s]", "voltage [V]"]
    assert [axis.get_ylabel() for axis in (above, below, side)] == ["voltage [V]", *["displacement [µm]"] * 2]
    assert above.get_position().width > side.get_position().width
    ends = [axis.get_position().extents for axis in (above, below, side)]
    # The axes at the side are as high as the two others together.
    assert (ends[2][1], ends[2][3]) == pytest.approx((ends[1][1], ends[0][3]))
    (axis,) = draw(model()).figure.axes
    assert (axis.get_ylim()[0], axis.get_xscale(), axis.get_title(loc="left")) == (0.0, "log", "made_up")
    assert axis.get_ylabel() == "loop fills its box [%]"
    # The line of a first-order lag at 0.1103 Hz and at 50 Hz.
    assert axis.lines[0].get_ydata()[[0, -1]] == pytest.approx([0.11, 43.68], abs=0.01)
    figure = draw(model(), record).figure
    assert figure.axes[0].get_title(loc="left") == "made_up on a.csv"
    expected = free_run(model(), record)[0].y_um - Y_UM
    np.testing.assert_allclose(figure.axes[1].lines[0].get_ydata(), expected)
    (axis,) = draw(scored("a", 0.02, 0.4)).figure.axes
    assert [(name, text.xy[1]) for name, text in text_of(axis).items()] == [("noise floor", 0.01), ("free run", 0.4)]
    np.testing.assert_allclose(axis.lines[0].get_xydata(), [[1.0, 0.02], [10.0, 0.4]])
    assert axis.lines[0].get_label() == "a on a.csv"
    assert axis.get_legend() is not None
    (axis,) = draw(COST).figure.axes
    # Without `init`, which runs once.
    assert [bar.get_width() for bar in axis.patches] == [300]
    assert axis.lines[0].get_xdata()[0] == 3750
    assert axis.get_legend().get_texts()[0].get_text() == "sample period, 3750"
    assert axis.yaxis_inverted()
    assert axis.get_title(loc="left") == "made_up"
    assert 1.0 < axis.figure.get_size_inches()[1] < 2.0
    assert draw(BOTH).figure.axes[0].get_xlabel() == "free run, held out, rms [µm]"
    drawn = [axis.figure for axis in (above, axis)]
    # Nothing is written larger than a title.
    assert all(text.get_fontsize() <= 10.0 for figure in drawn for text in figure.findobj(Text))
    with pytest.raises(HysgenError, match="there is no such picture; choose one of record, "):
        draw(BOTH, "nothing")
    with pytest.raises(HysgenError, match="int: there is nothing to plot"):
        draw(1)
    for name, head in (("a.svg", b"<?xml"), ("a.png", b"\x89PNG")):
        assert draw(record).save(tmp_path / name).read_bytes().startswith(head)
