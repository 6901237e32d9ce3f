"""What to do about each cause: numbers by hand, pictures read back, and a gallery that is what its command makes."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hysgen.diagnosis.causes import causes
from hysgen.diagnosis.remedy import POINTS, Motion, Seen, Sketch, held, strokes, voltage_step
from hysgen.model.model import Grid, Model
from hysgen.model.path.base import InputBlock
from hysgen.model.path.delay import Delay
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.path.loop import Loop
from hysgen.report.sketches import dotted, svg
from hysgen_lab.studies.gallery import gallery

DOCS = Path(__file__).resolve().parents[2] / "docs"
NUMBER = re.compile(r"-?\d+\.\d+")

SAID = {
    "memory": ({"loop_um": 0.5, "loop_Hz": 2.0}, "0.5 um apart", "half the stroke has a loop of"),
    "curve": ({"bow_um": -0.4}, "wrong by up to 0.4 um", "by about 0.1 um"),
    "relaxation": ({"half_widths": 0.02}, "grows by 2 %", "another loop by 4.6 %"),
    "creep": ({"per_decade": 0.02, "from_s": 0.01}, "by 0.16 um in each decade", "from 1 to 2 s it moves by 0.048 um"),
    # ln 50 / (2 pi 0.05 100 Hz) = 0.1245 s; half of it with a damping of 0.1.
    "resonance": ({"f_Hz": 100.0, "zeta": 0.05}, "for 125 ms, until 2 %", "it would ring for 62 ms"),
    "softening": ({"f_Hz": 90.0, "small_f_Hz": 100.0}, "at 90 Hz for large", "at least 10 Hz wide"),
    # 2 ms late at 2 pi 100 Hz and an amplitude of 4 um.
    "delay": (
        {"delay_samples": 2.0},
        "2 ms late: in a sine over the stroke at 100 Hz it is wrong by up to 5 um",
        "widen",
    ),
    "saturation": ({"high_V": 80.0}, "commands above 80 V do not", "20 % of the range"),
    "slew": ({"rate_V_per_s": 5e3}, "of 100 V takes 20 ms", "up to 15.9 Hz"),
    "drift": ({"ramp_um_per_s": -0.01}, "-0.6 um in a minute", "every 1 s to stay"),
    "periodic": ({"f_Hz": 100.01, "amplitude_um": 0.2}, "0.4 um peak to peak at 100 Hz", "mains of 50 Hz"),
    "aging": ({"fraction": -0.1, "per_s": -0.001}, "by -10 %", "every 1.2 s"),
    "outliers": ({"rate": 0.02, "size_um": 0.4}, "one reading in 50 is wrong by 0.4 um", "of 0.2 um"),
    "coupling": ({"heat_um_per_unit": 0.025}, "one unit of heat moves the stage by 0.025 um", "within 0.4"),
    "unknown": ({}, "changed suddenly", "clamps"),
}
"""Parameters at 1 ms, 100 V, a stroke of 8 um and a noise of 0.01 um; what is said."""


def model(*blocks: InputBlock) -> Model:
    return Model("stage", 1e-3, Grid(-5.0, 15.0, 2), np.array([[0.5, 0.5, 0.0]] * 2), 0.0, 100.0, blocks=blocks)


LOOP = Hysteresis(0.0, 100.0, (4.0, 2.0), (0.25,), (2.0,))


@pytest.mark.parametrize("name", SAID)
def test_advice_has_the_numbers_of_the_record(name: str) -> None:
    values, means, change = SAID[name]
    found = causes()[name].advice(Seen(values, model(LOOP), 8.0, 0.01))
    assert found is not None
    assert means in found.means
    assert change in found.change


def test_a_line_beside_the_mains_is_a_machine() -> None:
    values = {"f_Hz": 57.0, "amplitude_um": 0.2}
    found = causes()["periodic"].advice(Seen(values, model(), 8.0, 0.01))
    assert found is not None
    assert "turns at 3420 1/min" in found.change


def test_pictures_are_of_the_model_with_the_cause_and_without_it() -> None:
    seen = Seen({"loop_Hz": 2.0, "loop_um": 0.5, "delay_samples": 3.0}, model(Delay(3.0), LOOP), 8.0, 0.01)
    for name in ("memory", "delay"):
        assert causes()[name].sketch(Seen(seen.values, model(), 8.0, 0.01)) is None
    motion = causes()["delay"].motion(seen.values, 1e-3)
    assert motion is not None
    both = causes()["delay"].motions_um(motion, seen)
    assert both is not None
    np.testing.assert_allclose(both[0][3:], both[1][:-3], atol=1e-9)
    # A play of a quarter of the half range: way up and way down are 2 * 0.25 * 2 um apart.
    sketch = causes()["memory"].sketch(Seen({"loop_Hz": 0.1}, model(LOOP), 8.0, 0.01))
    assert sketch is not None
    half = len(sketch.x) // 2
    for y, apart_um in ((sketch.acting, 1.0), (sketch.free, 0.0)):
        up = np.interp(0.5, sketch.x[:half], y[:half])
        down = np.interp(0.5, sketch.x[:half:-1], y[:half:-1])
        assert (down - up) * sketch.height_um == pytest.approx(apart_um, abs=0.06)
    # Plays that relax go on while the voltage rests; those that do not have no picture.
    relaxing = causes()["relaxation"].sketch(Seen({}, model(replace(LOOP, relaxation=0.05)), 8.0, 0.01))
    assert relaxing is not None
    assert (np.ptp(relaxing.acting[20:]) > 0.1, np.ptp(relaxing.free[20:]) < 1e-4) == (True, True)
    assert causes()["relaxation"].sketch(Seen({}, model(LOOP), 8.0, 0.01)) is None
    yielding = Loop(100.0, 0.02, (0.02,), (0.0,), (0.5,), (0.5,), (2.0,), 1, 2e-3, 0.1)
    assert causes()["softening"].sketch(Seen({"small_f_Hz": 110.0}, model(yielding), 8.0, 0.01)) is not None
    assert causes()["softening"].sketch(Seen({"small_f_Hz": 110.0}, model(), 8.0, 0.01)) is None
    for name in ("curve", "drift", "aging", "outliers", "coupling", "periodic"):
        drawn = causes()[name].sketch(Seen(SAID[name][0], model(), 8.0, 0.01))
        assert drawn is not None
        assert 0.99 < np.ptp(drawn.acting - drawn.free) <= 1.0001 or name in ("curve", "aging", "periodic")


def test_a_sketch_shows_where_both_differ_and_begins_at_one_place() -> None:
    motion = Motion(np.arange(4.0), 1.0, "words")
    sketch = Sketch.of(motion, np.array([0.0, 10.0, 11.0, 12.0]), np.array([5.0, 15.0, 15.0, 15.0]))
    assert list(sketch.acting) == pytest.approx([-1.0, 0.0, 0.5, 1.0])
    assert list(sketch.free) == pytest.approx([-1.0, 0.0, 0.0, 0.0])
    assert (sketch.height_um, list(sketch.x)) == (2.0, pytest.approx([0.0, 1 / 3, 2 / 3, 1.0]))
    assert voltage_step(1.0, 0.01).levels.tolist() == [0.25] * 10 + [0.75] * 90
    assert (held(8.0).Ts_s, len(held(8.0).levels)) == (8.0 / POINTS, POINTS)
    loop = strokes(1.0, 0.01, loop=True).levels
    np.testing.assert_allclose(loop, loop[::-1], atol=1e-12)


def test_both_pictures_are_drawn_on_one_scale_in_lines_and_in_dots() -> None:
    sketch = Sketch(np.array([0.0, 1.0]), np.array([0.0, 1.0]), np.array([0.0, 0.0]), "a step", 0.25)
    text = svg(sketch, "creep")
    lines = re.findall(r'points="([^"]*)"', text)
    assert lines == ["2.0,77.0 148.0,77.0", "2.0,77.0 148.0,17.0", "176.0,77.0 322.0,17.0", "176.0,77.0 322.0,77.0"]
    assert "a step; 0.25 um high" in text
    head, *rows = dotted(sketch, "creep")
    assert head.split("   ")[0] == "with creep"
    assert [row[:26].strip("\u2800") != "" for row in rows] == [True] * 4
    assert [row[29:] for row in rows] == ["\u2800" * 26] * 3 + ["\u28c0" * 26]


def test_gallery_of_the_docs_is_what_its_command_makes() -> None:
    """Numbers may differ by the last digit that is drawn: a compiler may add in another order."""
    files = gallery()
    stored = {path.relative_to(DOCS).as_posix() for path in (DOCS / "gallery").iterdir()} | {"gallery.md"}
    assert set(files) == stored
    for name, text in files.items():
        kept = (DOCS / name).read_text()
        assert NUMBER.sub("", text) == NUMBER.sub("", kept), name
        pairs = ([float(number) for number in NUMBER.findall(one)] for one in (text, kept))
        np.testing.assert_allclose(*pairs, atol=0.11, err_msg=name)
    assert sum(len(text) for text in files.values()) < 110_000
