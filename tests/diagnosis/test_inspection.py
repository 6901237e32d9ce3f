"""What a record holds and could show: counts, frequencies, and what would show of each cause."""

import itertools

import numpy as np
import pytest

from hysgen.diagnosis.causes import VOCABULARY
from hysgen.diagnosis.identifiability import Ability, Inspection, inspect
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


def able(found: Inspection, cause: str) -> Ability:
    (ability,) = (ability for ability in found.abilities if ability.name == cause)
    return ability


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


def test_the_band_is_where_the_speed_has_its_power() -> None:
    k = np.arange(10_000)
    sine = seen(50 + 40 * np.sin(2 * np.pi * 5.0 * TS_S * k))
    assert (sine.seen.lowest_Hz, sine.seen.highest_Hz) == (pytest.approx(5.0, abs=0.11), pytest.approx(5.0, abs=0.11))
    two = seen(50 + 30 * np.sin(2 * np.pi * 5.0 * TS_S * k) + 10 * np.sin(2 * np.pi * 14.0 * TS_S * k))
    assert two.seen.highest_Hz == pytest.approx(14.0, abs=0.11)
    # Lag and delay look alike at one frequency, and a straight line needs no hysteresis.
    assert able(sine, "delay").hidden_by != ""
    assert able(two, "delay").hidden_by == ""
    assert 1e-5 < (able(two, "memory").least or 0.0) < 1e-2


def test_what_moves_a_mode_is_not_judged_before_a_mode_is_known() -> None:
    """Softening falls the frequency of a mode, and no mode is known before a search."""
    found = seen(strokes(0.0, 100.0, 0.0, 60.0, 20.0))
    assert able(found, "softening").text() == "not judged: no resonance is known that it changes"
    assert [need["met"] for need in found.to_json()["requirements"] if need["cause"] == "softening"] == [False]
    assert ["softening", "", able(found, "softening").text()] in found.summary().rows


def test_what_a_record_too_short_to_be_diagnosed_could_show_is_not_said() -> None:
    """Of 614 rows 399 are identified from, of 615 are 400."""
    short, enough = (seen(strokes(0.0, 100.0, 0.0, samples=400)[:rows]) for rows in (614, 615))
    assert short.abilities == ()
    assert "400" in short.warnings[-1]
    assert len(enough.abilities) == len(VOCABULARY)


def test_channels_are_named_with_their_ranges() -> None:
    u_V = strokes(0.0, 100.0, 0.0, 60.0, 20.0)
    assert able(seen(u_V), "coupling").text().startswith("not excited: record the other axes")
    found = seen(u_V, temp=np.linspace(20.0, 25.0, u_V.size))
    assert "for a standard deviation of temp" in able(found, "coupling").text()
    assert "channel temp: 20 .. 25" in str(found)
    json = found.to_json()
    assert json["channels"] == {"temp": [20.0, 25.0]}
    assert (json["samples"], json["Ts_s"], json["duration_s"]) == (800, TS_S, 0.8)
    assert json["excitation"]["swings"] == found.seen.swings
    assert json["excitation"]["fastest_V_per_s"] == found.seen.fastest_V_per_s
    assert [need["cause"] for need in json["requirements"]] == list(VOCABULARY), "every cause is asked"
    assert [need["met"] for need in json["requirements"]] == [able(found, name).excited is True for name in VOCABULARY]
