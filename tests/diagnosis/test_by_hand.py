"""Numbers, limits and words of causes, score and answer on made-up inputs, each against a value made by hand."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fixtures.linear_stage import AXIS2_V, COMMAND_V, LAG, LINEAR, SAMPLES, SPAN_S, T_S, TS_S, scene
from hysgen.diagnosis import identifiability, slow_evidence
from hysgen.diagnosis.answer import NamedCause, Price
from hysgen.diagnosis.causes import Estimate, Residual, Signature, causes, in_ladder_order
from hysgen.diagnosis.causes.aging import AgingPart, GainChange
from hysgen.diagnosis.causes.base import Known
from hysgen.diagnosis.causes.coupling import CouplingPart
from hysgen.diagnosis.causes.creep import CreepPart, creep_block
from hysgen.diagnosis.causes.delay import DelayPart
from hysgen.diagnosis.causes.drift import DriftPart, Trend, trend_course
from hysgen.diagnosis.causes.memory import swings
from hysgen.diagnosis.causes.periodic import PeriodicPart
from hysgen.diagnosis.causes.relaxation import RelaxationPart
from hysgen.diagnosis.causes.resonance import ResonancePart
from hysgen.diagnosis.causes.saturation import SaturationPart
from hysgen.diagnosis.causes.slew import SlewPart
from hysgen.diagnosis.evaluation import Study, confidence_text, share_text
from hysgen.diagnosis.extension import Extension, corrected
from hysgen.diagnosis.ladder import (
    BLOCKS,
    MOST_IN_TURN,
    Gain,
    add_online_parts,
    blockwise_confidence,
    combined_confidence,
    gain,
    joint_shares,
    left_out,
)
from hysgen.diagnosis.prepare import PROBE_LAGS
from hysgen.diagnosis.probe import Chain, Fit, Mode, Scene, Trace, linear_fit, standard_errors
from hysgen.diagnosis.probe.chain import respond
from hysgen.diagnosis.score import RESTING, least_growth, resting_noise
from hysgen.diagnosis.slow_evidence import penalty
from hysgen.fitting.operator import PathSize
from hysgen.model.disturbances.coupling import Coupling
from hysgen.model.file import load_model
from hysgen.model.path.creep import Creep
from hysgen.model.path.delay import Delay
from hysgen.model.path.modes import Modes
from hysgen.model.path.saturation import Saturation
from hysgen.model.path.slew import Slew
from hysgen.record import Record
from hysgen.record.series import dispersion

WHITE = np.random.default_rng(11).normal(size=20_000)


def fitted(chain: Chain, more_um: Any = 0.0, **aux: np.ndarray) -> Residual:
    """The fit of a chain to the stage that it is, with a displacement beside it."""
    seen = scene(chain if not chain.get(AgingPart) else LAG, more_um, aux)
    return Residual(seen, linear_fit(seen, chain))


def signature(name: str, residual: Residual) -> Signature:
    return causes()[name].signature(residual, linear_fit(residual.scene, LAG))


def estimates(found: Signature, **expected: float) -> None:
    """Values of the parameters within four standard errors, and none beside them."""
    assert set(found.parameters) == set(expected)
    for name, value in expected.items():
        estimate = found.parameters[name]
        assert abs(estimate.value - value) <= 4.0 * estimate.standard_error + 1e-12, name


# Causes


def test_a_delay_is_said_in_samples_extended_and_proposed_as_shares_of_the_lag() -> None:
    residual = fitted(LAG.having(DelayPart(1.7)))
    found = signature("delay", residual)
    late = found.parameters["delay_samples"]
    assert (late.value, found.z) == (1.7, 1.7 / late.standard_error)
    assert found.text == f"phase grows with frequency at constant gain: 1.70 +- {late.standard_error:.2f} samples late"
    extension = causes()["delay"].extension(residual)
    assert (extension.block, extension.lag_s) == (Delay(1.7), 4e-3)
    assert causes()["delay"].proposals(residual) == []
    starts = causes()["delay"].proposals(fitted(LAG))
    # The lag of 4 samples is divided between delay and lag; half a sample comes beside it.
    found_starts = [(chain.delay, 1e3 * chain.lag_s) for chain in starts]
    np.testing.assert_allclose(found_starts, [(0.4, 3.6), (1.6, 2.4), (3.2, 0.8), (0.5, 4.0)])
    short = causes()["delay"].proposals(fitted(dataclasses.replace(LAG, lag_s=0.4e-3)))
    assert [round(chain.delay, 9) for chain in short] == [0.16, 0.32, 0.5], "0.04 samples are too few"
    effect = causes()["delay"].effect(fitted(LAG))
    assert effect is not None
    assert (effect.unit, effect.most) == ("samples", 200.0)


def test_a_slow_amplifier_is_said_with_its_rate_and_the_samples_that_it_holds_back() -> None:
    residual = fitted(LAG.having(SlewPart(800.0)))
    found = signature("slew", residual)
    error = 800.0 * standard_errors(residual.scene, residual.fit).coordinates["slew.rate_V_per_s"]
    assert found.parameters == {"rate_V_per_s": Estimate(800.0, error)}
    assert found.z == pytest.approx(800.0 / found.parameters["rate_V_per_s"].standard_error)
    free, limited = COMMAND_V, residual.fit.chain.amplified(COMMAND_V, TS_S)
    held = int(np.sum(np.abs(free - limited)[50:] > 0.1))
    assert f"faster than 800 V/s +- {found.parameters['rate_V_per_s'].standard_error:.1g}, at any level" in found.text
    assert f"({held} samples held back)" in found.text
    extension = causes()["slew"].extension(residual)
    assert (extension.block, extension.lag_s) == (Slew(800.0, 800.0), 4e-3)
    effect = causes()["slew"].effect(residual)
    assert effect is not None
    assert (effect.unit, effect.limit, effect.column) == ("V/s", True, None)
    assert effect.least == pytest.approx(np.sort(np.abs(np.diff(COMMAND_V)))[-10] / TS_S)
    rates = np.abs(np.diff(COMMAND_V)) / TS_S
    starts = causes()["slew"].proposals(fitted(LAG))
    levels = sorted({chain.of(SlewPart).rate_V_per_s for chain in starts})
    assert levels[0] == pytest.approx(np.quantile(rates[rates > 1e-6 * rates.max()], 0.3))
    assert levels[-1] == pytest.approx(np.quantile(rates[rates > 1e-6 * rates.max()], 0.99))
    assert len(starts) == 3 * len(levels)
    assert {round(1e3 * chain.lag_s, 9) for chain in starts} == {4.0, 1.0, 0.2}


def test_levels_of_a_saturation_are_proposed_from_the_middle_and_extended_beyond_the_range() -> None:
    saturation, residual = causes()["saturation"], fitted(LAG)
    parts = [chain.of(SaturationPart) for chain in saturation.proposals(residual)]
    high = [part.high_V for part in parts if part.low_V is None]
    low = [part.low_V for part in parts if part.high_V is None]
    assert high == pytest.approx([65.0, 75.0, 82.5, 87.5, 91.0, 94.0, 96.5, 98.5])
    assert low == pytest.approx([100.0 - level for level in high])
    both = [(part.low_V, part.high_V) for part in parts if None not in (part.low_V, part.high_V)]
    assert len(both) == 49
    assert (both[0], both[-1]) == (pytest.approx((25.0, 75.0)), pytest.approx((4.0, 96.0)))
    clipped = fitted(LAG.having(SaturationPart(high_V=80.0)))
    assert all(chain.of(SaturationPart).high_V == 80.0 for chain in saturation.proposals(clipped))
    extension = saturation.extension(clipped)
    assert (extension.block, extension.lag_s) == (Saturation(-100.0, 80.0), 4e-3)
    lower = saturation.extension(fitted(LAG.having(SaturationPart(low_V=20.0))))
    assert lower.block == Saturation(20.0, 200.0)
    found = signature("saturation", clipped)
    assert found.text.startswith("beyond 80 V the slope is 0.0")
    errors = standard_errors(clipped.scene, clipped.fit).coordinates
    assert found.parameters == {"high_V": Estimate(80.0, errors["saturation.high_V"])}
    assert found.z == pytest.approx(10.0, abs=0.3)
    effect = saturation.effect(residual)
    assert effect is not None
    assert (effect.unit, effect.limit, effect.least) == ("V", True, np.sort(COMMAND_V[50:])[-5])
    simpler = [chain.of(SaturationPart) for chain in saturation.simpler_forms(LAG.having(SaturationPart(20.0, 80.0)))]
    assert simpler == [SaturationPart(high_V=80.0), SaturationPart(low_V=20.0)]
    assert saturation.simpler_forms(LAG.having(SaturationPart(high_V=80.0))) == []


def test_a_mode_is_said_with_its_numbers_and_modes_are_extended_in_rising_order() -> None:
    modes = (Mode(90.0, 0.05, 0.3), Mode(40.0, 0.03, -0.2))
    residual = fitted(LAG.having(ResonancePart(modes)))
    found = signature("resonance", residual)
    estimates(found, f_Hz=90.0, zeta=0.05, share=0.3, f_2_Hz=40.0, zeta_2=0.03, share_2=-0.2)
    words = "rings at 90 Hz with damping ratio 0.05, share 0.3; rings at 40 Hz with damping ratio 0.03, share -0.2"
    assert found.text == words
    errors = [found.parameters[name].standard_error for name in ("share", "share_2")]
    assert found.z == pytest.approx(min(0.3 / errors[0], 0.2 / errors[1]))
    block = causes()["resonance"].extension(residual).block
    assert block == Modes((40.0, 90.0), (0.03, 0.05), (-0.2, 0.3), 4e-3)
    fewer = [chain.modes for chain in causes()["resonance"].without_one_part(residual.fit.chain)]
    assert fewer == [modes[1:], modes[:1]]
    assert causes()["resonance"].without_one_part(LAG.having(ResonancePart(modes[:1]))) == [LAG]
    three = fitted(LAG.having(ResonancePart((*modes, Mode(200.0, 0.1, 0.1)))))
    assert [chain.of(ResonancePart).modes for chain in causes()["resonance"].proposals(three)] == [()]  # a structure
    first, *_ = causes()["resonance"].proposals(fitted(LAG, 0.02 * respond(COMMAND_V, _ringing(120.0), TS_S)))
    assert first.modes[0].f_Hz == pytest.approx(120.0, rel=0.05)


def _ringing(f_Hz: float) -> Chain:
    return LAG.having(ResonancePart((Mode(f_Hz, 0.03, 0.4),)))


def test_lines_are_said_with_amplitude_and_phase_and_proposed_where_they_stand() -> None:
    wave = 0.010 * np.sin(2 * np.pi * 50.0 * T_S) + 0.004 * np.cos(2 * np.pi * 120.0 * T_S)
    seen = scene(LAG, wave)
    proposed = causes()["periodic"].proposals(Residual(seen, linear_fit(seen, LAG)))
    lines = [chain.of(PeriodicPart).lines_Hz[-1] for chain in proposed]
    assert lines[:2] == pytest.approx([50.0, 120.0], abs=0.02)
    residual = Residual(seen, linear_fit(seen, LAG.having(PeriodicPart((120.0, 50.0)))))
    found = signature("periodic", residual)
    assert found.parameters["amplitude_um"].value == pytest.approx(0.004, rel=0.02)
    assert found.parameters["amplitude_2_um"].value == pytest.approx(0.010, rel=0.02)
    assert (found.parameters["f_Hz"].value, found.parameters["f_2_Hz"].value) == (120.0, 50.0)
    ratio = (0.004 / found.parameters["amplitude_um"].standard_error) ** 2
    assert found.z == pytest.approx(math.sqrt(ratio), rel=0.05), "the weaker line"
    amplitude_um = found.parameters["amplitude_um"].value
    assert found.text.startswith(f"line at 120 Hz, {amplitude_um:.3g} um, ")
    assert found.text.endswith("phase kept throughout")
    assert causes()["periodic"].extension(residual).term.f_Hz == (50.0, 120.0)  # type: ignore[union-attr]
    part = LAG.having(PeriodicPart((60.0, 70.0, 80.0)))
    fewer = [chain.of(PeriodicPart).lines_Hz for chain in causes()["periodic"].without_one_part(part)]
    assert fewer == [(70.0, 80.0), (60.0, 80.0), (60.0, 70.0)]
    four = Residual(seen, linear_fit(seen, part.having(PeriodicPart((60.0, 70.0, 80.0, 90.0)))))
    assert causes()["periodic"].proposals(four) == []


def test_channels_are_said_with_their_gains_and_proposed_if_they_move() -> None:
    second = np.sin(np.arange(SAMPLES) / 7.0)
    more = 0.001 * respond(AXIS2_V, LAG, TS_S) - 0.02 * respond(second, LAG, TS_S)
    seen = scene(LAG, more, {"x": AXIS2_V, "y": second, "still": np.full(SAMPLES, 3.0)})
    proposed = causes()["coupling"].proposals(Residual(seen, linear_fit(seen, LAG)))
    parts = [chain.of(CouplingPart) for chain in proposed]
    assert parts == [CouplingPart(("x",)), CouplingPart(("y",)), CouplingPart(("x", "y"), 32)]
    residual = Residual(seen, linear_fit(seen, LAG.having(CouplingPart(("x", "y")))))
    found = signature("coupling", residual)
    estimates(found, x_um_per_unit=0.001, y_um_per_unit=-0.02)
    sizes = [abs(one.value) / one.standard_error for one in found.parameters.values()]
    assert found.z == pytest.approx(min(sizes))
    assert found.text.startswith("the error follows x 0.00")
    assert ", y -0.0" in found.text
    assert "samples" not in found.text
    taps = signature("coupling", Residual(seen, linear_fit(seen, LAG.having(CouplingPart(("x",), 4)))))
    assert taps.text.endswith("um per unit, over 4 samples")
    term = causes()["coupling"].extension(residual).term
    assert term is not None
    assert term.channels == ("x", "y")
    assert isinstance(term, Coupling)
    assert (term.low, term.high) == ((AXIS2_V.min(), second.min()), (AXIS2_V.max(), second.max()))
    effect = causes()["coupling"].effect(residual)
    assert effect is not None
    assert effect.unit == "um for a standard deviation of x"
    assert effect.column is not None
    assert (effect.column.mean(), effect.column.std()) == (pytest.approx(0.0, abs=1e-9), pytest.approx(1.0))
    still = scene(LAG, 0.0, {"still": np.full(SAMPLES, 3.0)})
    assert causes()["coupling"].effect(Residual(still, linear_fit(still, LAG))) is None
    less = causes()["coupling"].without_one_part(LAG.having(CouplingPart(("x", "y"), 8)))
    assert [chain.of(CouplingPart) for chain in less] == [
        CouplingPart(("y",), 8),
        CouplingPart(("x",), 8),
        CouplingPart(("x", "y"), 1),
    ]


def test_a_gain_that_grows_is_said_per_second_and_over_the_record_and_taken_out_about_its_zero() -> None:
    residual = fitted(LAG.having(AgingPart(0.003)), 0.1 * 0.003 * T_S * respond(COMMAND_V, LAG, TS_S))
    found = signature("aging", residual)
    assert found.parameters["fraction"].value == pytest.approx(SPAN_S * found.parameters["per_s"].value)
    assert found.parameters["per_s"].value == pytest.approx(0.003, rel=0.1)
    errors = [found.parameters[name].standard_error for name in ("fraction", "per_s")]
    assert errors[0] == pytest.approx(SPAN_S * errors[1])
    assert found.z == pytest.approx(found.parameters["per_s"].value / errors[1])
    assert found.text.startswith(f"gain changes by {100 * found.parameters['fraction'].value:+.2f} % +- ")
    extension = causes()["aging"].extension(residual)
    assert extension.forgetting_s == pytest.approx(0.35 * SPAN_S)
    assert extension.learns
    change = GainChange(0.5, 2.0)
    np.testing.assert_allclose(change.removed(np.array([4.0, 5.0, 2.0]), np.array([0.0, 1.0, 9.0])), [4.0, 4.0, 2.0])
    held = GainChange(0.5, 2.0, until_s=1.0)  # behind the identification part, as it was last
    np.testing.assert_allclose(held.removed(np.array([4.0, 5.0, 5.0]), np.array([0.0, 1.0, 9.0])), [4.0, 4.0, 4.0])
    starts = [chain.of(AgingPart).per_s * SPAN_S for chain in causes()["aging"].proposals(fitted(LAG))]
    assert starts[1:] == pytest.approx([0.003, 0.03, -0.003, -0.03])


def test_a_drift_is_a_ramp_or_slows_down_by_the_decade() -> None:
    t_s = np.array([0.0, 4.5, 49.5])
    assert trend_course(t_s, None).tolist() == [0.0, 4.5, 49.5]
    np.testing.assert_allclose(trend_course(t_s, 0.5), [0.0, 1.0, 2.0])
    np.testing.assert_allclose(Trend(0.5, 0.5).removed(np.ones(3), t_s), [1.0, 0.5, 0.0])
    np.testing.assert_allclose(Trend(0.5).removed(np.ones(3), t_s), [1.0, -1.25, -23.75])
    segment = Record.from_arrays(np.arange(400.0) % 70, 2.0 + np.arange(400.0) % 60, 0.5).segments[0]
    level = corrected(segment, [Trend(0.1), GainChange(0.5, 1.0)], 0.5)
    expected = 1.0 + (segment.y_um - 0.05 * np.arange(400.0) - 1.0) / (1.0 + 0.25 * np.arange(400.0))
    np.testing.assert_allclose(level.y_um, expected)
    np.testing.assert_array_equal(level.u_V, segment.u_V)
    model = load_model("appendix_a")
    span_um = model.grid.y_max_um - model.grid.y_min_um
    for span_s, tau_s in ((10.0, 0.2), (0.01, 100 * model.Ts_s)):
        term = Trend(0.5).online_term(model, span_s)
        assert (term.tau_s, term.limit_um) == (pytest.approx(tau_s), pytest.approx(0.05 * span_um))
    residual = fitted(LAG.having(DriftPart()), 0.05 * T_S / SPAN_S)
    found = signature("drift", residual)
    assert found.parameters["ramp_um_per_s"].value == pytest.approx(0.05 / SPAN_S, rel=0.05)
    ramp = found.parameters["ramp_um_per_s"]
    assert found.z == pytest.approx(ramp.value / ramp.standard_error)
    assert (
        f"{1e3 * ramp.value:.3g} nm per second +- {1e3 * ramp.standard_error:.1g} whatever the input does" in found.text
    )
    assert "(1.0" in found.text
    drift = causes()["drift"]
    slope = drift.extension(residual).correction
    assert isinstance(slope, Trend)
    assert (slope.size_um, slope.since_s) == (pytest.approx(ramp.value), None)
    slowing = fitted(LAG.having(DriftPart(0.2)), 0.03 * trend_course(T_S, 0.2))
    decade = signature("drift", slowing).parameters["um_per_decade"]
    assert decade.value == pytest.approx(0.03, rel=0.02)
    assert decade.standard_error < 0.002
    assert "slowing down like the creep of a move 0.2 s before the record" in signature("drift", slowing).text
    assert drift.simpler_forms(LAG.having(DriftPart(0.1))) == [LAG.having(DriftPart())]
    assert drift.simpler_forms(LAG.having(DriftPart())) == []
    shares = [chain.of(DriftPart).since_s for chain in drift.proposals(fitted(LAG))]
    assert shares == [None, *(pytest.approx(share * SPAN_S) for share in (0.01, 0.05, 0.25))]
    assert [chain.of(DriftPart).since_s for chain in drift.proposals(residual)] == shares[1:]
    creeping = fitted(LAG.having(CreepPart(0.02, 0.05)))
    assert [chain.of(DriftPart).since_s for chain in drift.proposals(creeping)] == [None]


def test_creep_has_a_state_in_each_decade_until_ten_lengths_of_the_record() -> None:
    block = creep_block(CreepPart(0.03, 0.1), 10.0)
    assert block.amount == 0.03
    np.testing.assert_allclose(block.tau_s, 0.1 * 10.0 ** (0.5 + np.arange(3)))
    assert len(creep_block(CreepPart(0.03, 0.1), 10.1).tau_s) == 4
    assert len(creep_block(CreepPart(0.03, 10.0), 0.1).tau_s) == 1
    extension = Extension(block=Creep(0.02, (0.1, 1.0, 10.0, 100.0)), lag_s=4e-3)
    forms = [form.block.tau_s for form in causes()["creep"].forms(extension)]  # type: ignore[union-attr]
    assert [len(tau_s) for tau_s in forms] == [2, 3, 4]
    assert forms[0] == (0.1, 1.0)
    starts = [chain.of(CreepPart) for chain in causes()["creep"].proposals(fitted(LAG))]
    # From three lags (12 ms) to a twentieth of the record (0.2 s), evenly in the logarithm.
    ends = 12e-3 * (0.2 / 12e-3) ** np.array([0.0, 0.33, 0.67, 1.0])
    np.testing.assert_allclose([part.from_s for part in starts], ends)
    assert all(1e-3 <= part.per_decade <= 1.0 for part in starts)
    residual = fitted(LAG.having(CreepPart(0.02, 0.05)))
    found = signature("creep", residual)
    estimate = found.parameters["per_decade"]
    assert abs(estimate.value - 0.02) < 0.002
    assert found.z == pytest.approx(estimate.value / estimate.standard_error)
    assert f"goes on by {100 * estimate.value:.2f} % +- {100 * estimate.standard_error:.2f} of it" in found.text


def test_a_swing_ends_at_a_turning_point_and_holds_the_plateau_behind_it() -> None:
    assert swings(np.zeros(5)).tolist() == [0] * 5
    triangle = np.concatenate([np.arange(10.0), np.arange(10.0, 0.0, -1.0), np.arange(10.0)])
    numbers = swings(triangle)
    assert np.bincount(numbers).tolist() == [1, 10, 10, 9]


def test_true_parameters_of_a_plant_make_its_extensions() -> None:
    parameters = {"delay.delay_samples": 2.5, "slew.rate_V_per_s": 700.0, "periodic.f_Hz": 50.0}
    parameters |= {"saturation.low_V": 5.0, "saturation.high_V": 90.0, "creep.per_decade": 0.01, "creep.from_s": 0.1}
    parameters |= {"resonance.f_Hz": 80.0, "resonance.zeta": 0.04, "resonance.share": 0.5}
    known = Known(parameters, 0.0, 100.0, 10.0, 3e-3, {"x": np.array([1.0, 4.0, -2.0])})
    blocks = {"delay": Delay(2.5), "slew": Slew(700.0, 700.0), "saturation": Saturation(5.0, 90.0)}
    blocks |= {"creep": creep_block(CreepPart(0.01, 0.1), 10.0), "resonance": Modes((80.0,), (0.04,), (0.5,), 3e-3)}
    for name, block in blocks.items():
        extension = causes()[name].true_extension(known)
        assert extension is not None
        assert (extension.block, extension.lag_s, extension.on_path) == (block, 3e-3, True)
    term = causes()["coupling"].true_extension(known)
    assert term is not None
    assert (term.term.low, term.term.high) == ((-2.0,), (4.0,))  # type: ignore[union-attr]
    memory = causes()["memory"].true_extension(known)
    assert memory is not None
    assert (memory.size, memory.lag_s) == (PathSize(), 3e-3)
    assert causes()["drift"].true_extension(known) is None


def test_only_a_hysteresis_of_which_every_sample_is_known_relaxes() -> None:
    relaxation, seen = causes()["relaxation"], scene(LAG)
    curve, plays = LAG, dataclasses.replace(LAG, memory=True)
    sparse = dataclasses.replace(seen, runs=(dataclasses.replace(seen.runs[0], stride=2),))

    def fit(chain: Chain) -> Fit:
        return Fit(chain, np.zeros(4), np.zeros(SAMPLES), 1.0)

    relaxed = plays.having(RelaxationPart(0.02))
    assert relaxation.admissible(seen, fit(relaxed))
    assert not relaxation.admissible(sparse, fit(relaxed))
    assert not relaxation.admissible(seen, fit(curve.having(RelaxationPart(0.02))))
    assert relaxation.admissible(sparse, fit(curve))
    starts = [chain.relaxation for chain in relaxation.proposals(Residual(seen, fit(plays)))]
    assert starts == [0.015, 0.04]
    for other, chain in ((sparse, plays), (seen, curve), (seen, relaxed)):
        assert relaxation.proposals(Residual(other, fit(chain))) == []
    assert relaxation.effect(Residual(seen, fit(curve))) is None
    extension = relaxation.extension(Residual(seen, fit(relaxed)))
    assert (extension.relaxation, extension.lag_s) == (0.02, 4e-3)
    forms = relaxation.forms(extension)
    assert [form.size.plays for form in forms[1:] if form.size is not None] == [12, forms[2].size.plays]  # type: ignore[union-attr]
    assert forms[0] is extension


def test_the_ladder_goes_from_the_sensor_over_the_path_to_slow_changes() -> None:
    order = [
        "outliers",
        "saturation",
        "slew",
        "delay",
        "memory",
        "relaxation",
        "creep",
        "resonance",
        "coupling",
        "periodic",
        "drift",
        "aging",
    ]
    assert [name for name in in_ladder_order(list(causes())[::-1]) if name in order] == order


# Score


def test_the_least_growth_of_an_error_is_that_of_the_score() -> None:
    """n ln g^2 = 2 ln 99 - 2 ln(odds) + ln n + 1 for a cause of one parameter."""
    growth = least_growth(100.0, 0.1)
    assert 100.0 * math.log(growth**2) == pytest.approx(2 * math.log(99) + 2 * math.log(10) + math.log(100) + 1)


def test_a_white_error_counts_each_sample_and_a_repeated_one_as_often_as_it_repeats() -> None:
    ones = np.ones(WHITE.size)
    assert 1.0 <= dispersion(WHITE, ones) < 2.5
    slow = np.repeat(WHITE[::50], 50)
    assert dispersion(slow, ones) == pytest.approx(50.0, rel=0.6)
    assert dispersion(np.zeros(4000), np.ones(4000)) == 1.0


@pytest.mark.parametrize("rests", [RESTING, RESTING + 1])
def test_noise_at_rest_needs_two_hundred_degrees_of_freedom(rests: int) -> None:
    """One plateau of `rests` samples beyond the lag has one degree of freedom less."""
    settle = math.ceil(PROBE_LAGS * LAG.lag_s / TS_S)
    u_V = np.concatenate([np.linspace(0.0, 50.0, 300), np.full(settle + rests, 60.0), np.linspace(59.0, 0.0, 300)])
    error = 0.01 * np.random.default_rng(2).normal(size=u_V.size)
    seen = Scene((Trace(u_V, error, {}),), TS_S, np.arange(u_V.size), LINEAR)
    noise = resting_noise(seen, Fit(LAG, np.zeros(1), error, 0.01))
    plateau = error[300 + settle :][:rests]
    expected = 0.0 if rests == RESTING else float(plateau.std(ddof=1))
    assert noise == pytest.approx(expected, rel=1e-9)


def test_the_penalty_is_of_orders_weights_and_prior_odds() -> None:
    def scored(orders: float, weights: int, chain: Chain) -> Any:
        return SimpleNamespace(orders=orders, chain=chain, fit=SimpleNamespace(weights=np.zeros(weights)))

    larger, smaller = scored(5.0, 9, LAG.having(DelayPart(1.0))), scored(3.5, 6, LAG)
    odds = causes()["delay"].prior_odds
    assert penalty(larger, smaller, 100.0) == pytest.approx(1.5 * math.log(100.0) + 3 - 2.0 * math.log(odds))


@pytest.mark.parametrize(("least", "pooled"), [(20.0, 45.0), (60.0, 52.0)])
def test_a_pooled_fall_is_bounded_or_the_mean_of_both_and_leaves_blocks_out(
    least: float, pooled: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A fall of 100, if blocks are left out, of which at most 10 are lost; the whitened fall is 4."""
    asked: list[bool] = []

    def fall_from(smaller: Any, left_out: bool = False) -> float:
        asked.append(left_out)
        return 100.0 if left_out else 300.0

    larger: Any = SimpleNamespace(fall_from=fall_from)
    monkeypatch.setattr(slow_evidence, "penalty", lambda *words: 10.0 if words[2] == SAMPLES - 50 else 0.0)
    monkeypatch.setattr(slow_evidence.Whitenings, "whitened_fall", lambda *_: 4.0)
    assert slow_evidence.Whitenings(scene(LAG)).pooled_fall(larger, larger, least) == pooled
    assert asked == [True]


