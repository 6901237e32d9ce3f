"""Blocks of a long record stand for the record: same columns of the chain, all levels and rates, bounded length."""

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

from hysgen.diagnosis.causes import Residual, causes
from hysgen.diagnosis.causes.aging import AgingPart
from hysgen.diagnosis.causes.creep import CreepPart
from hysgen.diagnosis.causes.drift import DriftPart
from hysgen.diagnosis.excerpt import BLOCKS, LONG, MOST_SAMPLES, remembered
from hysgen.diagnosis.excerpt import excerpt as chosen_excerpt
from hysgen.diagnosis.probe import Chain, Operator, Part, Scene, Trace, linear_fit
from hysgen.machine.kernels.operators import play_operators
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.path.limits import Saturation, Slew
from hysgen_lab.studies.bank.scenario import good

SAMPLES, TS_S = 120_000, 1e-3

COARSE = 3e-3
"""Largest rms error of a column in a coarse run: a limit begins to act between two of its samples."""


def long_scene(u_V: NDArray[np.float64], y_um: NDArray[np.float64] | None = None) -> Scene:
    run = Trace(u_V, np.zeros(len(u_V)) if y_um is None else y_um, {})
    return Scene((run,), TS_S, np.arange(900, len(u_V) - 2), Operator(float(u_V.min()), float(u_V.max())))


def excerpt(scene: Scene, lag: float) -> Scene:
    return chosen_excerpt(scene, lag, lambda: np.concatenate([run.y_um for run in scene.runs]))


@pytest.fixture(scope="module")
def whole() -> Scene:
    return long_scene(good(np.random.default_rng(3), SAMPLES, 0.0, 100.0))


@pytest.mark.parametrize(
    ("parts", "share"),
    [
        # The plays of a block start exactly; the Duhem states forget what the latest turning points do not hold.
        ((), 1e-6),
        ((Saturation(high_V=90.0),), 1e-6),
        # Creep of the past is an average over 1500 intervals.
        ((CreepPart(0.02, 0.05),), 6e-4),
        ((AgingPart(1e-3), DriftPart(), Periodic((50.3,))), 1e-6),
        ((Slew(4000.0, 4000.0),), 1e-6),
    ],
)
def test_columns_of_a_block_are_those_of_the_whole_record(whole: Scene, parts: tuple[Part, ...], share: float) -> None:
    blocks, chain = excerpt(whole, 3.0), Chain(3e-3, parts)
    all_rows = whole.columns(chain)
    seen, first = blocks.columns(chain), 0
    for run in blocks.runs:
        n = len(run.u_V)
        fitted = blocks.rows[(blocks.rows >= first) & (blocks.rows < first + n)]
        sample = np.round(blocks.time_s[fitted] / TS_S).astype(int)
        wrong = seen[:, fitted] - all_rows[:, sample]
        assert np.abs(wrong).max() < share if run.stride == 1 else np.sqrt((wrong**2).mean(axis=1)).max() < COARSE
        first += n


def test_blocks_are_bounded_and_hold_every_level_and_the_ends_of_the_record(whole: Scene) -> None:
    blocks = excerpt(whole, 3.0)
    assert blocks.samples <= MOST_SAMPLES
    assert blocks.span_s == whole.span_s
    u_V = np.concatenate([run.u_V for run in blocks.runs])[blocks.rows]
    levels = np.histogram(u_V, 20, (0.0, 100.0))[0]
    assert levels.min() > 0
    time_s = blocks.time_s[blocks.rows]
    assert time_s[0] < 0.06 * whole.span_s
    assert time_s[-1] > 0.99 * whole.span_s - 1.0


def test_a_rare_fast_step_is_in_a_block() -> None:
    u_V = 50.0 + 45.0 * np.sin(np.arange(SAMPLES) / 3000.0)
    u_V[41_000:41_400] = 20.0
    blocks = excerpt(long_scene(u_V), 3.0)
    rates = np.concatenate([np.abs(np.diff(run.u_V)) for run in blocks.runs])
    assert rates.max() == np.abs(np.diff(u_V)).max()


def test_a_short_record_is_its_own_excerpt() -> None:
    short = long_scene(good(np.random.default_rng(3), LONG, 0.0, 100.0))
    assert excerpt(short, 3.0) is short


def test_a_record_of_several_drives_is_searched_whole_and_one_beside_a_temperature_is_not(whole: Scene) -> None:
    rng = np.random.default_rng(5)
    temperature = 20.0 + np.cumsum(rng.normal(size=SAMPLES)) / 1e3
    for channel, same in ((rng.uniform(-1.0, 1.0, SAMPLES), True), (temperature, False)):
        run = dataclasses.replace(whole.runs[0], aux={"other": channel})
        scene = dataclasses.replace(whole, runs=(run,))
        assert (excerpt(scene, 3.0) is scene) == same


