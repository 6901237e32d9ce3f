"""What is evidence: between two samples, at rest, along the way of the stage, and what is none.

What a record can tell: the least effect holds its promise, hidden and missing effects are told apart.
"""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fixtures.linear_stage import (
    AXIS2_V,
    COMMAND_V,
    CREEP,
    LAG,
    LINEAR,
    NOISE_UM,
    SAMPLES,
    SPAN_S,
    T_S,
    TS_S,
    named,
    respond,
    scene,
)
from hysgen.diagnosis.causes import Residual, causes
from hysgen.diagnosis.causes.aging import AgingPart
from hysgen.diagnosis.causes.creep import CreepPart
from hysgen.diagnosis.causes.drift import DriftPart
from hysgen.diagnosis.causes.hysteresis import RelaxationPart
from hysgen.diagnosis.causes.unknown import SuddenPart, UnknownCause
from hysgen.diagnosis.identifiability import Ability, _Information, abilities
from hysgen.diagnosis.prepare import prepare
from hysgen.diagnosis.probe import Chain, Mode, Scene, Trace, linear_fit, refine, rms, whitened_fit
from hysgen.diagnosis.procedure import name_causes
from hysgen.diagnosis.score import LEAST_EVIDENCE, Scored, present, resting_noise
from hysgen.diagnosis.search import search
from hysgen.machine.kernels import innovation_gains, innovations
from hysgen.machine.processes import one_blas_thread
from hysgen.model.disturbances.coupling import Coupling
from hysgen.model.path.modes import Modes
from hysgen.record import Record
from hysgen_lab.stage import Density, NoiseEffect, Relays, Stage
from hysgen_lab.stage import run as measure
from hysgen_lab.stage.effects.memory import Hysteresis, draw_curve
from hysgen_lab.stage.effects.readings import ChirpEffect
from hysgen_lab.studies.bank.family_scenario import family_scenario
from hysgen_lab.studies.bank.scenario import ACCEPTED, good

Floats = NDArray[np.float64]


@pytest.mark.slow
def test_jumps_below_the_misfit_are_evident_between_two_samples() -> None:
    """Up, up and down, on a misfit twice as large."""
    planted_s = (0.9, 2.0, 3.1)
    stairs_um = 0.06 * sum(sign * (t_s <= T_S) for sign, t_s in zip((1.0, 1.0, -1.0), planted_s, strict=True))
    bent_um = 0.2 * respond(np.sin(0.06 * np.pi * COMMAND_V), LAG, TS_S)

    def evidence(more_um: Floats, *times_s: float) -> float:
        seen = scene(LAG, more_um)
        return UnknownCause().evidence(seen, refine(seen, LAG.having(SuddenPart(times_s))))

    assert evidence(bent_um + stairs_um, *planted_s) > 3.0 * LEAST_EVIDENCE
    assert evidence(bent_um + stairs_um, 1.4) == 0.0
    assert evidence(bent_um, *planted_s) == 0.0
    found = search(scene(LAG, bent_um + stairs_um))
    assert named(found) == ["curve", "unknown"]
    for at_s in found.fit.chain.of(SuddenPart).times_s:
        assert min(abs(at_s - true_s) for true_s in planted_s) < 2.0 * TS_S
    assert named(search(scene(LAG, bent_um))) == ["curve"]


RATE_S, ROWS = 1e-3, 7000
NARROW = Relays(Density(40.0, 55.0, 15.0, 65.0), 0.15)
VIBRATION = ChirpEffect(first_Hz=5.0, last_Hz=20.0, over_s=RATE_S * ROWS, amplitude_um=0.4)


def stage(hysteresis: Hysteresis) -> Stage:
    return Stage(stroke_um=15.0, lag_s=8e-3, memory=hysteresis, noise=NoiseEffect(5e-4))


def names(measured: Stage, seed: int) -> set[str]:
    u_V = good(np.random.default_rng([seed, 77]), ROWS, 0.0, 100.0)
    y_um = measure(measured, u_V, RATE_S, seed).displacement_um
    return set(name_causes(Record.from_arrays(u_V, y_um, RATE_S, accept=ACCEPTED)).names)


