"""What the virtual stages are drawn from: both ends of every interval by hand, and the numbers that never change."""

import math
from typing import Any, cast

import numpy as np
import pytest

from fixtures.ends import Ends
from hysgen_lab.stage import Stage, effects
from hysgen_lab.stage.effects import Setting, StageError, Tolerance
from hysgen_lab.stage.effects.memory import BoucWen, Curve, Density, Preisach, Relays
from hysgen_lab.stage.families import FAMILIES
from hysgen_lab.stage.families.laws import JilesAtherton, RisingBoucWen, ThermalHysterons, around

LOW, HIGH = cast(Any, Ends(0.0)), cast(Any, Ends(1.0))

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
    "jumps": (14, 1, None), "chirp": (15, 1, None), "gain_step": (16, 1, None), "softening": (17, 1, None),
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
    lines = ((40.0, 0.2), (70.0, 0.1))
    assert Stage().with_effects(periodic=lines) == Stage().with_effects(periodic=list(lines))
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


LIMITS: dict[str, tuple[list[tuple[Any, ...]], list[tuple[Any, ...]]]] = {
    "aging": ([(0.1, 1e-9)], [(0.1, 0.0)]),
    "bandwidth": ([(1e-9,), (1.0, 1), (1.0, 2, 1e-9)], [(0.0,), (1.0, 0), (1.0, 3), (1.0, 2, 0.0)]),
    "chirp": ([(1.0, 2.0, 1e-9, 1.0)], [(1.0, 2.0, 0.0, 1.0)]),
    "coupling": ([({"a": 0.0},)], [({},), ({"a": math.inf},)]),
    "creep": ([(0.1, 1e-9, 2e-9)], [(0.1, 0.0, 1.0), (0.1, 1.0, 1.0), (0.1, 0.1, 1.0, math.nan)]),
    "delay": ([(0.0, 0.0)], [(-1e-9, 0.0), (0.0, -1e-9)]),
    "drift": ([(-1.0, 0.0)], [(0.0, -1e-9)]),
    "gain_step": ([(-0.999, 0.0)], [(-1.0, 0.0)]),
    "jumps": ([(0.0, 1.0), (0.999, 1.0)], [(-1e-9, 1.0), (1.0, 1.0)]),
    "noise": ([(0.0, 0.0)], [(-1e-9, 0.0), (0.0, -1e-9)]),
    "outliers": ([(0.0, 1.0), (0.999, 1.0)], [(-1e-9, 1.0), (1.0, 1.0)]),
    "periodic": ([(1e-9, 1.0)], [(0.0, 1.0)]),
    "resonance": ([(1e-9, 1e-9), (1.0, 0.999)], [(0.0, 0.1), (1.0, 0.0), (1.0, 1.0)]),
    "saturation": ([(1.0, 1.001)], [(1.0, 1.0)]),
    "slew": ([(1e-9,)], [(0.0,)]),
    "stick_slip": ([(1e-9, 0.0, 0.0), (1.0, 0.999, 0.999)], [(0.0,), *((1.0, *at) for at in (
        (1.0, 0.5), (-1e-9, 0.5), (0.5, 1.0), (0.5, -1e-9)))]),
}  # fmt: skip
OTHER_LIMITS: list[tuple[Any, list[tuple[Any, ...]], list[tuple[Any, ...]]]] = [
    (Density, [(5.001, 0.0, 0.0, 5.001)], [(5.0,), (9.0, 0.0, 0.0, 5.0)]),
    (Preisach, [(Density(), 0.001), (Density(), 0.999)], [(Density(), 0.0), (Density(), 1.0)]),
    (Relays, [(Density(), 0.001, 2), (Density(), 0.999, 2000)],
     [(Density(), 0.0), (Density(), 1.0), (Density(), 0.3, 1), (Density(), 0.3, 2001)]),
    (BoucWen, [(1e-9, 1e-9, 0.5, 1.0), (1.0, 1.0, 1.0)],
     [(0.0,), (1.0, 0.0), (1.0, 1.0, 0.499), (1.0, 1.0, 1.001), (1.0, 1.0, 0.6, 0.999)]),
    (Curve, [(0.0, 1e-9, (0.0, 1.0))], [(0.0, 0.0, (0.0, 1.0)), (0.0, 1.0, (0.0,))]),
    # 0.2 / (3 25) + 2 0.8 / 20 = 0.08267 a volt of coupling.
    (lambda at: JilesAtherton(0.0, 1.0, coupling_V=at), [(12.096,)], [(12.097,)]),
    (Stage, [(1e-9, 1e-9, 0.0)],
     [(0.0,), (1.0, 0.0), (1.0, 1.0, -1e-9), (1.0, 1.0, math.inf), (1.0, 1.0, 0.0, 1.0, 1.0)]),
    (lambda low, high: Stage(adc_low_um=low, adc_high_um=high), [(1.0, 1.001)], [(1.0, 1.0)]),
    (lambda at: Stage(zero_V=at), [(-1e9,)], [(math.nan,)]),
]  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "accepted", "refused"), [*((effects()[name], *ends) for name, ends in LIMITS.items()), *OTHER_LIMITS]
)
def test_parts_of_a_stage_are_accepted_up_to_their_limits(kind: Any, accepted: list[Any], refused: list[Any]) -> None:
    for values in accepted:
        kind(*values)
    for values in refused:
        with pytest.raises(StageError):
            kind(*values)


def test_the_laboratory_has_the_modest_imperfections_of_a_real_stage() -> None:
    nominal = Stage.nominal()
    assert (nominal.stroke_um, nominal.full_V, nominal.lag_s, nominal.zero_V) == (10.0, 120.0, 1e-3, 0.0)
    assert (nominal.dac_low_V, nominal.dac_high_V, nominal.dac_bits, nominal.adc_bits) == (-20.0, 120.0, 20, 16)
    assert (nominal.adc_low_um, nominal.adc_high_um, nominal.sensor_step_um) == (-3.276, 13.108, 0.0005)
    assert nominal.history_V == (-20.0, 120.0, 0.0)
    whole = {effect.name: effect for effect in Stage.laboratory().others}
    made = {
        "bandwidth": (10e3,), "slew": (100e3,), "creep": (0.012,), "drift": (0.0, 0.0005),
        "resonance": (780.0, 0.03, 0.25), "periodic": (50.0, 0.002, 0.6),
    }  # fmt: skip
    assert whole == {name: cast(Any, effects()[name])(*values) for name, values in made.items()}
    # The longest loop that a Bouc-Wen element can open is five times its reach.
    assert BoucWen(reach_V=20.0).form(10.0, 100.0).scalars["slope_um_per_V"] == pytest.approx(0.115)
    with pytest.raises(StageError, match="the loop never opens"):
        BoucWen(reach_V=20.01).form(10.0, 100.0)