def test_a_slow_lag_makes_the_blocks_longer(whole: Scene) -> None:
    slow = excerpt(whole, 400.0)
    assert min(len(run.u_V) for run in slow.runs) > MOST_SAMPLES // BLOCKS
    assert len(slow.rows) > 0


def test_plays_end_where_the_whole_command_leaves_them() -> None:
    u_V = np.random.default_rng(5).normal(size=20_000).cumsum()
    width = np.geomspace(1.0, 200.0, 30)
    extremes = u_V[np.append(remembered(u_V), len(u_V) - 1)]
    ends = [play_operators(path, width, np.full(30, path[0]))[-1] for path in (u_V, extremes)]
    reached = np.ptp(u_V) > 2.0 * width  # a wider play still depends on where it began
    np.testing.assert_allclose(ends[1][reached], ends[0][reached], atol=1e-9)


def test_amounts_of_a_long_record_are_those_of_its_blocks(whole: Scene) -> None:
    """Aging, drift and a line that the whole record holds, found from a tenth of its samples."""
    chain = Chain(3e-3, (DriftPart(), Periodic((50.3,))))
    rng = np.random.default_rng(6)
    weights = np.zeros(len(whole.added_columns(chain)) + whole.hysteresis_size(chain))
    weights[0], weights[-3:] = 5.0, (0.02, 0.01, -0.03)
    y_um = weights @ whole.columns(chain) + 1e-3 * rng.normal(size=SAMPLES)
    blocks = excerpt(long_scene(whole.runs[0].u_V, y_um), 3.0)
    np.testing.assert_allclose(linear_fit(blocks, chain).weights[-3:], weights[-3:], atol=3e-4)


def test_extremes_of_long_ago_are_remembered_behind_thousands_of_small_turns() -> None:
    rng = np.random.default_rng(7)
    u_V = 50.0 + np.abs(np.arange(SAMPLES) % 14 - 7.0) / 5.0
    u_V[:5000] = np.interp(np.arange(5000), np.linspace(0, 4999, 40), 50.0 + rng.uniform(-50.0, 50.0, 40))
    whole, chain = long_scene(u_V), Chain(3e-3)
    blocks = excerpt(whole, 3.0)
    sample = np.round(blocks.time_s[blocks.rows] / TS_S).astype(int)
    plays = slice(0, 27)  # the Duhem states forget along the path
    np.testing.assert_allclose(
        blocks.columns(chain)[plays, blocks.rows], whole.columns(chain)[plays, sample], atol=1e-9
    )


def test_blocks_prefer_steps_to_slow_movement() -> None:
    at = np.arange(SAMPLES)
    u_V = 50.0 + 40.0 * np.sin(at / 3000.0)
    steps = np.array([7_300, 21_700, 28_900, 46_100])
    for place, size in zip(steps.tolist(), (5.0, 8.0, -6.0, 9.0), strict=True):
        u_V[place : place + 60] += size
    blocks = excerpt(long_scene(u_V), 3.0)
    seen = np.round(blocks.time_s[: sum(len(run.u_V) for run in blocks.runs if run.stride == 1)] / TS_S)
    assert np.isin(steps, seen).sum() >= 3


def test_a_small_chirp_that_rings_a_mode_is_in_a_block(whole: Scene) -> None:
    """What is left is large and slow everywhere, jumps once, and rings in one place, where the command is calm."""
    at = np.arange(SAMPLES)
    left_um = 0.5 * np.sin(at / 5000.0) + 0.4 * (at > 90_000)
    rings = slice(52_000, 56_000)
    left_um[rings] += 0.05 * np.sin(2.1 * at[rings])
    u_V = whole.runs[0].u_V.copy()
    u_V[50_000:58_000] = np.linspace(u_V[50_000], u_V[58_000], 8000)
    blocks = excerpt(long_scene(u_V, left_um), 3.0)
    seen = np.round(blocks.time_s[: sum(len(run.u_V) for run in blocks.runs if run.stride == 1)] / TS_S)
    assert np.isin(at[rings], seen).sum() > 800


def test_the_lines_of_a_long_record_are_proposed_from_its_blocks(whole: Scene) -> None:
    time_s = TS_S * np.arange(SAMPLES)
    y_um = 0.1 * whole.runs[0].u_V + 1e-3 * np.random.default_rng(8).normal(size=SAMPLES)
    y_um += 0.010 * np.sin(2.0 * np.pi * 50.3 * time_s) + 0.004 * np.sin(2.0 * np.pi * 120.1 * time_s)
    blocks = excerpt(long_scene(whole.runs[0].u_V, y_um), 3.0)
    for parts, line_Hz in (((), 50.3), ((Periodic((50.3,)),), 120.1)):
        first = causes()["periodic"].proposals(Residual(blocks, linear_fit(blocks, Chain(1e-4, parts))))[0]
        assert first.of(Periodic).f_Hz[-1] == pytest.approx(line_Hz, abs=0.1 / whole.span_s)
