"""What a record holds and could show: counts, frequencies and requirements, at both sides of their limits."""

import itertools

import numpy as np
import pytest

from hysgen.diagnosis.causes import VOCABULARY
from hysgen.diagnosis.identifiability import Inspection, inspect
from hysgen.fitting import check_for_fit
from hysgen.record import Record

TS_S = 1e-3
RNG = np.random.default_rng(3)


def seen(u_V: np.ndarray, Ts_s: float = TS_S, **aux: np.ndarray) -> Inspection:
    y_um = 0.05 * u_V + 0.001 * RNG.normal(size=u_V.size)
    return inspect(Record.from_arrays(u_V, y_um, Ts_s, aux))


def strokes(*levels_V: float, samples: int = 200) -> np.ndarray:
    """Straight strokes from level to level."""
    parts = [np.linspace(a, b, samples, endpoint=False) for a, b in itertools.pairwise(levels_V)]
    return np.concatenate(parts)


def met(found: Inspection, cause: str) -> tuple[bool, str]:
    (one,) = (one for one in found.requirements if one.cause == cause)
    return one.met, one.why


def test_swings_sizes_rests_and_speed_are_counted() -> None:
    u_V = strokes(0.0, 100.0, 0.0, 60.0, 0.0, 100.0, 40.0)
    u_V = np.concatenate([u_V, np.full(300, 40.0), strokes(40.0, 90.0), np.full(40, 90.0)])
    found = seen(u_V)
    # Between the first turning point and the last: 100, 60, 60, 100 V down, up, ..., 60 V to the plateau.
    assert (found.seen.swings, found.seen.sizes) == (5, 2)
    assert (found.seen.rests, found.seen.longest_rest_s) == (2, pytest.approx(0.301, abs=1e-9))
    assert found.seen.fastest_V_per_s == pytest.approx(0.5 / TS_S, rel=0.01)
    assert seen(np.concatenate([u_V, u_V])).seen.rests >= 4
    assert found.warnings == check_for_fit(found.seen.record, 6, 18) != ()
    text = str(found)
    assert "excitation: 5 swings of 2 sizes" in text
    assert "2 rests, the longest 0.301 s" in text
    noise_percent = 100 * found.seen.noise.rms_um / float(np.ptp(found.seen.record.segments[0].y_um))
    assert f"{noise_percent:.2g} % of the stroke" in text


@pytest.mark.parametrize(("levels", "nested"), [((100.0, 0.0, 60.0, 0.0), False), ((100.0, 0.0, 60.0, 10.0), True)])
def test_memory_needs_swings_of_three_sizes(levels: tuple[float, ...], nested: bool) -> None:
    found = seen(strokes(0.0, *levels, 100.0, 0.0, 100.0))
    assert met(found, "memory")[0] is nested
    assert met(found, "memory")[1] == f"swings of {found.seen.sizes} sizes" + ("" if nested else "; drive 3 or more")


@pytest.mark.parametrize(
    ("samples", "Ts_s", "enough"), [(500, 1e-3, True), (499, 1e-3, False), (320, 2e-3, True), (300, 2e-3, False)]
)
def test_creep_needs_half_a_second_and_one_and_a_half_decades_of_rest(samples: int, Ts_s: float, enough: bool) -> None:
    """Decades count from ten samples on: at 2 ms, one and a half of them end at 0.632 s."""
    u_V = np.concatenate([strokes(0.0, 100.0, 0.0, 70.0), np.full(samples - 1, 70.0), strokes(70.5, 20.0)])
    u_V[-200 - samples :][:samples] = 70.0
    found = seen(u_V, Ts_s)
    assert found.seen.longest_rest_s == pytest.approx(samples * Ts_s)
    held, why = met(found, "creep")
    assert held is enough
    assert why == f"longest rest {found.seen.longest_rest_s:.3g} s" + (
        "" if enough else "; only strong creep shows, hold the voltage for 0.5 s or more"
    )


def test_the_band_is_where_the_speed_has_its_power() -> None:
    k = np.arange(10_000)
    sine = seen(50 + 40 * np.sin(2 * np.pi * 5.0 * TS_S * k))
    assert (sine.seen.lowest_Hz, sine.seen.highest_Hz) == (pytest.approx(5.0, abs=0.11), pytest.approx(5.0, abs=0.11))
    band = f"{sine.seen.lowest_Hz:.3g} to {sine.seen.highest_Hz:.3g} Hz"
    assert met(sine, "delay") == (False, f"{band}; lag and delay look alike at one frequency: drive a decade")
    for second_Hz, wide in ((14.0, False), (16.0, True)):
        two = seen(50 + 30 * np.sin(2 * np.pi * 5.0 * TS_S * k) + 10 * np.sin(2 * np.pi * second_Hz * TS_S * k))
        assert two.seen.highest_Hz == pytest.approx(second_Hz, abs=0.11)
        assert met(two, "delay")[0] is wide
    assert met(sine, "resonance") == (
        True,
        f"the voltage has power up to {sine.seen.highest_Hz:.4g} Hz of 500 Hz that the sampling shows",
    )
    assert met(sine, "slew") == (True, f"limits below {sine.seen.fastest_V_per_s:.4g} V/s")
    assert met(sine, "periodic") == (True, "lines above 0.4 Hz and below 500 Hz")
    assert met(sine, "outliers") == (True, f"jumps above about {8 * sine.seen.noise.rms_um:.2g} um")
    assert met(sine, "saturation") == (True, "only where the amplifier clips inside 10 .. 90 V")


@pytest.mark.parametrize(("late_V", "returns"), [(51.9, True), (52.1, False)])
def test_slow_causes_need_the_first_level_again_late_in_the_record(late_V: float, returns: bool) -> None:
    """The median of the first fifth is 50 V of a range of 100 V; the last fifth stays above late_V."""
    u_V = np.concatenate([np.full(1000, 50.0), strokes(50.0, 0.0, 100.0, samples=1500), np.full(1000, late_V)])
    found = seen(u_V)
    assert met(found, "drift")[0] is returns
    assert met(found, "aging")[0] is returns
    words = "the voltage comes back to a level late in the record" if returns else "come back to a level later"
    assert met(found, "drift")[1] == words
    words = "swings early and late at one level" if returns else "repeat the first swings at the end"
    assert met(found, "aging")[1] == words


def test_channels_are_named_with_their_ranges() -> None:
    u_V = strokes(0.0, 100.0, 0.0, 60.0, 20.0)
    assert met(seen(u_V), "coupling") == (False, "no further channel in the file")
    found = seen(u_V, temp=np.linspace(20.0, 25.0, u_V.size))
    assert met(found, "coupling") == (True, "temp")
    assert "channel temp: 20 .. 25" in str(found)
    json = found.to_json()
    assert json["channels"] == {"temp": [20.0, 25.0]}
    assert (json["samples"], json["Ts_s"], json["duration_s"]) == (800, TS_S, 0.8)
    assert json["excitation"]["swings"] == found.seen.swings
    assert json["excitation"]["fastest_V_per_s"] == found.seen.fastest_V_per_s
    assert [need["cause"] for need in json["requirements"]] == list(VOCABULARY), "every cause is asked"
