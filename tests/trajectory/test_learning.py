"""Learning over repeats on stages whose equations are foreign to hysgen."""

from collections.abc import Callable
from itertools import accumulate

import numpy as np
import pytest
from scipy.optimize import lsq_linear
from scipy.signal import lfilter

import hysgen
from hysgen.diagnosis.probe.solve import rms
from hysgen.model.model import Grid, Model
from hysgen.model.path.structure import Structure
from hysgen.model.rivals import fit_proportional
from hysgen.record import Record
from hysgen.record.segment import Segment
from hysgen.trajectory.learning import _by_time
from hysgen.trajectory.passing import learnt, passing
from hysgen_lab.stage.families import Plant, plant, records
from hysgen_lab.stage.measure import run

Play = Callable[[np.ndarray, int], np.ndarray]


def player(hidden: Plant) -> Play:
    """Reading, (n,), under voltages, (n,), in a repeat with noise of its own, on a stage that comes from elsewhere."""
    middle_V = 0.5 * sum(hidden.range_V)

    def play(u_V: np.ndarray, repeat: int) -> np.ndarray:
        before = np.concatenate([np.linspace(hidden.range_V[1], middle_V, 800), np.linspace(middle_V, u_V[0], 800)])
        seen = run(hidden.stage, np.concatenate([before, u_V]), hidden.Ts_s, repeat, rest_V=hidden.range_V[1])
        return np.asarray(seen.displacement_um[before.size :])

    return play


def played(plan: hysgen.Waveform, y_um: np.ndarray) -> Record:
    return Record.from_segments([Segment("0", plan.u_V, y_um, {}, plan.start_s)], plan.Ts_s, "played")


@pytest.mark.slow
@pytest.mark.parametrize(("family", "form"), [("preisach", "triangle"), ("relays", "scan"), ("bouc-wen", "sine")])
def test_repeats_of_a_foreign_stage_reach_its_noise(family: str, form: str) -> None:
    hidden = plant(family, "memory", 0)
    (u_V, y_um), (later_V, later_um) = records(hidden, (16_000, 8000))
    record = Record.from_arrays(u_V, y_um, hidden.Ts_s)
    model = hysgen.fit(record, memory=True)
    free_run_um = hysgen.score(model, Record.from_arrays(later_V, later_um, hidden.Ts_s)).free_run.e_rms_um
    shape = hysgen.Form(0.3 * hidden.stroke_um, f_Hz=0.002 / hidden.Ts_s, periods=3)
    play, plays, errors = player(hidden), [], []
    plan = hysgen.waveform(model, form, shape, loop=True)
    wanted = plan.reference.values
    straight = np.append(fit_proportional(record).inverse(wanted), 0.0)[: wanted.size - 1]
    proportional_um = rms(play(straight, 9)[: straight.size] - wanted[: straight.size])
    for repeat in range(6):
        y_um = play(plan.u_V, repeat)
        errors.append(rms(y_um[plan.lead :] - wanted))
        plays.append(played(plan, y_um))
        plan = hysgen.waveform(model, form, shape, loop=True, plays=plays)
        assert plan.learning is not None
    assert errors[0] < 0.25 * proportional_um
    assert errors[0] < 2.0 * free_run_um + 2.0 * hidden.noise_um
    assert errors[5] < 1.5 * hidden.noise_um
    assert plan.learning.noise_um == pytest.approx(hidden.noise_um, rel=0.2)


def test_a_repeat_that_made_the_error_worse_is_left_and_learning_stops_there() -> None:
    """A stage whose gain has the wrong sign for the model: every step of a blind learner doubles the error."""
    model = hysgen.load_model("appendix_a")
    form = hysgen.Form(0.3, f_Hz=50.0, periods=2)
    first = hysgen.waveform(model, "sine", form)
    wanted, centre_um = first.reference.values, float(first.reference.values.mean())
    rng, plays, plan = np.random.default_rng(0), [], first

    def record(now: hysgen.Waveform) -> Record:
        answer_um = model.simulate(now.u_V)
        return played(now, centre_um - 1.2 * (answer_um - centre_um) + rng.normal(0.0, 1e-3, answer_um.size))

    for _ in range(4):
        plays.append(record(plan))
        plan = hysgen.waveform(model, "sine", form, plays=plays)
        assert plan.learning is not None
        assert plan.learning.diverges
    assert not plan.holds
    assert np.abs(plan.u_V - first.u_V).max() < 0.05 * np.ptp(first.u_V)
    assert rms(plan.y_um - wanted) < 1e-6


