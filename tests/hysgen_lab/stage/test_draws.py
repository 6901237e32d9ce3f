"""What the virtual stages are drawn from: both ends of every interval by hand, and the numbers that never change."""

from __future__ import annotations

import math
from typing import Any, cast

import numpy as np
import pytest

from fixtures.ends import Ends
from hysgen_lab.stage import Stage, effects
from hysgen_lab.stage.effects import Setting, StageError
from hysgen_lab.stage.effects.base import Tolerance
from hysgen_lab.stage.effects.memory import BoucWen, Density, Preisach, Relays, draw_curve, draw_hysteresis
from hysgen_lab.stage.families import FAMILIES
from hysgen_lab.stage.families.base import around, scattered
from hysgen_lab.stage.families.bouc_wen import RisingBoucWen
from hysgen_lab.stage.families.plants import DRAWN, IDENTIFY, _Setting, plant
from hysgen_lab.stage.families.thermal import ThermalHysterons

LOW, HIGH = cast(Any, Ends(0.0)), cast(Any, Ends(1.0))
MIDDLE = cast(Any, Ends(0.5))

# Twenty samples of rest, then strokes of 1, 2, .. 100 V up and down: -50 .. 50 V, at most 1e5 V/s.
COMMAND = np.cumsum([*[0.0] * 21, *(n * (-1.0) ** (n + 1) for n in range(1, 101))])
SETTING = Setting(COMMAND, 1e-3, span_um=10.0, share=0.02, channels=("axis2_V", "spare"))
SPAN_S = 0.121

DRAWS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "aging": ({"fraction": -0.04, "over_s": SPAN_S}, {"fraction": 0.04}),
    "chirp": (
        {"first_Hz": 2.5, "last_Hz": 10.0, "over_s": SPAN_S, "amplitude_um": 0.1},
        {"first_Hz": 100.0, "last_Hz": 25.0, "amplitude_um": 0.3},
    ),
    "coupling": ({"um_per_unit": {"axis2_V": -0.2 / 30}}, {"um_per_unit": {"axis2_V": 0.2 / 30}}),
    "creep": ({"per_decade": 0.016, "tau_min_s": SPAN_S / 400, "tau_max_s": 121.0, "exponent": 0.0}, {}),
    "delay": ({"samples": 0.5, "seconds": 0.0}, {"samples": 12.0}),
    "drift": ({"ramp_um_per_s": -0.4 / SPAN_S, "walk_um_per_rt_s": 0.0}, {"ramp_um_per_s": 0.4 / SPAN_S}),
    "gain_step": ({"fraction": -0.03, "at_s": 0.25 * SPAN_S}, {"fraction": 0.08, "at_s": 0.75 * SPAN_S}),
    "jumps": ({"rate": 5 / 121, "size_um": 0.1}, {"rate": 12 / 121, "size_um": 0.3}),
    "outliers": ({"rate": 1e-3, "size_um": 1.6}, {"rate": 5e-3}),
    "periodic": ({"f_Hz": 40 / SPAN_S, "amplitude_um": 0.2, "phase_rad": 0.0}, {"f_Hz": 200.0, "phase_rad": 6.0}),
    "resonance": ({"f_Hz": 10.0, "zeta": 0.01, "share": 0.1}, {"f_Hz": 120.0, "zeta": 0.06, "share": 0.7}),
    # The lower level is not reached, then both are.
    "saturation": ({"low_V": -60.0, "high_V": 46.0}, {"low_V": -25.0, "high_V": 25.0}),
    "slew": ({"V_per_s": 75.25e3}, {"V_per_s": 97.03e3}),
    "stick_slip": ({"breakaway_um": 0.2, "left": 0.2, "scatter": 0.3}, {"breakaway_um": 0.6}),
}
NUMBERS = {  # rank, most at once, number in the bank
    "memory": (0, 1, 11), "bandwidth": (1, 1, None), "saturation": (2, 1, 3), "slew": (3, 1, 4), "creep": (4, 1, 0),
    "delay": (5, 1, 2), "drift": (6, 1, 5), "aging": (7, 1, 7), "outliers": (8, 1, 8), "coupling": (9, 1, 9),
    "stick_slip": (10, 1, 13), "noise": (11, 1, None), "resonance": (12, 4, 1), "periodic": (13, 16, 6),
    "jumps": (14, 1, None), "chirp": (15, 1, None), "gain_step": (16, 1, None),
}  # fmt: skip


