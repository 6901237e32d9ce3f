"""What the studies draw, excite, score and print: both ends of each draw, closed forms, cells of made-up runs."""

import dataclasses
import math
from typing import Any, cast

import numpy as np
import pytest

from fixtures.ends import Ends
from hysgen.diagnosis.causes import Estimate
from hysgen.model.model import Grid, Model
from hysgen.record import Record
from hysgen_lab.firmware import tracking
from hysgen_lab.firmware.tracking import TrackingResult
from hysgen_lab.stage import CreepEffect, Stage
from hysgen_lab.studies import coverage
from hysgen_lab.studies.bank.family_scenario import Sensor
from hysgen_lab.studies.bank.judge_records import PARAMETERS, compare_parameters, limits
from hysgen_lab.studies.bank.result import BankResult, Judgement
from hysgen_lab.studies.bank.scenario import scenario
from hysgen_lab.studies.endurance import CASES, EnduranceResult, EnduranceTest, endurance_tests, rows
from hysgen_lab.studies.endurance.compiled_learner import excitations, persistent_excitation
from hysgen_lab.studies.paper import learning
from hysgen_lab.studies.paper.experiments import CASES as TRACKED
from hysgen_lab.verbs.studies import tracking_table

LOW, HIGH = cast(Any, Ends(0.0)), cast(Any, Ends(1.0))


def test_a_sensor_bends_jitters_and_rounds() -> None:
    y_um = np.linspace(2.0, 6.0, 4001)
    bent = Sensor(0.01, 0.0, 40).reading(y_um, 1)
    share = (y_um - 2.0) / 4.0
    np.testing.assert_allclose(bent - y_um, 0.04 * share * (1.0 - share), atol=1e-9)
    early = (Sensor(0.0, 0.1, 40).reading(y_um, 1) - y_um)[1:] / 1e-3
    # 4000 normal jitters: five standard errors.
    assert early.std() == pytest.approx(0.1, rel=5 / math.sqrt(2 * 4000))
    assert np.abs(Sensor(0.0, 9.0, 40).reading(y_um, 1) - y_um).max() == pytest.approx(1e-3)
    # The converter's range is twice the span.
    assert np.diff(np.unique(Sensor(0.0, 0.0, 5).reading(y_um, 1))) == pytest.approx(8.0 / 32)


def judged(seed: int, **more: Any) -> Judgement:
    given: dict[str, Any] = {
        "category": "creep", "rate_Hz": 1e3, "excitation": "good", "planted": ("creep",), "required": ("creep",),
        "named": ("creep",), "relative": {"creep": 2.0}, "errors": {}, "seconds": 1.0, "experiment": "",
    }  # fmt: skip
    return Judgement(**(given | more), seed=seed)


def test_limits_of_the_bank_are_those_that_are_stated() -> None:
    assert PARAMETERS == {
        "saturation.low_V": 0.01, "saturation.high_V": 0.01, "slew.rate_V_per_s": 0.05, "creep.per_decade": 0.15,
        "delay.delay_samples": 0.2, "resonance.f_Hz": 0.02, "resonance.zeta": 0.3, "periodic.f_Hz": 0.1,
    }  # fmt: skip

    def marks(records: list[Judgement]) -> dict[str, tuple[str, str, str]]:
        found = limits(BankResult(tuple(records), (0,), len(records)))
        return {limit.name: (limit.wanted, limit.measured, limit.mark) for limit in found}

    # 200 records, of which 10 or 11 are not exact; 100 of them quiet with one false alarm.
    def run(inexact: int, missed: int, alarms: int) -> dict[str, tuple[str, str, str]]:
        loud = [judged(i, named=("creep", "drift") if i < inexact - missed else ("creep",)) for i in range(100)]
        loud[50 : 50 + missed] = [judged(i, named=()) for i in range(50, 50 + missed)]
        quiet = [judged(i, category="none", planted=(), required=(), relative={},
                        named=("drift",) if i < alarms else ()) for i in range(100)]  # fmt: skip
        return marks([*loud, *quiet])

    assert run(10, 2, 0)["exact set of causes"] == (">= 95 % of 200 records", "95.0 % of 200", "met")
    assert run(11, 2, 0)["exact set of causes"][1:] == ("94.5 % of 200", "MISSED")
    assert run(10, 2, 0)["required causes found"] == (">= 98 %", "98.0 % of 100", "met")
    assert run(10, 3, 0)["required causes found"][1:] == ("97.0 % of 100", "MISSED")
    assert run(0, 0, 1)["false alarms"] == ("<= 1 in 100 quiet records", "1 in 100", "met")
    assert run(0, 0, 2)["false alarms"][1:] == ("2 in 100", "MISSED")
    few = marks([judged(i) for i in range(199)])
    assert (few["exact set of causes"][2], few["required causes found"][2]) == ("met so far", "met so far")
    assert few["false alarms"] == ("<= 1 in 100 quiet records", "0 in 0", "-")
    for value, mark in ((7.0, "met"), (6.99, "MISSED")):
        assert marks([judged(1, fall=value)])["fall by the memory extension"][::2] == (">= 7 times", mark)
    for value, mark in ((2.0, "met"), (2.01, "MISSED")):
        found = marks([judged(1, over_truth=value), judged(2, over_truth=1.5)])["error over that with the truth known"]
        assert found == ("<= 2", f"{value:.2f} at most, 2 records", mark)
    error = marks([judged(1, errors={"creep.per_decade": -0.15}), judged(2, errors={"creep.per_decade": 0.1})])
    assert error["error of creep.per_decade"] == ("<= 0.15", "0.15, 2 records", "met")
    assert error["error of resonance.f_Hz"] == ("<= 0.02", "no record", "-")
    for inexact, count, mark in ((4, 42, "met"), (5, 42, "MISSED"), (4, 41, "met so far")):
        part = [judged(i, family="relays", named=("creep",) if i >= inexact else ()) for i in range(count)]
        assert marks([*part, judged(9)])["exact set, relays"][2] == mark
    assert marks([*part, judged(9)])["exact set, own stage"][:2] == (">= 90 % of 42 records", "100.0 % of 1")


