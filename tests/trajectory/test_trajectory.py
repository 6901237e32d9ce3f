"""The voltage for a trajectory: played through the model it gives the reference, or the least largest error."""

import dataclasses
import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy import sparse
from scipy.linalg import toeplitz
from scipy.optimize import linprog

import hysgen
from hysgen.cli import main
from hysgen.errors import HysgenError
from hysgen.float32.reference.instance import Instance
from hysgen.model.model import Grid, Model
from hysgen.model.path import InputBlock, kinds
from hysgen.model.path.delay import Delay
from hysgen.model.path.modes import Modes
from hysgen.model.path.structure import Structure
from hysgen.trajectory.limits import Limits
from hysgen.trajectory.plan import REACHED

TS_S = 2e-5
LAG = 0.97


def lag_model(blocks: tuple[InputBlock, ...], high_um: float = 20.0) -> Model:
    """One lag behind a path, 20 uniform rules that agree: the model of a stage whose rules add nothing."""
    grid = Grid(-high_um, high_um, 4)
    consequents = np.tile([LAG, 1.0 - LAG, 0.0], (4, 1))
    return Model("lag", TS_S, grid, consequents, -20.0, 120.0, blocks=blocks)


def smooth(rng: np.random.Generator, low_um: float, high_um: float, samples: int = 1500) -> np.ndarray:
    """A random sum of five sines inside a range; it begins and ends wherever the sines do."""
    t = np.arange(samples) / samples
    waves = sum(rng.normal() * np.sin(2.0 * np.pi * (rng.uniform(0.5, 8.0) * t + rng.uniform())) for _ in range(5))
    unit = (waves - waves.min()) / np.ptp(waves)
    return np.asarray(low_um + (high_um - low_um) * unit)


def test_a_loop_over_the_whole_range_stays_inside_it_to_the_last_bit() -> None:
    plan = hysgen.waveform("appendix_a", 2.0 + 0.5 * np.sin(0.0125 * np.arange(500)), loop=True)
    assert (plan.u_V.min(), plan.u_V.max()) == (-20.0, 120.0)
    model = hysgen.load_model("extended")
    plan = hysgen.waveform(model, "sine", hysgen.Form(0.3, 2.0, 100.0, 1), loop=True, slew_V_s=1e5)
    assert "slew" in plan.broken
    assert plan.u_V.min() >= model.u_min_V


def test_a_mode_that_rings_on_at_the_low_end_of_a_loop_is_not_stopped_there() -> None:
    """A voltage below the least would stop it at once; none there can, and it would ring into the reference."""
    hysteresis = next(block for block in hysgen.load_model("extended").blocks if block.kind == "hysteresis")
    model = lag_model((hysteresis, Modes((557.0,), (0.0066,), (1.02,), -TS_S / math.log(LAG))))
    plan = hysgen.waveform(model, np.full(500, float(model.simulate(np.full(4000, 50.0))[-1])), loop=True)
    assert plan.largest_um < 1e-9


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sets(st.sampled_from(["delay", "hysteresis", "creep", "modes", "structure"])))
def test_played_through_the_model_the_voltage_gives_the_reference(seed: int, names: set[str]) -> None:
    rng = np.random.default_rng(seed)
    chosen = sorted(names - ({"modes"} if "structure" in names else set()), key=lambda name: kinds()[name].place)
    blocks = [rng.choice(np.array(kinds()[name].examples(rng), dtype=object)) for name in chosen]
    lag_s = -TS_S / math.log(LAG)
    blocks = [dataclasses.replace(b, lag_s=lag_s) if hasattr(b, "lag_s") else b for b in blocks]
    model = lag_model(tuple(blocks), 400.0)
    low_um, high_um = (model.simulate(np.full(4000, u_V))[-1] for u_V in (20.0, 80.0))
    wanted = smooth(rng, min(low_um, high_um), max(low_um, high_um))
    plan = hysgen.waveform(model, wanted)
    played_um = model.simulate(plan.u_V)[plan.lead :]
    if plan.reached:
        assert np.abs(played_um - wanted).max() <= 1.01 * REACHED * np.ptp(wanted)
    else:
        # A delay of half a sample passes no quick changes, and light modes need voltages beyond the range.
        assert plan.broken or any(0.37 < getattr(b, "part", 0.0) < 0.63 for b in blocks)
        assert np.abs(played_um - wanted).max() == pytest.approx(plan.largest_um, rel=1e-6)