def fields(drawn: object, wanted: dict[str, Any]) -> dict[str, Any]:
    return {name: getattr(drawn, name) for name in wanted}


def close(wanted: dict[str, Any]) -> dict[str, Any]:
    return {name: pytest.approx(value, rel=1e-9, abs=1e-12) for name, value in wanted.items()}


@pytest.mark.parametrize("name", DRAWS)
def test_an_effect_is_drawn_between_its_ends(name: str) -> None:
    lower, upper = DRAWS[name]
    for rng, wanted in ((LOW, lower), (HIGH, lower | upper)):
        drawn = effects()[name].draw(rng, SETTING)
        assert fields(drawn, wanted) == close(wanted)


def test_a_saturation_may_clip_above_alone() -> None:
    # 14.5 % of 100 V inside the lower end.
    wanted = {"low_V": -35.5, "high_V": 160.0}
    assert fields(effects()["saturation"].draw(MIDDLE, SETTING), wanted) == close(wanted)


def test_numbers_of_effects_never_change_and_order_them() -> None:
    """Ranks seed the jumps, numbers of the bank seed its scenarios."""
    known = {name: (kind.rank, kind.most, kind.bank_index) for name, kind in effects().items()}
    assert known == {name: (r, m, None if name == "memory" else b) for name, (r, m, b) in NUMBERS.items()}
    # Of the paper's sensor: 0.5 nm rms, white.
    assert effects()["noise"]() == effects()["noise"](0.0005, 0.0)  # type: ignore[call-arg]
    unknown = {"bandwidth", "stick_slip", "noise", "jumps", "chirp", "gain_step"}
    assert {name for name, kind in effects().items() if not kind.in_vocabulary} == unknown
    assert {name for name, kind in effects().items() if kind.needs_channel} == {"coupling"}
    steps_s = {name: kind.longest_substep_s for name, kind in effects().items() if kind.longest_substep_s < 1.0}
    assert steps_s == {"bandwidth": 1e-4, "creep": 1e-4, "slew": 2e-5, "stick_slip": 1e-4}
    assert {name for name, kind in effects().items() if kind.bends_amplifier} == {"bandwidth", "slew"}
    stage = Stage().with_effects(**{name: effects()[name].draw(LOW, SETTING) for name in reversed(DRAWS)})
    assert list(stage.active) == [name for name in NUMBERS if name in DRAWS or name == "memory"]
    for name, most in (("resonance", 4), ("periodic", 16)):
        mode = effects()[name].draw(LOW, SETTING)
        assert len(Stage().with_effects(**{name: [mode] * most}).others) == most
        with pytest.raises(StageError, match=f"at most {most}"):
            Stage().with_effects(**{name: [mode] * (most + 1)})


