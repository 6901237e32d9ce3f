"""Slow and endless states in generated float32 C: creep against float64 over 1e7 samples, phases over 1e8."""

import dataclasses
from fractions import Fraction

import numpy as np
import pytest

from hysgen.checking import Host
from hysgen.codegen import Options, generate
from hysgen.machine.kernels.operators import lag_states, mode_states
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.model import Grid, Model
from hysgen.model.path import InputBlock
from hysgen.model.path.creep import Creep
from hysgen.model.path.modes import Modes

TS_S = 2e-5
CHUNK = 1_000_000


def flat(*blocks: InputBlock) -> Model:
    """Two equal rules that leave y where it is, so that a prediction shows the path alone."""
    rules = np.tile([0.0, 1e-3, 0.0], (2, 1))
    return Model("flat", TS_S, Grid(-1.0, 1.0, 2), rules, -200.0, 200.0, blocks=blocks)


def chunk_of_input(number: int) -> np.ndarray[tuple[int], np.dtype[np.float32]]:
    """20 s of an input that wanders: a level that changes every 4 s, a 3 Hz sine and a little noise."""
    rng = np.random.default_rng(number)
    level = np.repeat(rng.uniform(-50, 150, 5), CHUNK // 5)
    t = TS_S * (number * CHUNK + np.arange(CHUNK))
    return (level + 20 * np.sin(2 * np.pi * 3 * t) + rng.normal(0, 0.05, CHUNK)).astype(np.float32)


@pytest.mark.slow
def test_creep_of_10_s_at_50_khz_is_right_over_1e7_samples() -> None:
    block = Creep(0.01, (10.0, 1000.0))
    model = flat(block)
    host = Host(model.name, generate(model, Options(inverse=False)))
    first = chunk_of_input(0)
    struct, truth = host.instance(0.0, first[0]), np.full(2, float(first[0]))
    at = host.layout("flat_t")["inputs.creep.high[0]"]
    worst = swing = 0.0
    for number in range(10):
        u = chunk_of_input(number)
        _, trace = host.run("simulate", struct, [u.view(np.uint32)], first=at, words=2)
        states = lag_states(u.astype(np.float64), block.rates(TS_S), truth)
        truth = states[-1] + block.rates(TS_S) * (float(u[-1]) - states[-1])
        worst = max(worst, np.abs(trace[:-1].view(np.float32) - states[1:]).max())
        swing = max(swing, np.ptp(states[:, 0]))
    # One float would stand still wherever |u - s| < 2^-24 |s| tau/Ts, 3 V of 100 V at 10 s. Two leave half the last bit
    # of `high`, 2^-24 of 128 V, and the 2^-25 by which the rate is rounded, of |u - s| below 150 V: 1.2e-5 V.
    assert swing > 50
    assert worst < 1.2e-5


def test_a_light_slow_mode_is_right_over_1e6_samples() -> None:
    block = Modes((2.0,), (0.01,), (0.3,), 4e-4)
    model = flat(block)
    host = Host(model.name, generate(model, Options(inverse=False)))
    u = chunk_of_input(3)
    struct = host.instance(0.0, u[0])
    layout = host.layout("flat_t")
    position = layout["inputs.modes.position[0]"]
    _, trace = host.run("simulate", struct, [u.view(np.uint32)], first=position, words=4)
    truth = mode_states(u.astype(np.float64), block.steps(TS_S), np.array([float(u[0]), 0.0]))
    error = np.abs(trace[:-1, [0, 2]].view(np.float32) - truth[1:]).max()
    # f/fs = 4e-5. The pole's rounding, 6e-8 of its distance from 1, turns into 1/zeta = 100 times that of the motion.
    assert error < 100 * 2.0**-24 * np.abs(truth).max()


@pytest.mark.slow
def test_modes_are_right_from_slow_to_nearly_half_the_sampling_frequency() -> None:
    block = Modes((5.0, 50.0, 500.0, 5000.0, 20_000.0), (0.01, 0.02, 0.01, 0.3, 0.01), (0.1,) * 5, 4e-4)
    model = flat(block)
    host = Host(model.name, generate(model, Options(inverse=False)))
    u = chunk_of_input(5)[:200_000]
    struct = host.instance(0.0, u[0])
    layout = host.layout("flat_t")
    first = layout["inputs.modes.position[0]"]
    _, trace = host.run("simulate", struct, [u.view(np.uint32)], first=first, words=20)
    truth = mode_states(u.astype(np.float64), block.steps(TS_S), block.start(float(u[0])))
    single = trace[:-1].view(np.float32)
    for j, zeta in enumerate(block.zeta):
        for part, column in ((0, j), (1, 10 + j)):
            motion = truth[1:, 2 * j + part]
            error = np.abs(single[:, column] - motion).max()
            assert error < (2 + 1 / zeta) * 2.0**-24 * np.abs(truth[:, 2 * j]).max()


@pytest.mark.parametrize("samples", [10**7, pytest.param(10**8, marks=[pytest.mark.slow, pytest.mark.proof])])
@pytest.mark.slow
def test_amplitude_and_phase_do_not_drift_over_long_runs(samples: int) -> None:
    f_Hz, look = 49.9873, 500_000
    model = dataclasses.replace(flat(), terms=(Periodic((f_Hz,)),), weights=np.array([1.0, 0.0]))
    host = Host(model.name, generate(model, Options(inverse=False)))
    struct = host.instance(0.0, 0.0)
    rest = np.zeros(CHUNK, dtype=np.uint32)
    for _ in range((samples - look) // CHUNK):
        host.run("simulate", struct, [rest])
    out, _ = host.run("simulate", struct, [rest[: samples - (samples - look) // CHUNK * CHUNK]])
    seen = out.view(np.float32)[-look:].astype(np.float64)
    start = (Fraction(f_Hz) * Fraction(TS_S) * (samples - look)) % 1
    angle = 2 * np.pi * (float(start) + f_Hz * TS_S * np.arange(look))
    basis = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    in_phase, quadrature = np.linalg.lstsq(basis, seen, rcond=None)[0]
    # The sine's claim is 1.9e-7 at any one sample; a phase is worth as much.
    assert abs(np.hypot(in_phase, quadrature) - 1.0) < 1.9e-7
    assert abs(np.arctan2(quadrature, in_phase)) < 1.9e-7
    assert np.abs(seen - np.cos(angle)).max() < 3e-7