def test_a_stage_with_zeros_outside_the_circle_is_inverted_ahead_of_the_reference() -> None:
    block = Structure((900.0,), (0.03,), (0.6,), -TS_S / math.log(LAG), (0.3,), TS_S)
    assert block.zero(TS_S) > 1.1
    model = lag_model((block,), 120.0)
    plan = hysgen.waveform(model, "sine", hysgen.Form(amplitude_um=20.0, centre_um=50.0, f_Hz=100.0, periods=2))
    assert plan.reached
    assert plan.lead > 20
    before = np.abs(plan.u_V[: plan.lead] - plan.u_V[0])
    assert before[-1] > 1e-2 > 1e-6 > before[0]
    played_um = model.simulate(plan.u_V)[plan.lead :]
    assert np.abs(played_um - plan.reference.values).max() < 1e-8 * np.ptp(plan.reference.values)
    # The emitted inverse leaves the block out; in float32, 3e-7 of 50 um times 1/(1 - LAG) of the lag.
    asked = plan.asked_um.astype(np.float32)[:, None]
    inverse = Instance(model, asked[0], plan.u_V[:1].astype(np.float32))
    volts = [inverse.inverse(here, after)[0] for here, after in itertools.pairwise(asked)]
    assert np.abs(np.array(volts) - plan.u_V[:-1]).max() < 50.0 * 3e-7 / (1.0 - LAG)


def test_half_a_sample_of_delay_does_not_ring_through_modes() -> None:
    """The average of two samples has no inverse at half the sampling rate, which the inverse of modes asks most of."""
    lag_s = -TS_S / math.log(LAG)
    model = lag_model((Delay(1.494), Modes((617.0, 2319.0), (0.0075, 0.0138), (0.977, 0.0222), lag_s)), 120.0)
    for periodic, largest_um in ((False, 0.05), (True, 1e-3)):
        plan = hysgen.waveform(model, "sine", hysgen.Form(5.0, 50.0, 50.0, 2), periodic=periodic)
        played_um = model.simulate(np.tile(plan.u_V, 20 if periodic else 1))[-plan.reference.values.size :]
        assert np.abs(played_um - plan.reference.values).max() == pytest.approx(plan.largest_um)
        assert plan.largest_um < largest_um


@pytest.mark.slow
def test_a_period_of_the_steady_state_can_be_played_for_ever() -> None:
    model = hysgen.load_model("extended")
    model = dataclasses.replace(model, blocks=tuple(b for b in model.blocks if b.kind != "creep"), certificates={})
    plan = hysgen.waveform(model, "triangle", hysgen.Form(0.5, f_Hz=100.0, periods=1), periodic=True)
    assert (plan.reached, plan.u_V.size) == (True, 500)
    played_um = model.simulate(np.tile(plan.u_V, 40))[-500:]
    assert np.abs(played_um - plan.reference.values).max() < REACHED


@pytest.mark.slow
@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.1, 0.7), st.one_of(st.none(), st.floats(0.05, 0.3)), st.booleans())
def test_the_limits_hold_and_the_largest_error_is_the_least(
    seed: int, share: float, bend: float | None, rings: bool
) -> None:
    """Against HiGHS on the same programme of a linear stage, whose answer is the least for sure."""
    rng = np.random.default_rng(seed)
    block = Structure((900.0,), (0.03,), (0.6,), -TS_S / math.log(LAG), (0.0,), TS_S)
    model = lag_model((block,) if rings else (), 150.0)
    wanted = smooth(rng, 35.0, 65.0, 250)
    free = hysgen.waveform(model, wanted)
    assume(not free.broken)
    step_V = np.abs(np.diff(free.u_V)).max()
    slew, acceleration = share * step_V / TS_S, None if bend is None else bend * step_V / TS_S**2
    plan = hysgen.waveform(model, wanted, slew_V_s=slew, acceleration_V_s2=acceleration)
    limits = Limits(-20.0, 120.0, slew, acceleration)
    assert limits.broken(plan.u_V, TS_S) == ()
    assert "slew" in plan.broken
    assert plan.clipped_um is not None
    # The mean square stands beside the largest error in what is made least.
    assert plan.largest_um <= 1.01 * plan.clipped_um
    least_um = least_largest_error(model, plan.lead, wanted, limits, float(plan.u_V[0]))
    assert plan.largest_um <= 1.03 * least_um + 1e-6