def test_errors_of_parameters_are_stated_in_the_measure_of_their_tolerance() -> None:
    stated = {
        key: (tolerance.limit, tolerance.kind) if tolerance else None
        for kind in effects().values()
        for key, tolerance in kind.tolerances.items()
    }
    assert stated == {
        "creep.per_decade": (0.15, "relative"), "creep.from_s": None, "delay.delay_samples": (0.2, "absolute"),
        "periodic.f_Hz": (0.1, "absolute"), "periodic.amplitude_um": (None, "relative"),
        "resonance.f_Hz": (0.02, "relative"), "resonance.zeta": (0.3, "relative"), "resonance.share": None,
        "saturation.low_V": (0.01, "input range"), "saturation.high_V": (0.01, "input range"),
        "slew.rate_V_per_s": (0.05, "relative"),
    }  # fmt: skip
    errors = [Tolerance(1.0, kind).error(4.5, 5.0, 100.0) for kind in ("relative", "absolute", "input range")]
    assert errors == pytest.approx([-0.1, -0.5, -0.005])
    true = {name: effects()[name].draw(LOW, SETTING).true_parameters() for name in DRAWS}
    wanted = {
        "aging": {"aging.per_s": -0.04 / SPAN_S}, "coupling": {"coupling.axis2_V_um_per_unit": -0.2 / 30},
        "creep": {"creep.per_decade": 0.016, "creep.from_s": SPAN_S / 400}, "delay": {"delay.delay_samples": 0.5},
        "drift": {"drift.ramp_um_per_s": -0.4 / SPAN_S},
        "periodic": {"periodic.f_Hz": 40 / SPAN_S, "periodic.amplitude_um": 0.2},
        "resonance": {"resonance.f_Hz": 10.0, "resonance.zeta": 0.01, "resonance.share": 0.1},
        "saturation": {"saturation.low_V": -60.0, "saturation.high_V": 46.0}, "slew": {"slew.rate_V_per_s": 75.25e3},
    }  # fmt: skip
    assert {name: found for name, found in true.items() if found} == {
        name: close(part) for name, part in wanted.items()
    }
    assert effects()["saturation"].draw(HIGH, SETTING).passes_V(-40.0, 20.0) == (-25.0, pytest.approx(20.0))
    assert effects()["saturation"].draw(HIGH, SETTING).passes_V(-10.0, 30.0) == (-10.0, pytest.approx(25.0))


FAMILY_DRAWS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "relays": (
        {"bias_shape": (1.0, 1.0), "coercive_V": 6.0, "coercive_shape": 0.8, "pinched": 0.0, "seed": 0},
        {"bias_shape": (3.0, 3.0), "coercive_V": 25.0, "coercive_shape": 2.0, "pinched": 0.7, "seed": 2**31 - 1},
    ),
    "bouc-wen": (
        {"reach_V": 8.0, "balance": 0.5, "exponent": 1.1}, {"reach_V": 40.0, "balance": 0.85, "exponent": 2.0},
    ),
    "jiles-atherton": (
        {"centre_V": 45.0, "shape_V": 10.0, "pinning_V": 10.0, "coupling_V": 0.5, "reversible": 0.05},
        {"centre_V": 75.0, "shape_V": 30.0, "pinning_V": 35.0, "coupling_V": 12.25, "reversible": 0.4},
    ),
    "thermal": (
        {"bias_shape": (1.0, 1.0), "coercive_V": 15.0, "coercive_spread": 0.3, "barrier": 45.0, "barrier_spread": 0.2,
         "attempt_per_s": 1e6, "hold_s": 4e-3, "substep_s": 5e-4, "seed": 0},
        {"bias_shape": (3.0, 3.0), "coercive_V": 40.0, "coercive_spread": 0.7, "barrier": 150.0, "barrier_spread": 0.5,
         "attempt_per_s": 1e9, "hold_s": 4e-3, "substep_s": 5e-4},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FAMILY_DRAWS)
def test_a_family_is_drawn_between_its_ends(name: str) -> None:
    for rng, wanted in zip((LOW, HIGH), FAMILY_DRAWS[name], strict=True):
        drawn = FAMILIES[name].drawn(rng, 10.0, 110.0, 1e-3)
        assert fields(drawn, {"low_V": 0, "high_V": 0, "height_um": 0}) == {"low_V": 10, "high_V": 110, "height_um": 1}
        assert fields(drawn, wanted) == close(wanted)


