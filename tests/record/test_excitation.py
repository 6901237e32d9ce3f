"""Too few samples are refused, poor excitation and exceeded ranges are warnings, sufficient records pass."""

from dataclasses import replace
from importlib.resources import as_file, files

import numpy as np
import pytest

from hysgen.errors import RecordError
from hysgen.fitting import check_for_fit
from hysgen.record import Record, check_validation, load_record
from hysgen.record.series import turning_rows
from hysgen_lab.stage import Stage, run
from hysgen_lab.stage.signals import fig5

TS_S = 20e-6
LAB = Stage.laboratory()
STATIC = replace(Stage(), memory=None, lag_s=0.0)


def driven(stage: Stage, u_V: np.ndarray) -> Record:
    return Record.from_arrays(u_V, run(stage, u_V, TS_S, seed=2).displacement_um, TS_S, source="run.csv")


FIG5 = driven(LAB, fig5(TS_S, "identification"))


def test_too_few_samples_for_the_rules_are_refused_with_the_number_needed() -> None:
    with pytest.raises(
        RecordError, match=r"run\.csv\[0:72\]: 72 samples are too few for 6 rules with 18 parameters \(at least 73\)"
    ):
        check_for_fit(FIG5.rows(0, 72), 6, 18)
    check_for_fit(FIG5.rows(0, 73), 6, 18)
    with pytest.raises(RecordError, match=r"at least 122\); record longer, or choose fewer rules"):
        check_for_fit(Record.joined(FIG5.rows(0, 60), FIG5.rows(60, 121)), 6, 30)


@pytest.mark.parametrize("rules", [1, 6, 30])
def test_bundled_record_is_not_warned_about(rules: int) -> None:
    with as_file(files("hysgen.record") / "demo_stage.csv") as path:
        assert check_for_fit(load_record(path), rules, 3 * rules + 12) == ()


def test_rules_passed_only_in_the_first_rise_are_named() -> None:
    (line,) = check_for_fit(FIG5, 15, 45)
    assert "tells about 43 of 45 rule coefficients apart: voltage and displacement move as one in rules 3, 4;" in line
    # The signal passes them once, from rest to its first cycle; every later cycle turns above them.
    y_um = FIG5.segments[0].y_um
    low, high = FIG5.y_range_um
    assert y_um[200:].min() > low + 3.5 / 14 * (high - low)
    assert check_for_fit(FIG5, 6, 18) == ()


def test_ramp_on_a_proportional_stage_tells_no_voltage_slope_from_displacement_slope() -> None:
    ramp = driven(STATIC, np.linspace(0.0, 100.0, 5000))
    tells, turns = check_for_fit(ramp, 6, 18)
    assert (
        "tells about 12 of 18 rule coefficients apart: voltage and displacement move as one in rules 1, 2, 3, 4, 5"
        in tells
    )
    assert "the voltage turns 0 times" in turns


def test_swings_of_one_size_and_two_speeds_are_not_called_alike() -> None:
    k = np.arange(3000)
    u_V = 50 + 40 * np.sin(2 * np.pi * np.where(k < 1500, k / 500, k / 250))
    assert not [line for line in check_for_fit(driven(LAB, u_V), 6, 18) if "alike" in line]


def test_noise_alone_does_not_tell_coefficients_apart() -> None:
    k = np.arange(5000)
    u_V = 50 + 40 * np.sin(k / 100)
    y_um = 0.1 * u_V + 0.01 * np.random.default_rng(4).normal(size=k.size)
    # A cell of the 20 is 0.4 um wide: noise of 0.01 um there is a tenth of the movement, more than SEPARATE.
    tells = check_for_fit(Record.from_arrays(u_V, y_um, 1e-3), 20, 60)[0]
    assert "tells about 40 of 60 rule coefficients apart" in tells


def test_signal_near_half_the_sampling_rate_is_not_taken_for_noise() -> None:
    u_V, y_um = np.random.default_rng(4).normal(size=(2, 5000))
    assert not [line for line in check_for_fit(Record.from_arrays(u_V, y_um, 1e-3), 4, 12) if "apart" in line]


def test_rules_that_are_hardly_visited_are_named_with_their_samples() -> None:
    k = np.arange(4000)
    u_V = 20 + (10 + 5 * (k > 2000)) * np.sin(k / 50)
    y_um = 0.1 * u_V + 0.03 * np.cos(k / 50)
    y_um[3000:3003] += 6.0  # a visit of three samples to the far end
    empty, tells = check_for_fit(Record.from_arrays(u_V, y_um, 1e-3), 8, 24)
    assert "4 of 8 rules see fewer than 12 samples: rule 5 (y near 4.508 um: 0), 6 (y near 5.51 um: 0)" in empty
    assert "8 (y near 7.514 um: 3)" in empty
    assert "12 of 24" in tells


def test_turning_rows_are_the_extremes_and_not_the_wiggles() -> None:
    k = np.arange(1001)
    clean = 50 * np.sin(2 * np.pi * k / 200)
    assert turning_rows(clean, 2.0).tolist() == [50, 150, 250, 350, 450, 550, 650, 750, 850, 950]
    noisy = clean + 0.3 * np.random.default_rng(3).normal(size=k.size)
    rows = turning_rows(noisy, 5.0)
    assert rows.size == 10
    np.testing.assert_allclose(rows, 50 + 100 * np.arange(10), atol=12)  # 50 (1 - cos) < 4 sigma within 12 samples
    assert turning_rows(np.linspace(0.0, 1.0, 50), 0.02).size == 0
    on_plateaus = np.repeat([0.0, 1.0, 0.5, 2.0], [2, 3, 2, 2])
    assert on_plateaus[turning_rows(on_plateaus, 0.1)].tolist() == [1.0, 0.5]


def test_validation_that_leaves_range_speed_and_channels_is_warned_about_with_numbers() -> None:
    k = np.arange(1000)
    wave = np.round(np.sin(2 * np.pi * k / 100), 3)
    y_um = 1 + 0.5 * np.round(np.sin(2 * np.pi * (k - 3) / 100), 3)
    small = Record.from_arrays(10 + 5 * wave, y_um, 1e-3, {"temp": k}, source="a")
    large = Record.from_arrays(10 + 9 * wave, y_um, 1e-3, source="b")
    voltage, speed, channel = check_validation(small, large)
    outside = np.count_nonzero(np.abs(9 * wave) > 5 + 0.005 * 10)
    assert f"b: voltage 1..19 V leaves the identified 5..15 V in {outside} of 1000 samples" in voltage
    # The largest step of the rounded sine is 0.063 per millisecond.
    assert "b: voltage moves by up to 567 V/s, in identification by up to 315 V/s" in speed
    assert "b: lacks the channel temp of a" in channel
    assert check_validation(large, small) == ()


def test_validation_at_another_period_is_refused() -> None:
    segment = FIG5.segments[0]
    other = Record.from_segments([segment], 2 * TS_S, "slow.csv")
    with pytest.raises(RecordError, match=r"slow\.csv: sampled every 4e-05 s, but run\.csv every 2e-05 s; resample"):
        check_validation(FIG5, other)