def test_the_table_of_the_bank_holds_every_rate() -> None:
    records = (
        judged(
            1,
            over_probe=1.25,
            gain=3.0,
            fall=8.0,
            over_truth=1.5,
            errors={"creep.per_decade": 0.1},
            confidence={"creep": 0.95},
        ),
        judged(2, named=("drift",), relative={"creep": 4.0}, fall=10.0, over_truth=1.7),
        judged(3, category="none", planted=(), required=(), named=(), relative={}, family="thermal"),
    )
    text = BankResult(records, (1, 3), 3).table().splitlines()
    row = next(line for line in text if line.startswith("creep "))
    head = text[1].split()
    # A column of eight letters each; drift once, creep once.
    assert [(head[i], cell) for i, cell in enumerate(row.split()[1:]) if cell != "."] == [
        ("creep", "1"),
        ("drift", "1"),
    ]
    for line in (
        "exact set of causes    66.7 %  of 3 records",
        "required and found     50.0 %  of 2 causes",
        "false alarms            0.0 %  of 1 records, nothing hidden",
        "hidden (rows) named as (columns)",
        "smallest effect found, as a multiple of what memory alone leaves (50 % / 95 % of the time):",
        "parameters, median and largest error:",
        "named with a confidence from .. on, and there:",
        "category         exact     delivered over probe: median, largest     gain: median",
        "  creep         1 of   2      1.25      1.25      3.00  creep 1",
        "  none          1 of   1         -         -         -",
        "  own stage         exact   1 of   2",
        "  thermal           exact   1 of   1",
        "  creep           2.00 /     nan",
        "  creep.per_decade                       0.1       0.1  of 1",
        "   90.0 %    1 of 1",
        "memory of the Preisach kind alone: error falls 9.0 times (median of 2 records; "
        "worst 8.0, a tenth below 8.2, best 10.0)",
        "error over that with the truth known: median 1.60, 95 % below 1.69, "
        "largest 1.70 (2 records with every planted cause extended)",
    ):
        assert line in text, line
    bare = BankResult(records[2:], (1,), 1).table()
    assert "Preisach" not in bare
    assert "with the truth known" not in bare
    assert "own stage" not in bare


RESULT = EnduranceResult(
    EnduranceTest("sine", 0.999, 1e6, 50_000), 40_000, None, 1e-3, 2.0, 3.0, 4.0, 2.0, 4.0, {"restarts": 7},
    1.1, 1.234, 77,
)  # fmt: skip