def test_a_mesh_has_a_heavy_tail_and_one_to_three_other_groups() -> None:
    few, many = (FAMILIES["preisach"].drawn(rng, 10.0, 110.0, 1e-3).groups for rng in (LOW, HIGH))  # type: ignore[attr-defined]
    assert few[0] == pytest.approx((0.4 / (15.0 * 5.0), 30.0, 15.0, -0.6, 5.0, 0.0))
    assert many[-1] == pytest.approx((1.0 / (50.0 * 25.0), 90.0, 50.0, 0.6, 25.0, 0.8))
    assert ([group[5] for group in few], [group[5] for group in many]) == ([0.0, 0.3], [0.0, 0.8, 0.8, 0.8])


def test_hysterons_have_the_medians_and_spreads_of_their_docstring() -> None:
    made = ThermalHysterons(10.0, 110.0, height_um=2.0, coercive_V=20.0, coercive_spread=0.3, barrier=60.0,
                            barrier_spread=0.2, bias_shape=(1.0, 1.0))  # fmt: skip
    scalars, arrays = made.equation()
    assert scalars == {"hysterons": 1024, "attempt_per_s": 1e9, "dwell_s": 1e-3}
    for name, median, spread in (("per_coercive_V", 1 / 20.0, 0.3), ("barrier", 60.0, 0.2)):
        logs = np.log(arrays[name])
        assert np.exp(np.median(logs)) == pytest.approx(median, rel=0.03)
        # The logistic tails of 1024 evenly scattered points: within 5 %.
        assert logs.std() == pytest.approx(spread, rel=0.05)
    # Uniform with exponents of 1, a tenth of the range beyond both ends.
    assert arrays["bias_V"].min() == pytest.approx(0.0, abs=1.0)
    assert arrays["bias_V"].max() == pytest.approx(120.0, abs=1.0)
    assert arrays["part_um"].sum() == pytest.approx(2.0, rel=0.05)
    assert arrays["part_um"].max() / arrays["part_um"].min() == pytest.approx(1.7 / 0.3, rel=0.02)
    assert (ThermalHysterons(0.0, 1.0).barrier_spread, ThermalHysterons(0.0, 1.0).coercive_spread) == (0.4, 0.5)
    assert not arrays["up"].any()


def test_a_bouc_wen_rises_by_its_slope_less_its_rate_after_a_turn() -> None:
    made = RisingBoucWen(0.0, 100.0, height_um=2.0, reach_V=20.0, balance=0.6, exponent=1.5)
    assert made.steepest_fall_um_per_V == pytest.approx(0.12)
    assert RisingBoucWen(0.0, 100.0, balance=0.4, reach_V=20.0).steepest_fall_um_per_V == pytest.approx(0.05)
    scalars, _ = made.equation()
    assert scalars["bw_a"] == pytest.approx(0.1)
    assert scalars["bw_beta"] == pytest.approx(0.6 * 0.1 / 2.0**1.5)
    assert scalars["bw_gamma"] == pytest.approx(0.4 * 0.1 / 2.0**1.5)
    assert (scalars["bw_n"], scalars["grid_low_V"]) == (1.5, -20.0)
    form = made.form(1.0, 1.0)
    assert (form.scalars["slope_um_per_V"], form.scalars["grid_n"]) == (0.0, 2)
    bare = around(made)
    assert (bare.dac_low_V, bare.dac_high_V, bare.history_V, bare.zero_V) == (-100.0, 200.0, (0.0, 100.0, 0.0), 0.0)


def test_scattered_points_fill_the_cube_more_evenly_than_chance() -> None:
    points = scattered(np.random.default_rng(1), 4096, 2)
    counts = np.histogram2d(*points.T, bins=16, range=[[0, 1], [0, 1]])[0]
    # Of chance 16 a cell with a spread of 4.
    assert counts.mean() == 16.0
    assert counts.std() < 3.0
    plain = scattered(cast(Any, Ends(0.5)), 3, 1)
    golden = (1 + math.sqrt(5)) / 2
    assert plain[:, 0] == pytest.approx([(0.5 + k / golden) % 1.0 for k in range(3)])