def test_steps_beyond_a_hysteresis_and_a_mode_are_better_than_by_the_emitted_inverse() -> None:
    hysteresis = next(block for block in hysgen.load_model("extended").blocks if block.kind == "hysteresis")
    model = lag_model((hysteresis, Structure((800.0,), (0.01,), (1.05,), -TS_S / math.log(LAG), (0.0,), TS_S)))
    low_um, high_um = (model.simulate(np.full(4000, u_V))[-1] for u_V in (30.0, 45.0))
    wanted = np.repeat([low_um, 0.8 * low_um + 0.2 * high_um], 200)
    plan = hysgen.waveform(model, wanted)
    assert plan.broken == ("voltage",)
    still = dataclasses.replace(model, blocks=(hysteresis,))
    emitted_um = model.simulate(hysgen.waveform(still, wanted).u_V)[1:401]
    assert plan.rms_um < 0.5 * float(np.sqrt(np.mean((emitted_um - wanted) ** 2)))


def least_largest_error(model: Model, lead: int, wanted: np.ndarray, limits: Limits, first_V: float) -> float:
    """min over u of max |y - r| of a linear model, from rest under u(0), by linear programming."""
    course = np.concatenate([np.full(lead, wanted[0]), wanted])
    n = course.size - 1
    impulse = model.simulate(np.concatenate([[0.0, 1.0], np.zeros(n)]), 0.0)[2:]
    steps = toeplitz(impulse, np.zeros(n))
    rest = (1.0 - np.cumsum(impulse)) * first_V
    one_t = np.ones((n, 1))
    rows = [np.hstack([steps, -one_t]), np.hstack([-steps, -one_t])]
    sides = [course[1:] - rest, rest - course[1:]]
    change = np.eye(n) - np.eye(n, k=-1)
    change[0] = 0.0
    for order, limit in enumerate((limits.slew_V_s, limits.acceleration_V_s2), 1):
        if limit is not None:
            matrix = np.hstack([np.linalg.matrix_power(change, order)[1:], 0.0 * one_t[1:]])
            rows += [matrix, -matrix]
            sides += [np.full(n - 1, limit * TS_S**order)] * 2
    bounds = [(first_V, first_V), *[(limits.low_V, limits.high_V)] * (n - 1), (0.0, None)]
    cost = np.append(np.zeros(n), 1.0)
    answer = linprog(cost, sparse.csr_matrix(np.vstack(rows)), np.concatenate(sides), bounds=bounds)
    return float(answer.fun)


@pytest.mark.slow
def test_what_cannot_be_reached_is_said_with_place_and_amount(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    t = np.arange(0.0, 0.04, 1e-4)
    pulse = 1.5 + 2.0 * np.exp(-(((t - 0.02) / 2e-3) ** 2))
    Path("high.csv").write_text(
        "t_ms,x_nm\n" + "".join(f"{1e3 * a},{1e3 * b}\n" for a, b in zip(t, pulse, strict=True))
    )
    assert main(["waveform", "extended", "high.csv", "-o", "u.csv", "--json", "u.json", "--plot", "u.png"]) == 1
    said = capsys.readouterr().out
    assert "CANNOT be reached for the limit of voltage: missed by up to" in said
    assert "a sample every 0.0001 s; the model steps every 2e-05 s" in said
    plan = hysgen.waveform("extended", "high.csv")
    (a, b), *_ = sorted(plan.spans_s, key=lambda span: span[0] - span[1])
    assert a < 0.02 < b
    assert plan.u_V.max() <= 56.0
    assert main(["simulate", "extended", "u.csv", "-o", "y.csv"]) == 0
    time_s, y_um = np.loadtxt("y.csv", delimiter=",", skiprows=1).T
    assert np.abs(y_um[plan.lead :] - plan.y_um).max() < 1e-9
    assert (time_s[0], time_s[plan.lead]) == pytest.approx((plan.start_s, 0.0))


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["nothing.csv"], "nothing.csv: there is no such file"),
        (["sine", "--frequency", "9000"], "sine: 9000 Hz leaves fewer than 10 samples a period"),
        (["sine", "--voltage", "60", "90"], "voltage: 60 .. 56 V lies outside the model's 22 .. 56 V"),
        (["back.csv"], "back.csv: row 2: the time does not rise"),
        (["hole.csv"], "hole.csv: "),
    ],
)
def test_an_error_is_one_line(
    words: list[str], line: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("back.csv").write_text("time_s,displacement_um\n0,1\n1,2\n0.5,3\n")
    Path("hole.csv").write_text("time_s,displacement_um\n0,1\n1,nan\n2,3\n")
    assert main(["waveform", "extended", *words]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"hysgen waveform: {line}")
    assert said.count("\n") == 1


def test_a_voltage_of_no_numbers_is_refused() -> None:
    with pytest.raises(HysgenError, match="voltage: index 1 is nan"):
        hysgen.simulate("extended", [30.0, math.nan, 31.0])