def test_a_vibration_is_noise_while_the_stage_rests_and_a_misfit_is_not() -> None:
    """The misfit: 0.2 um of a sine of the voltage, which the curve of the operator cannot follow."""
    shaken = scene(LAG, 0.05 * np.sin(2.0 * np.pi * 17.0 * T_S))
    bent = scene(LAG, 0.2 * respond(np.sin(0.4 * np.pi * COMMAND_V), LAG, TS_S))
    assert resting_noise(shaken, refine(shaken, LAG)) == pytest.approx(0.05 / np.sqrt(2.0), rel=0.1)
    assert rms(refine(bent, LAG).error) > 0.05
    assert resting_noise(bent, refine(bent, LAG)) == pytest.approx(NOISE_UM, rel=0.2)


def test_corrupted_samples_are_no_noise() -> None:
    spikes_um = np.where(np.arange(SAMPLES) % 50 == 0, 5.0, 0.0)
    spiked = scene(LAG, spikes_um)
    spiked = spiked.using(spiked.rows[spikes_um[spiked.rows] == 0.0])
    assert resting_noise(spiked, refine(spiked, LAG)) == pytest.approx(NOISE_UM, rel=0.1)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.slow
def test_memory_is_named_beside_a_vibration_of_changing_frequency(seed: int) -> None:
    curve = draw_curve(np.random.default_rng(seed), 15.0)
    assert names(stage(curve).with_effects(chirp=VIBRATION), seed) == {"unknown"}
    assert names(stage(NARROW).with_effects(chirp=VIBRATION), seed) == {"memory", "unknown"}


def told(seen: Scene, chain: object = LAG) -> dict[str, Ability]:
    residual = Residual(seen, refine(seen, chain))  # type: ignore[arg-type]
    return {one.name: one for one in abilities(residual, residual, {"memory": None})}


@pytest.mark.parametrize(("times", "holds"), [(2.0, True), (0.3, False)])
@pytest.mark.slow
def test_a_drift_shows_from_the_least_size_on(times: float, holds: bool) -> None:
    least = told(scene(LAG))["drift"].least
    assert least is not None
    found = search(scene(LAG, times * least * T_S))
    assert causes()["drift"].present(found.fit.chain) == holds


def test_a_drift_beside_a_gain_about_an_unknown_zero_is_less_certain() -> None:
    alone, beside = told(scene(LAG))["drift"], told(scene(LAG), LAG.having(AgingPart(1e-3 / SPAN_S)))["drift"]
    assert alone.least is not None
    assert beside.least is not None
    assert beside.least > 1.2 * alone.least


def test_a_record_without_channels_cannot_show_coupling() -> None:
    assert told(scene(LAG))["coupling"].verdict == "not excited"
    assert told(scene(LAG, aux={"axis2_V": AXIS2_V}))["coupling"].verdict == "above"


def test_a_cause_that_copies_a_part_of_the_chain_is_hidden_by_it() -> None:
    """A channel that is a straight line in time, beside a drift."""
    seen = scene(LAG, 0.1 * T_S, aux={"clock": T_S.copy()})
    coupling = told(seen, LAG.having(DriftPart()))["coupling"]
    assert (coupling.verdict, coupling.hidden_by) in {("hidden", "drift"), ("not excited", "")}


@pytest.mark.parametrize("start", [Mode(60.0, 0.3, 0.05), Mode(60.0, 0.05, 0.05), Mode(120.0, 0.2, -0.5)])
def test_a_peak_whose_place_is_not_known_is_no_mode(start: Mode) -> None:
    """A second lag beside the first is described by a broad mode at any frequency; a mode is found from each start."""
    resonance, chain = causes()["resonance"], LAG.having(Modes.of([start], LAG.lag_s))
    slower = scene(LAG, 0.02 * respond(respond(COMMAND_V, Chain(2e-3, memory=False), TS_S), LAG, TS_S))
    ringing = scene(LAG.having(Modes.of([Mode(60.0, 0.05, 0.05)], LAG.lag_s)))
    assert not resonance.admissible(slower, refine(slower, chain))
    assert resonance.admissible(ringing, refine(ringing, chain))


def test_what_only_the_lag_hides_is_hidden_by_no_cause() -> None:
    """A chain of a curve alone has no other cause; memory that moves as the lag does must not end in an exception."""
    residual = Residual(scene(LAG), refine(scene(LAG), LAG))
    information = _Information.of(residual)
    lagging = np.zeros(SAMPLES)
    lagging[information.scored.scene.rows] = information.parts[""][-1]
    *_, share, hidden_by = information.least("memory", lagging + 1e-3 * AXIS2_V)
    assert share < 0.1
    assert hidden_by == ""