def test_endurance_holds_up_to_its_bounds_and_says_so() -> None:
    assert RESULT.holds
    for fault in (
        {"largest_d": 2.01}, {"largest_theta_um": 4.01}, {"recovered": 1.101}, {"broken_at": 1},
    ):  # fmt: skip
        assert not dataclasses.replace(RESULT, **cast(Any, fault)).holds
    broken = dataclasses.replace(RESULT, broken_at=9, paper_lost_at=None)
    assert rows([RESULT, broken]) == [
        ("sine", "0.999", "1e+06", "5e+04", "40000", "1.0e-03 .. 2.0e+00", "3.0e+00", "4.0e+00", "7", *end)
        for end in (("hold", "1.100", "1.234", "dies at 77"), ("broken at 9", "1.100", "1.234", "survives"))
    ]
    told = RESULT.to_json()
    assert (told["trial"], told["printed_dies_at"], told["holds"]) == (dataclasses.asdict(RESULT.test), 77, True)
    tests = endurance_tests(5000, 2000)
    assert tests[: len(CASES)] == [EnduranceTest(case, 0.999, 1e6, 5000) for case in CASES]
    assert {(test.forgetting, test.alpha, test.samples) for test in tests[len(CASES) :]} == {
        (forgetting, alpha, 2000) for forgetting in (1.0, 0.9999, 0.99) for alpha in (1e6, 1e3)
    }
    assert (len(tests), len(endurance_tests(5000, 0)), len(endurance_tests(0, 2000))) == (49, 7, 42)


def test_excitations_of_the_endurance_test_are_those_they_are_named_after() -> None:
    drawn = excitations(Stage(lag_s=0.0, memory=None).quiet())
    assert set(drawn) == set(CASES)
    t_s = 20e-6 * np.arange(100_000)
    np.testing.assert_allclose(drawn["sine"].u_V, 50 + 40.5 * np.sin(2 * np.pi * 100 * t_s), atol=1e-9)
    # From the upper level down for a second, and back.
    triangle = drawn["triangle"].u_V
    assert triangle[[0, 25_000, 50_000, 75_000]] == pytest.approx([90.5, 50.0, 9.5, 50.0])
    clipped = drawn["saturation"].u_V
    assert (clipped.min(), clipped.max(), np.mean((clipped > 5.0) & (clipped < 95.0))) == pytest.approx(
        (5.0, 95.0, 2 / np.pi * np.arcsin(1 / 8)), abs=2e-3
    )
    assert set(drawn["constant"].u_V) == {50.0}
    noise = drawn["noise"]
    assert (noise.noise_um, noise.noise_V, np.ptp(noise.y_um), set(noise.u_V)) == (0.3, 10.0, 0.0, {50.0})
    assert noise.y_um[0] == pytest.approx(50.0 * 10 / 120, rel=1e-3)
    bursts, spikes = drawn["bursts"], drawn["spikes"]
    assert (bursts.burst_every, bursts.burst_length, bursts.spike_every) == (1009, 16, 0)
    assert (spikes.burst_every, spikes.spike_every, spikes.noise_um) == (0, 997, 0.0005)
    # The reading is that of the second period: a stage without memory is one sample behind, the first sample included.
    np.testing.assert_allclose(drawn["sine"].y_um, 10 / 120 * np.roll(drawn["sine"].u_V, 1), atol=1e-4)
    for seconds in (0.4, 1.0):
        u_V = persistent_excitation(3, seconds)
        assert (u_V.size, u_V[0]) == (round(seconds * 50_000), 5.0)
        tops = u_V.reshape(-1, 500).max(axis=1)[:12]
        amplitudes = np.random.default_rng(3).uniform(0.15, 1.0, 12)
        assert tops == pytest.approx([95.0, *(5.0 + 90.0 * amplitudes[1:-1]), 95.0])


def test_learning_is_judged_after_two_seconds_of_a_gain_lost_by_a_tenth() -> None:
    first, *others = learning.DISTURBANCES
    assert first == f"gain falls by {100 * learning.GAIN_LOST:g} %"
    assert pytest.approx(10 / 120) == learning.DATASHEET_UM_PER_V
    assert pytest.approx(math.exp(-0.02)) == learning.DATASHEET_POLE
    assert pytest.approx(200) == learning.OBSERVED_S / learning.COMMIT_PERIOD_S
    constant = Model("m", 2e-5, Grid(0.0, 9.0, 2), np.array([[0.0, 0.0, 3.0]] * 2), 0.0, 90.0)
    reading = np.where(np.arange(1500) < 1000, 0.0, 7.0)
    record = Record.from_arrays(np.linspace(0.0, 90.0, 1500), reading, 2e-5)
    # The first 20 ms, 1000 samples, do not count.
    assert learning._free_run_rms_um(constant, record) == pytest.approx(4.0)
    y_um = np.array([1.0, 2.0, 3.0, 6.0])
    made = [cast(Any, learning.DISTURBANCES[name])(y_um) for name in others]
    np.testing.assert_allclose(made[0], [5.0, 4.0, 3.0, 0.0])
    np.testing.assert_allclose(made[1], 1.0)
    assert sorted(made[2]) == [1.0, 2.0, 3.0, 6.0]
    np.testing.assert_allclose(made[3], [1.0, np.nan, 3.0, np.nan])