def test_effects_of_a_plant_are_drawn_between_their_ends() -> None:
    setting = _Setting(1e-3, (0.0, 100.0), stroke_um=10.0, lag_s=2e-3)
    record_s = IDENTIFY * 1e-3
    wanted: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
        "creep": (
            {"per_decade": 0.005, "tau_min_s": 0.01, "tau_max_s": math.sqrt(10) * record_s},
            {"per_decade": 0.03, "tau_min_s": math.sqrt(0.1), "tau_max_s": 10**2.5 * record_s},
        ),
        "resonance": ({"f_Hz": 50.0, "zeta": 0.01, "share": 0.1}, {"f_Hz": 100.0, "zeta": 0.1, "share": 0.7}),
        "delay": ({"samples": 0.3}, {"samples": 6.7}),
        "saturation": ({"low_V": -60.0, "high_V": 95.0}, {"low_V": 20.0, "high_V": 80.0}),
        "periodic": (
            {"f_Hz": 200 / record_s, "amplitude_um": 0.01, "phase_rad": 0.0},
            {"f_Hz": 100.0, "amplitude_um": 0.1, "phase_rad": 2 * math.pi},
        ),
    }
    assert set(DRAWN) == set(wanted)
    for name, ends in wanted.items():
        for rng, end in zip((LOW, HIGH), ends, strict=True):
            assert fields(DRAWN[name](rng, setting), end) == close(end), name


def test_a_plant_is_drawn_between_its_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    for place, rate_Hz, range_V, stroke_um, noise, lag in (
        (0.0, 500.0, (-18.0, 70.0), 3.0, 1e-4, 2.0),
        (1.0, 50e3, (10.0, 118.0), 50.0, 1 / 3000, 30.0),
    ):
        monkeypatch.setattr(np.random, "default_rng", lambda _, place=place: Ends(place))
        made = plant("bouc-wen", "creep", 0)
        assert (made.Ts_s, made.range_V, made.stroke_um) == (1 / rate_Hz, range_V, pytest.approx(stroke_um))
        assert made.noise_um == pytest.approx(noise * stroke_um)
        assert made.stage.lag_s == pytest.approx(lag / rate_Hz)
        assert (made.stage.history_V, made.stage.zero_V) == ((*range_V, range_V[0]), range_V[0])
        assert (made.stage.dac_low_V, made.stage.dac_high_V) == (-60.0, 160.0)
        assert (made.stage.dac_bits, made.stage.adc_bits, made.stage.sensor_step_um) == (0, 0, 0.0)
        assert made.effects == ("memory", "creep")


def test_hysteresis_of_the_bank_is_drawn_between_its_ends() -> None:
    low, high = Density(25.0, 45.0, 5.0, 65.0), Density(60.0, 75.0, 35.0, 65.0)
    for kind, made in ((0.549, Preisach(low, 0.25)), (0.55, Relays(low, 0.25, count=400))):
        assert draw_hysteresis(LOW, 10.0, kind) == made
    assert draw_hysteresis(HIGH, 10.0, 0.749) == Relays(high, 0.5, count=400)
    assert draw_hysteresis(LOW, 10.0, 0.75) == BoucWen(0.4, 10.0, 0.5)
    assert draw_hysteresis(HIGH, 100.0, 0.75) == BoucWen(9.0, 23.0, 0.8)
    for rng, bend in ((LOW, 0.0), (HIGH, 1.5)):
        curve = draw_curve(rng, 10.0)
        v = (curve.low_V + curve.step_V * np.arange(201)) / 120.0
        np.testing.assert_allclose(curve.w_um, 10.0 * v + bend * v * (1 - v), atol=1e-12)
        assert (v[0], v[-1]) == (-0.5, 1.5)