# Bootstrap


def test_a_gain_of_constant_errors_is_exact_and_its_confidence_depends_on_the_share() -> None:
    before, after = np.full(480, 2.0), np.full(480, -1.5)
    found = gain(before, after)
    assert dataclasses.astuple(found) == (2.0, 1.5, 0.5, 0.5, 1.0)
    assert found.fall_um == 0.5
    for share, sure in ((0.24, 1.0), (0.26, 0.0)):
        assert gain(before, after, share).confidence == sure
        assert blockwise_confidence(before, after, share) == sure
        assert combined_confidence(before, after, share) == sure
    assert gain(after, before).confidence == 0.0


def test_the_combined_confidence_exceeds_that_of_the_blocks_by_a_quarter_at_most() -> None:
    before, after = np.ones(BLOCKS * 20), np.full(BLOCKS * 20, 1.01)
    before[:100], after[:100] = 30.0, 5.0
    blocks, power = blockwise_confidence(before, after), gain(before, after).confidence
    assert combined_confidence(before, after) == max(blocks, min(power, blocks + 0.25))
    assert 0.0 < combined_confidence(before, after) <= 1.0


# Ladder and extension


def test_a_third_of_the_blocks_is_left_out_in_turn_and_one_third_of_a_long_record() -> None:
    for rows, turns in ((1200, 3), (MOST_IN_TURN, 3), (MOST_IN_TURN + 1, 1)):
        prepared: Any = SimpleNamespace(training_rows=np.arange(rows) + 7)
        thirds = left_out(prepared)
        assert len(thirds) == turns
        if rows == 1200:
            blocks = [sorted(set(((third - 7) // 100).tolist())) for third in thirds]
            assert blocks == [[1, 4, 7, 10], [0, 3, 6, 9], [2, 5, 8, 11]]
            assert np.array_equal(np.sort(np.concatenate(thirds)), prepared.training_rows)


def test_the_model_for_operation_has_the_bias_of_a_drift_and_forgets_as_fast_as_the_fastest() -> None:
    model = load_model("appendix_a")
    plain = add_online_parts(model, [Extension()], 1.0, 0.002)
    assert (plain.learner, plain.terms) == (model.learner, ())
    parts = [Extension(correction=Trend(0.1)), Extension(forgetting_s=2.0), Extension(forgetting_s=0.5)]
    made = add_online_parts(model, parts, 1.0, 0.002)
    assert made.weights.tolist() == [1.0]
    assert made.learner is not None
    assert (made.learner.noise_um, made.learner.forgetting) == (0.002, pytest.approx(1.0 - model.Ts_s / 0.5))
    assert made.learner.sliding == made.learner.forgetting
    for forgetting_s, kept in ((model.Ts_s, 0.9), (1e9, 1.0 - 1e-7)):
        bounded = add_online_parts(model, [Extension(forgetting_s=forgetting_s)], 1.0, 0.0)
        assert bounded.learner is not None
        assert (bounded.learner.forgetting, bounded.learner.noise_um) == (kept, 1e-9)
    gated = add_online_parts(model, [Extension(gate=True)], 1.0, 0.002).learner
    assert gated is not None


def test_extensions_of_equal_content_give_equal_models() -> None:
    assert Extension().content == Extension().content
    different = [
        Extension(block=Delay(1.0)),
        Extension(size=PathSize()),
        Extension(relaxation=0.1),
        Extension(lag_s=1.0),
        Extension(trust=np.ones(3)),
        Extension(correction=Trend(1.0)),
        Extension(gate=True),
    ]
    assert len({extension.content for extension in [Extension(), *different]}) == 8
    assert Extension(forgetting_s=1.0).content == Extension(gate=True).content, "both need a learner"
    assert [extension.on_path for extension in different] == [True, True, *[False] * 5]


# Answer


STEP = Gain(0.030, 0.020, 0.008, 0.012, 0.97)


def cause(**more: Any) -> NamedCause:
    usual: dict[str, Any] = {
        "name": "creep",
        "parameters": {"per_decade": Estimate(0.02, 0.001)},
        "evidence": "it creeps",
        "statistic": 20.0,
        "step": STEP,
        "alone": Gain(0.03, 0.02, 0.009, 0.011, 1.0),
        "confidence": 0.9876,
        "bayes": 30.0,
        "probe_gain": 1.5,
        "share": 0.25,
        "cold_um": (0.035, 0.025),
        "price": Price(12, -8),
    }
    return NamedCause(**(usual | more))


def test_why_a_cause_is_not_extended_is_said() -> None:
    assert cause().why_not_extended == ""
    assert "gains less than 2 % on rows left out of the fit" in cause(extended=False).why_not_extended


def test_the_fall_of_rungs_that_raise_the_error_is_split_between_them_and_the_next() -> None:
    # Slew alone makes the model wrong, and with memory it removes most: its part is a half of what both remove.
    assert joint_shares([1.0, 359.0, 0.2], [3.0, 3.0]) == pytest.approx([0.4, 0.4])
    assert joint_shares([1.0, 0.4, 0.1], [0.0, 0.0]) == pytest.approx([0.6, 0.3])
    assert joint_shares([1.0, 0.1, 0.3], [3.0, 1.0]) == pytest.approx([0.525, 0.175])
    assert joint_shares([1.0, 1.5], [2.0]) == [0.0]
    assert joint_shares([1.0], []) == []


@pytest.mark.parametrize("seed", range(20))
def test_shares_and_what_is_left_add_up_to_the_whole(seed: int) -> None:
    rng = np.random.default_rng(seed)
    powers = [1.0, *np.exp(rng.normal(scale=2.0, size=rng.integers(1, 6))).tolist()]
    shares = joint_shares(powers, rng.normal(size=len(powers) - 1).tolist())
    assert min(shares) >= 0.0
    assert sum(shares) == pytest.approx(max(powers[0] - powers[-1], 0.0), abs=1e-12)


def test_a_cause_in_json_holds_every_number_in_its_place() -> None:
    found = json.loads(json.dumps(cause().to_json()))
    assert found["gain"] == {
        "free_run_rms_before": 0.03,
        "free_run_rms_after": 0.02,
        "ci95": [0.008, 0.012],
        "cold_before": 0.035,
        "cold_after": 0.025,
        "alone": {"fall_um": pytest.approx(0.01), "ci95": [0.009, 0.011]},
    }
    assert (found["log_bayes_factor"], found["separated_by_likelihood"]) == (15.0, True)
    assert (found["cost"], found["share"], found["extended"]) == ({"cycles": 12, "bytes": -8}, 0.25, True)
    assert (found["parameters"], found["standard_errors"]) == ({"per_decade": 0.02}, {"per_decade": 0.001})
    bare = cause(bayes=None, alone=None, price=None).to_json()
    assert (bare["log_bayes_factor"], bare["separated_by_likelihood"], bare["cost"]) == (None, False, None)
    assert bare["gain"]["alone"] is None


def test_the_ladder_shows_the_causes_in_the_model_between_the_paper_and_the_noise() -> None:
    diagnosis: Any = SimpleNamespace(
        causes=(cause(), cause(name="delay", extended=False), cause(name="outliers", confidence=None, price=None)),
        base_rms_um=0.03,
        base_own_um=0.029,
        noise=SimpleNamespace(rms_um=0.001),
    )
    study = Study(diagnosis, *[None] * 4, span_um=10.0)  # type: ignore[arg-type]
    assert study.improved
    assert study.percent(0.02) == 0.2
    assert study.ladder() == [
        ["paper's model", "0.03", "0.3 %", "0.029", *[""] * 5],
        ["+ creep", "0.025", "0.25 %", "0.02", "0.008 .. 0.012", "25.0 %", "+12", "-8", "0.988"],
        ["+ outliers", "0.025", "0.25 %", "0.02", "0.008 .. 0.012", "25.0 %", "", "", ""],
        ["noise floor", "0.001", "0.01 %", *[""] * 6],
    ]
    assert [share_text(cause(share=share)) for share in (0.0, 0.0004, 0.0005, 0.5)] == [
        "0.0 %",
        "< 0.1 %",
        "0.1 %",
        "50.0 %",
    ]
    assert (confidence_text(cause(confidence=None)), confidence_text(cause(confidence=1.0))) == ("", "1.000")


# Advice


def test_noise_that_its_past_does_not_predict_is_the_white_part() -> None:
    chirp = 5.0 * np.sin(2e-6 * np.arange(WHITE.size) ** 2.0)
    assert identifiability.unpredictable_um(0.01 * WHITE) == pytest.approx(0.01, rel=0.05)
    assert identifiability.unpredictable_um(0.01 * WHITE + chirp) == pytest.approx(0.01, rel=0.35)
    assert identifiability.unpredictable_um(WHITE[:255]) == math.inf
    assert identifiability.unpredictable_um(WHITE[:256]) < math.inf
    assert identifiability.unpredictable_um(0.01 * WHITE + 3.0 * np.arange(WHITE.size)) == pytest.approx(0.01, rel=0.05)


def said(error: Callable[[np.ndarray], np.ndarray]) -> str:
    k = np.arange(4000)
    u_V = 50.0 * (1.0 - np.cos(k / 50.0))
    prepared: Any = SimpleNamespace(u_V=u_V, y_um=0.1 * u_V)
    return identifiability.residual_in_words(error(k), prepared, k)


def test_a_residual_is_said_in_words() -> None:
    noise = 0.1 * WHITE[:4000]
    assert said(lambda k: noise) == "fast"
    assert said(lambda k: np.sin(k / 500.0)) == "slow"
    assert said(lambda k: noise * (1.5 - np.cos(k / 50.0))) == "fast, larger at high displacement"
    assert said(lambda k: noise * (1.5 + np.cos(k / 50.0))) == "fast, larger at low displacement"
    assert said(lambda k: np.sign(np.sin(k / 50.0)) * 0.1 + 0.5 * noise).endswith("depends on the direction")
    for jumps, words in ((5, "fast"), (6, "6 jumps, fast")):
        assert said(
            lambda k, n=jumps: 0.01 * noise + 0.3 * (np.searchsorted(np.arange(1, n + 1) * 300, k, "right") % 2)
        ) in (
            words,
            words.replace("fast", "slow"),
        )


def test_what_to_record_next_follows_from_turns_swings_durations_and_rests() -> None:
    def next_for(u_V: np.ndarray) -> str:
        return identifiability.next_experiment(SimpleNamespace(u_V=u_V, cut=u_V.size))  # type: ignore[arg-type]

    k = np.arange(6000)
    rest = np.full(1500, 50.0)
    alike = next_for(50.0 + 40.0 * np.sin(k / 50.0))
    assert alike.startswith("drive with nested amplitudes, 20 to 100 % of the range")
    assert "two frequencies at least a decade apart" in alike
    assert alike.endswith("plateaus of a second or more after full strokes, to tell creep from drift")
    assert "plateaus" not in next_for(np.concatenate([50.0 + 40.0 * np.sin(k / 50.0), rest]))
    assert next_for(np.linspace(0.0, 1.0, 500) ** 2).startswith("drive with more turning points: triangles or sines")
    nested = 50.0 + 40.0 * np.exp(-k / 2000.0) * np.sin(k / 50.0)
    assert "nested" not in next_for(nested)
    swept = 50.0 + 40.0 * np.sin(2e-5 * k**2.0)
    assert "two frequencies" not in next_for(swept)
    rich = np.concatenate([50.0 + 40.0 * np.exp(-k / 2000.0) * np.sin(1e-5 * k**2.0), rest])
    assert next_for(rich) == ""
