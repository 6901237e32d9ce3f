"""The next experiment: what a voltage lacks, the voltage that has it, and what a stage shows under that voltage."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import cont2discrete, lfilter

import hysgen
from fixtures.foreign_stages import elasto_slide
from hysgen.cli.main import main
from hysgen.diagnosis.evaluation import name_causes
from hysgen.diagnosis.experiment import (
    BAND,
    BAND_RANGE,
    LATE,
    LEVELS,
    Limits,
    Piece,
    in_words,
    lacking,
    voltage,
    with_time_for,
)
from hysgen.errors import HysgenError
from hysgen.record import Record
from hysgen.record.series import plateaus

K = np.arange(6000)
REST = np.full(1500, 50.0)
LIMITS = Limits(-20.0, 100.0, 2e4, 4.0, 2e-4)


@pytest.mark.parametrize(
    ("u_V", "lacks"),
    [
        (50.0 + 40.0 * np.sin(K / 50.0), {Piece.NESTED, Piece.RATES, Piece.RESTS}),
        (np.concatenate([50.0 + 40.0 * np.sin(K / 50.0), REST]), {Piece.NESTED, Piece.RATES}),
        (np.linspace(0.0, 1.0, 500) ** 2, {Piece.NESTED, Piece.RESTS}),
        (50.0 + 40.0 * np.exp(-K / 2000.0) * np.sin(K / 50.0), {Piece.RATES, Piece.RESTS}),
        (50.0 + 40.0 * np.sin(2e-5 * K**2.0), {Piece.NESTED, Piece.RESTS}),
        (np.concatenate([50.0 + 40.0 * np.exp(-K / 2000.0) * np.sin(1e-5 * K**2.0), REST]), set()),
    ],
    ids=["sine", "sine and rest", "no turns", "nested", "swept", "rich"],
)
def test_what_a_voltage_lacks_follows_from_turns_swings_durations_and_rests(u_V: np.ndarray, lacks: set[Piece]) -> None:
    assert set(lacking(u_V, ())) == lacks
    assert set(lacking(u_V, [Piece.BAND, "record longer"])) == lacks | {Piece.BAND}


@settings(max_examples=60, deadline=None)
@given(
    st.sets(st.sampled_from(list(Piece)), min_size=1),
    st.floats(-100.0, 100.0),
    st.floats(1e-3, 300.0),
    st.floats(1.0, 1e5),
    st.floats(0.05, 2.0),
)
def test_no_voltage_leaves_its_limits(
    chosen: set[Piece], low_V: float, range_V: float, slew_V_s: float, seconds: float
) -> None:
    pieces = [piece for piece in Piece if piece in chosen]
    limits = Limits(low_V, low_V + range_V, slew_V_s * range_V, seconds, 1e-3)
    u_V = voltage(pieces, with_time_for(pieces, limits))
    assert low_V <= u_V.min() <= u_V.max() <= limits.high_V
    assert np.abs(np.diff(u_V, prepend=low_V)).max() <= limits.slew_V_s * limits.Ts_s * (1.0 + 1e-6) + 1e-12
    assert u_V[-1] == low_V


def test_a_voltage_of_all_pieces_lacks_none_of_them_in_either_part() -> None:
    u_V = voltage(list(Piece), LIMITS)
    assert len(u_V) * LIMITS.Ts_s <= LATE * LIMITS.seconds
    cut = round(0.65 * len(u_V))
    assert lacking(u_V[:cut], ()) == ()
    assert lacking(u_V[cut:], ()) == ()


def test_steps_go_at_the_slew_limit_to_many_levels_and_the_band_holds_every_frequency_below_its_end() -> None:
    stepped = voltage([Piece.STEPS], LIMITS)
    assert np.abs(np.diff(stepped)).max() == pytest.approx(LIMITS.slew_V_s * LIMITS.Ts_s, rel=0.05)
    assert len({round(stepped[begin], 6) for begin, _ in plateaus(stepped)}) >= LEVELS
    banded = voltage([Piece.BAND], LIMITS)
    half = banded[len(banded) // 8 : len(banded) // 2]
    power = np.abs(np.fft.rfft((half - half.mean()) * np.hanning(half.size))) ** 2
    inside, beyond = power[20 : int(0.95 * BAND * half.size)], power[int(1.5 * BAND * half.size) :]
    assert np.quantile(inside, 0.05) > 100.0 * np.quantile(beyond, 0.95)
    assert np.ptp(half) <= BAND_RANGE * LIMITS.range_V * (1.0 + 1e-9)


def test_words_state_the_levels_and_times_of_this_voltage() -> None:
    words = in_words([Piece.RATES, Piece.STEPS], LIMITS)
    assert words.startswith("drive with strokes of -20 .. 100 V in 0.38 s and in 0.038 s")
    assert words.endswith("12 steps inside -20 .. 100 V at 2e+04 V/s, to see a slew limit")
    assert in_words([], LIMITS) == ""


def test_limits_that_leave_no_room_are_refused_in_one_line() -> None:
    with pytest.raises(HysgenError, match=r"at 100 V/s the pieces take .* s, not 4 s: state more seconds or a faster"):
        voltage([Piece.RATES], dataclasses.replace(LIMITS, slew_V_s=100.0))
    with pytest.raises(HysgenError, match="state the lower voltage first"):
        dataclasses.replace(LIMITS, low_V=100.0)
    with pytest.raises(HysgenError, match="are positive"):
        dataclasses.replace(LIMITS, seconds=0.0)
    with pytest.raises(HysgenError, match="no further experiment is needed"):
        voltage([], LIMITS)


def test_the_verb_refuses_a_range_that_is_none_before_it_diagnoses(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record = tmp_path / "r.csv"
    u_V = 50.0 + 50.0 * np.sin(K / 50.0)
    rows = (f"{k * 1e-3:.3f},{u:.6f},{0.1 * u:.6f}" for k, u in enumerate(u_V))
    record.write_text("\n".join(["time_s,voltage_V,displacement_um", *rows]))
    assert main(["experiment", str(record), "-o", str(tmp_path / "next.csv"), "--range", "0-100"]) == 2
    assert "--range '0-100' is not LOW:HIGH in V, as 0:120" in capsys.readouterr().err
    assert not (tmp_path / "next.csv").exists()


def _played(u_V: np.ndarray, seed: int) -> Record:
    """A stage of elasto-slide elements with creep of 3 % a decade, a mode at 60 Hz, and noise of 2 nm, at 1 kHz."""
    Ts_s, omega = 1e-3, 2.0 * np.pi * 60.0
    rigid_um = 0.1 * elasto_slide(np.random.default_rng(3), u_V)
    moved_um, crept_um = rigid_um - rigid_um[0], np.zeros(u_V.size)
    for decay in np.exp(-Ts_s / np.geomspace(0.02, 5.0, 40)):
        crept_um += 0.03 * 2.4 / 40.0 * lfilter([0.0, 1.0 - decay], [1.0, -decay], moved_um)
    mode = cont2discrete(([omega**2], [1.0, 0.06 * omega, omega**2]), Ts_s, "bilinear")
    y_um = lfilter(np.ravel(mode[0]), mode[1], moved_um + crept_um)
    return Record.from_arrays(u_V, y_um + 2e-3 * np.random.default_rng(seed).standard_normal(u_V.size), Ts_s)


@pytest.mark.proof
def test_the_causes_of_a_stage_are_right_in_the_record_of_its_next_experiment() -> None:
    """After six seconds of triangles of one size; creep within 20 %."""
    triangle_V = 100.0 * np.abs((np.arange(6000) / 500.0) % 2.0 - 1.0)
    with pytest.warns(hysgen.RecordWarning, match="are alike"):
        study = hysgen.diagnose(_played(triangle_V, 1))
    planned = hysgen.next_experiment(study, slew_V_s=2e4, seconds=6.0)
    assert {able.name: able.verdict for able in planned.then}["creep"] in ("above", "named")
    naming = name_causes(_played(planned.u_V, 2))
    assert {"memory", "creep", "resonance"} <= set(naming.names)
    assert naming.estimates["creep.per_decade"].value == pytest.approx(0.03, rel=0.2)