def test_a_mode_that_the_model_lacks_is_learnt_from_what_was_played() -> None:
    """At the mode the stage moves several times what the model says, and against it just above."""
    model = hysgen.load_model("appendix_a")
    form = hysgen.Form(0.3, f_Hz=50.0, periods=4)
    plan = hysgen.waveform(model, "triangle", form)
    pole = 0.995 * np.exp(2j * np.pi * 900.0 * model.Ts_s)
    wanted, rng, plays, errors = plan.reference.values, np.random.default_rng(1), [], []
    for _ in range(5):
        answer_um = model.simulate(plan.u_V)
        ringing_um = np.real(lfilter([1.0], [1.0, -pole], np.diff(answer_um, prepend=answer_um[0])))
        y_um = answer_um - 0.6 * ringing_um + rng.normal(0.0, 5e-4, answer_um.size)
        errors.append(rms(y_um[plan.lead :] - wanted))
        plays.append(played(plan, y_um))
        plan = hysgen.waveform(model, "triangle", form, plays=plays)
    assert errors[1] < 1.5 * errors[0]
    assert max(errors[3:]) < 0.35 * errors[0]


def test_a_stage_within_its_uncertainty_nears_its_noise_with_every_repeat() -> None:
    """A mode of 800 Hz, 0.8 % lower, damped more and 5 % less of the displacement, behind a gain that is 8 % larger."""

    def chain(gain: float, f_Hz: float, zeta: float, share: float) -> Model:
        rules = np.tile([np.exp(-0.2), *(np.array([gain, 50.0 - 50.0 * gain]) * (1.0 - np.exp(-0.2)))], (4, 1))
        block = Structure((f_Hz,), (zeta,), (share,), 1e-4, (0.0,), 2e-5)
        return Model("chain", 2e-5, Grid(-40.0, 140.0, 4), rules, -20.0, 120.0, blocks=(block,))

    own, other = chain(1.0, 800.0, 0.01, 1.0), chain(1.08, 793.6, 0.0124, 0.95)
    form, noise_um = hysgen.Form(1.0, 50.0, 100.0, 4), 5e-4
    plan = hysgen.waveform(own, "triangle", form)
    wanted, rng, plays, errors = plan.reference.values, np.random.default_rng(2), [], []
    for _ in range(5):
        y_um = other.simulate(plan.u_V) + rng.normal(0.0, noise_um, plan.u_V.size)
        errors.append(rms(y_um[plan.lead :] - wanted))
        # The model of this file has no score: the repeats say what the next one leaves, at most.
        assert (plan.predicted_um is None) == (len(errors) == 1)
        assert len(errors) == 1 or errors[-1] < 1.1 * (plan.predicted_um or 0.0)
        plays.append(played(plan, y_um))
        plan = hysgen.waveform(own, "triangle", form, plays=plays)
    assert errors[1] < 2.0 * noise_um
    assert max(errors[2:]) < 1.5 * noise_um