def test_a_command_that_stands_still_excites_no_delay() -> None:
    moving = scene(LAG)
    run = dataclasses.replace(moving.runs[0], u_V=np.full_like(moving.runs[0].u_V, 5.0))
    still = dataclasses.replace(moving.bare(), runs=(run,))
    assert told(still)["delay"].verdict == "not excited"


def test_every_ability_says_what_to_record() -> None:
    for ability in told(scene(LAG)).values():
        assert ability.verdict == "named" or ability.experiment
        assert ability.text()


@given(seed=st.integers(0, 2**32 - 1), misfit=st.floats(0.01, 10.0), noise=st.floats(0.01, 10.0))
def test_innovations_have_the_likelihood_of_the_dense_covariance(seed: int, misfit: float, noise: float) -> None:
    rng = np.random.default_rng(seed)
    n = 30
    keep, heard, z = rng.random(n) ** 0.3, (rng.random(n) < 0.8).astype(float), rng.normal(size=n)
    heard[0] = 1.0
    gain, variance = innovation_gains(keep, heard, misfit, noise)
    rows = np.flatnonzero(heard)
    news = innovations(z[None], keep, gain, variance)[0, rows]
    # What two samples share of the misfit is what every step between them keeps of it.
    kept = np.exp(np.add.outer(-np.cumsum(np.log(keep)), np.cumsum(np.log(keep))))
    covariance = misfit * np.minimum(kept, kept.T)[np.ix_(rows, rows)] + noise * np.eye(len(rows))
    assert news @ news == pytest.approx(z[rows] @ np.linalg.solve(covariance, z[rows]), rel=1e-9)
    assert np.log(variance[rows]).sum() == pytest.approx(np.linalg.slogdet(covariance)[1], rel=1e-9, abs=1e-9)


@pytest.mark.slow
def test_creep_is_identified_from_plateaus_beside_a_coarse_hysteresis() -> None:
    """150 relays jump where no smooth density does; what that leaves takes the place of creep, unless it rests too."""
    plain, result = [], []
    for seed in range(6):
        hysteresis = Relays(Density(40.0, 55.0, 15.0, 65.0), 0.4, count=150)
        stage = Stage(stroke_um=15.0, lag_s=8e-3, memory=hysteresis, noise=NoiseEffect(5e-4))
        u_V = good(np.random.default_rng([seed, 77]), 7000, 0.0, 100.0)
        y_um = measure(stage.with_effects(creep=(0.006, 0.015, 7000.0)), u_V, 1e-3, seed).displacement_um
        seen = prepare(Record.from_arrays(u_V, y_um, 1e-3)).scene()
        fit = refine(seen, Chain(8e-3, (CreepPart(0.003, 0.05),)), rounds=30)
        signature = causes()["creep"].signature(Residual(seen, fit), fit)
        if signature.z > 4.0:
            plain.append(abs((fit.chain.parts[0].values[0]) / 0.006 - 1.0))
            result.append(abs(signature.parameters["per_decade"].value / 0.006 - 1.0))
    assert len(result) >= 4
    assert max(result) < 0.15
    assert max(plain) > 0.5


def test_unused_samples_do_not_change_the_innovations() -> None:
    seen = scene(CREEP)
    rows = seen.rows[seen.rows % 100 != 0]
    spiked_um = seen.y_um.copy()
    spiked_um[::100] += 50.0
    spiked = dataclasses.replace(seen, runs=(dataclasses.replace(seen.runs[0], y_um=spiked_um),))
    chains = [whitened_fit(one.using(rows), refine(one.using(rows), CREEP))[1].chain for one in (seen, spiked)]
    assert chains[0] == chains[1]


def scene_of(family: str) -> Scene:
    hidden = family_scenario(family, "memory", 3)
    return prepare(hidden.record(hidden.measure())).excerpt()