def test_tracking_by_the_firmware_is_scored_from_the_end_of_the_rest_on() -> None:
    rest, second = 10_000, 50_000  # 0.2 s and 1 s at 50 kHz
    reference = np.zeros(rest + 2 * second)
    reading = np.concatenate([np.full(rest, 9.0), np.full(second, 0.003), np.full(second, -0.001)])
    assert tracking._errors_nm(reading, reference) == pytest.approx(
        {"rms_nm": math.sqrt(5.0), "mean_nm": 1.0, "spread_nm": 2.0, "last_nm": 1.0}
    )
    assert tracking._range_V(reading) == (-0.001, 0.003)
    wanted = tracking._reference(100.0, 0.01)
    assert set(wanted[: rest + 1]) == {2.0}
    assert wanted[rest + 125] == pytest.approx(2.6)
    assert (tracking.SECONDS, tracking.FREQUENCIES_HZ) == (10.0, (50.0, 100.0))
    assert {case.f_Hz: case.published.e_rms_nm for case in TRACKED} == tracking.PAPER_NM
    # White noise of 0.5 nm, and the rounding to 0.5 nm.
    assert tracking.sensor_noise_nm() == pytest.approx(math.hypot(0.5, 0.5 / math.sqrt(12)))
    one = TrackingResult("loop", 50.0, 1.234, -0.5, 1.1, 0.9, (10.04, 60.06), 3, "OK")
    text = tracking_table([one], 0.52).splitlines()
    assert text[2].split() == ["50", "Hz,", "loop", "1.23", "-0.50", "1.10", "0.90", "10.0", "..", "60.1", "3"]
    assert text[3] == "sensor: 0.52 nm rms; the paper's own stage, by its inverse: 18.6 nm at 50 Hz, 15.2 nm at 100 Hz"


def test_coverage_is_the_mean_over_stages_with_its_standard_error(monkeypatch: pytest.MonkeyPatch) -> None:
    shares = {3: (0.9, 0.2), 4: (1.0, 0.4), 5: (0.95, 0.6)}
    monkeypatch.setattr(coverage, "one_stage", lambda seed: shares[seed])
    found = coverage.coverage(3, 3)
    assert dataclasses.astuple(found) == pytest.approx((3, 0.95, 0.05 / math.sqrt(3), 0.4))
    assert str(found).startswith("3 stages: 95.0 % of the errors within U (+- 2.9 %); the sensor is 40 %")
    assert math.isnan(coverage.coverage(1, 3).error)
    for rng, slow, fast in ((LOW, 1.0, 8.0), (HIGH, 4.0, 25.0)):
        t_s = 2e-4 * np.arange(6000)
        envelope = 0.6 + 0.4 * np.cos(2 * np.pi * t_s * (0.5 if rng is LOW else 1.5) + (0.0 if rng is LOW else 6.28))
        wave = 0.7 * envelope * np.sin(2 * np.pi * slow * t_s) + 0.3 * np.sin(2 * np.pi * fast * t_s)
        np.testing.assert_allclose(coverage.drive(rng), 50 + 50 * wave, atol=1e-9)


def test_errors_of_parameters_are_taken_from_the_first_effect_of_a_kind() -> None:
    hidden: Any = dataclasses.replace(
        scenario("none", 1),
        u_V=np.array([0.0, 50.0]),
        stage=Stage().with_effects(
            periodic=[(40.0, 0.2), (70.0, 0.1)], saturation=(-5.0, 40.0), creep=CreepEffect(0.02, 0.1)
        ),
    )
    found = {"periodic.f_Hz": 40.5, "periodic.amplitude_um": 0.1, "saturation.high_V": 41.0, "creep.per_decade": 0.03,
             "creep.from_s": 9.0, "drift.ramp_um_per_s": 1.0}  # fmt: skip
    spreads = {"periodic.f_Hz": 0.25, "creep.per_decade": 0.01}
    estimates = {key: Estimate(value, spreads.get(key, math.nan)) for key, value in found.items()}
    compared = compare_parameters(hidden, estimates)
    assert {key: one.error for key, one in compared.items()} == pytest.approx(
        {"periodic.f_Hz": 0.5, "periodic.amplitude_um": -0.5, "saturation.high_V": 0.02, "creep.per_decade": 0.5}
    )
    # The truth lies two standard errors of the frequency, and one of the creep, below the estimates.
    ranks = {key: one.rank for key, one in compared.items() if math.isfinite(one.rank)}
    assert ranks == pytest.approx({"periodic.f_Hz": 0.02275, "creep.per_decade": 0.15866}, abs=1e-5)