def test_an_error_is_learnt_the_slower_the_more_its_voltage_moves_what_the_model_does_not_foresee() -> None:
    """The second play moves the voltage at 4 kHz and the stage besides, below 100 Hz, by 4 % of that at rest."""
    model, n, amplitude_V, share = hysgen.load_model("appendix_a"), 4000, 3.0, 0.04
    time_s, middle_V = model.Ts_s * np.arange(n), 0.5 * (model.u_min_V + model.u_max_V)
    fast_V = amplitude_V * np.sin(2.0 * np.pi * 4000.0 * time_s)
    at_rest, answers = (model.simulate(middle_V + part * fast_V) for part in (0.0, 1.0))
    per_V = float(np.ptp(model.simulate(np.repeat([middle_V, middle_V + amplitude_V], n)))) / amplitude_V
    slow_um = share * per_V * amplitude_V * np.sin(2.0 * np.pi * np.array([[30.0], [90.0]]) * time_s).sum(axis=0)
    shares = []
    for besides_um in (np.zeros(n), slow_um / np.sqrt(2.0)):
        passed = passing(model, [at_rest, answers], [np.zeros(n), besides_um], [1, 1], 1e-5)
        shares.append(abs(learnt(model, passed, np.array([4000.0]))[0][0]))
    gain = rms(answers[n // 2 :] - at_rest[n // 2 :]) / (per_V * amplitude_V / np.sqrt(2.0))
    assert passed.otherwise == pytest.approx(share, rel=0.15)
    assert shares[1] / shares[0] == pytest.approx(1.0 / (1.0 + (share / gain) ** 2), rel=0.15)


def test_a_corner_that_a_limit_hides_from_the_model_is_left_and_the_rest_learnt() -> None:
    """The sine begins with a step of 0.8 V; the stage, whose gain is 3 % larger, moves by 0.1 V a sample at most."""
    rules = np.tile([np.exp(-0.02), *(np.array([1.0, 0.0]) * -np.expm1(-0.02))], (4, 1))
    own = Model("slow", 2e-5, Grid(-40.0, 140.0, 4), rules, -20.0, 120.0)
    form, noise_um = hysgen.Form(1.0, 50.0, 100.0, 4), 5e-4
    plan = hysgen.waveform(own, "sine", form, loop=True)
    wanted, rng, plays, errors = plan.reference.values, np.random.default_rng(3), [], []
    assert np.abs(np.diff(plan.u_V)).max() > 0.5
    for _ in range(7):
        held_V = np.array(list(accumulate(plan.u_V.tolist(), lambda held, u: held + min(max(u - held, -0.1), 0.1))))
        y_um = 1.03 * own.simulate(held_V) - 1.5 + rng.normal(0.0, noise_um, held_V.size)
        errors.append(y_um[plan.lead :] - wanted)
        plays.append(played(plan, y_um))
        plan = hysgen.waveform(own, "sine", form, loop=True, plays=plays)
    assert max(map(rms, errors[4:])) < rms(errors[1])
    assert rms(errors[-1][errors[-1].size // 4 :]) < 1.5 * noise_um
    assert plan.learning is not None
    assert plan.learning.stays_um == pytest.approx(rms(errors[-1]), rel=0.3)


@pytest.mark.parametrize(("later", "left"), [(0.95, True), (0.5, False)])
def test_a_time_is_left_where_the_error_stays_and_not_where_it_falls_after_it_grew(later: float, left: bool) -> None:
    """The first step trebles the error of the last quarter, as a mode that rings there does; elsewhere all falls."""
    rng, quarter = np.random.default_rng(5), np.arange(2000) >= 1500
    steps = [np.where(quarter, k, e) for k, e in zip((1.0, 3.0, 3.0 * later), (10.0, 3.0, 1.0), strict=True)]
    errors = [1e-3 * step * rng.standard_normal(2000) for step in steps]
    _, trust = _by_time(errors, [0.1 * e for e in errors], 2, 1e-5)
    assert (trust[1750] < 0.5) == left
    assert trust[:1000].min() == pytest.approx(1.0)


def test_inside_stated_limits_learning_ends_at_the_least_that_they_leave() -> None:
    """Steps of 1 um that the amplifier's 0.25 V a sample cannot follow, on a stage whose gain is 3 % larger."""
    keep, slew_V, noise_um = np.exp(-0.1), 0.25, 5e-4
    rules = np.tile([keep, 1.0 - keep, 0.0], (4, 1))
    own = Model("slow", 2e-5, Grid(-40.0, 140.0, 4), rules, -20.0, 120.0)
    wanted = np.repeat([10.0, 11.0, 13.0, 12.0], 100)

    def answer(u_V: np.ndarray) -> np.ndarray:
        return np.asarray(10.0 + 1.03 * (own.simulate(u_V) - 10.0))

    plan = hysgen.waveform(own, wanted, slew_V_s=slew_V / 2e-5)
    moves = np.tril(np.ones((wanted.size - 1, wanted.size - 1)))
    steps = [answer(np.append(10.0, 10.0 + 0.1 * row))[-wanted.size + 1 :] - 10.0 for row in moves.T]
    best = lsq_linear(np.transpose(steps) / 0.1, wanted[1:] - 10.0, (-slew_V, slew_V))
    least_um = np.sqrt(2.0 * best.cost / wanted.size)
    rng, plays, errors = np.random.default_rng(4), [], []
    for _ in range(5):
        y_um = answer(plan.u_V)
        errors.append(rms(y_um[plan.lead :] - wanted))
        plays.append(played(plan, y_um + rng.normal(0.0, noise_um, y_um.size)))
        plan = hysgen.waveform(own, wanted, slew_V_s=slew_V / 2e-5, plays=plays)
    assert errors[0] > least_um + 5.0 * noise_um
    assert max(errors[3:]) < least_um + 1.5 * noise_um


def test_an_error_where_the_stage_hardly_passes_is_left_and_said() -> None:
    """5 nm at 12 kHz, where the stage passes a hundredth, would ask for tens of volts."""
    model = hysgen.load_model("appendix_a")
    form = hysgen.Form(0.3, f_Hz=50.0, periods=2)
    first = hysgen.waveform(model, "sine", form)
    time_s = model.Ts_s * np.arange(first.u_V.size)
    y_um = 1.02 * model.simulate(first.u_V) + 5e-3 * np.cos(2.0 * np.pi * 12_000.0 * time_s)
    following = hysgen.waveform(model, "sine", form, plays=[played(first, y_um)])
    assert following.learning is not None
    assert following.learning.stays_um == pytest.approx(5e-3 / np.sqrt(2.0), rel=0.06)
    assert any("not learnt: 0.003" in line for line in following.learning.lines())
    assert np.abs(following.u_V - first.u_V).max() < 1.0