@pytest.mark.parametrize(("family", "relaxes"), [("thermal", True), ("preisach", False)])
@pytest.mark.slow
def test_relaxation_is_named_if_the_hysteresis_depends_on_time(family: str, relaxes: bool) -> None:
    with one_blas_thread():
        found = search(scene_of(family))
    assert ("relaxation" in present(found.fit.chain)) == relaxes
    if relaxes:
        assert found.error_growth["relaxation"] > 1.2
        assert 0.01 < found.fit.chain.of(RelaxationPart).half_widths < 0.06


TIMES_S, SAMPLES_OF_CURVE = 1e-3, 7000
STAGE = Stage(stroke_um=15.0, lag_s=30e-3)
BENT = dataclasses.replace(STAGE, noise=NoiseEffect(2e-4))
FLICKERING = dataclasses.replace(STAGE, lag_s=8e-3, noise=NoiseEffect(5e-3, 2.5e-3))


def named_on(stage: Stage, bend: float, seed: int) -> tuple[str, ...]:
    """The causes of a stage with a curve. bend: of the sensor, c of y + c s (1 - s) span, s = (y - low) / span."""
    u_V = good(np.random.default_rng([seed, 77]), SAMPLES_OF_CURVE, 0.0, 100.0)
    curve = draw_curve(np.random.default_rng(seed), stage.stroke_um)
    y_um = measure(dataclasses.replace(stage, memory=curve), u_V, TIMES_S, seed).displacement_um
    share = (y_um - y_um.min()) / np.ptp(y_um)
    return name_causes(Record.from_arrays(u_V, y_um + bend * np.ptp(y_um) * share * (1.0 - share), TIMES_S)).names


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("stage", "bend"), [(BENT, 0.02), (FLICKERING, 0.0)], ids=["curved sensor", "1/f noise"])
@pytest.mark.slow
def test_no_cause_is_named_but_the_curve_of_the_ceramic(stage: Stage, bend: float, seed: int) -> None:
    assert named_on(stage, bend, seed) == ("curve",)


@pytest.mark.slow
def test_weights_that_fit_coloured_noise_are_no_evidence() -> None:
    """A channel that has nothing to do with the stage, as slow as the noise, over 32 samples."""
    rng = np.random.default_rng(3)
    slow = np.exp(-np.arange(200) / 40.0)

    def wandering() -> Floats:
        return np.convolve(rng.normal(size=SAMPLES), slow)[:SAMPLES]

    seen = scene(LAG, 2e-4 * wandering(), {"axis2_V": wandering()})
    with_taps = LAG.having(Coupling.of({"axis2_V": (-1e3, 1e3)}, 32))
    larger, smaller = (Scored.of(seen, refine(seen, chain)) for chain in (with_taps, LAG))
    assert larger.fall_from(smaller, left_out=True) < larger.fall_from(smaller)
    assert "coupling" not in present(search(seen).fit.chain)


def test_a_mode_that_rings_from_a_movement_before_the_record_is_found_as_it_is() -> None:
    mode = Mode(22.0, 0.02, 0.1)
    left_um = 0.5 * np.exp(-2.0 * np.pi * mode.f_Hz * mode.zeta * T_S) * np.cos(2.0 * np.pi * mode.f_Hz * T_S + 1.0)
    seen = scene(LAG.having(Modes.of((mode,), 1.0)), left_um)
    fit = refine(seen, LAG.having(Modes.of((Mode(24.0, 0.05, 0.2),), 1.0)))
    found = fit.chain.of(Modes).modes[0]
    assert fit.rms_um < 1.1e-3
    assert found.zeta == pytest.approx(mode.zeta, rel=0.01)
    assert found.share == pytest.approx(mode.share, rel=0.01)


def test_a_curve_of_the_sensor_that_few_samples_show_is_not_extrapolated() -> None:
    """A slow command with one step, which the fitted rows do not hold: at the step the fit predicts no other curve."""
    t_s = 1e-3 * np.arange(20_000)
    u_V = 50.0 + 40.0 * np.sin(0.4 * t_s) * np.where(t_s > 10.0, -1.0, 1.0)
    y_um = 0.1 * respond(u_V, LAG, 1e-3) + 1e-3 * np.random.default_rng(8).normal(size=len(t_s))
    rows = np.concatenate([np.arange(50, 9_990), np.arange(10_200, len(t_s))])
    seen = Scene((Trace(u_V, y_um, {}),), 1e-3, rows, LINEAR)
    assert np.abs(linear_fit(seen, LAG).error[50:]).max() < 0.03
