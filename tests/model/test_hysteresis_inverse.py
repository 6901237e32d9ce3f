"""Inverse of the hysteresis block: Newton steps, what they leave, jumps, the ends of the range."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from fixtures.generated_models import hysteresis
from fixtures.hysteresis_blocks import (
    TS_S,
    Compiled,
    Floats32,
    by_block,
    falling,
    operator,
    sine_um,
    voltages,
    with_memory,
)
from hysgen.model.file import load_model
from hysgen.model.intervals import Interval
from hysgen.model.path.base import TOLERANCE
from hysgen.model.path.hysteresis import Hysteresis

RESIDUAL_UM = 4e-6
"""What float32 leaves of the inverse: h rounds by 1e-6 um, and the voltage, at 120 V, by 4e-6 V times 0.1 um/V."""


def kinked() -> Hysteresis:
    """Four wide plays that take over most of the slope one after the other, with short decay lengths."""
    plays = (1.1, 0.05, 0.02) * 4
    return Hysteresis(-20.0, 120.0, (4.0, 1.6, 0.2, 0.05), (0.05, 0.3, 0.55, 0.85), plays, 0.37, (0.2, 0.1, 0.15, 0.05))


def jumps(block: Hysteresis, count: int) -> Floats32:
    """Independent voltages of the whole range, and jumps of a third to a thousandth of it."""
    rng = np.random.default_rng(5)
    far = rng.uniform(block.low_V, block.high_V, count)
    near = far[: count // 2] + rng.choice([45.0, 4.0, 0.4, 0.04], count // 2) * rng.normal(size=count // 2)
    return np.clip(
        np.concatenate([np.column_stack([far[: count // 2], near]).ravel(), far[count // 2 :]]), -20, 120
    ).astype(np.float32)


@pytest.mark.parametrize(
    ("block", "count"),
    [
        (operator(12, 2), 1_000_000),
        (hysteresis(12, 2), 1_000_000),
        *((block, 200_000) for block in (operator(), falling(), kinked())),
    ],
)
@pytest.mark.slow
def test_the_inverse_meets_random_jumps(block: Hysteresis, count: int) -> None:
    """Issue 16: 1e-5 um of a stroke of 10 um."""
    v = jumps(block, count)
    wanted, _ = Compiled(block, float(v[0])).apply(v)
    _, reached, _ = Compiled(block, float(v[0])).follow(wanted)
    assert np.abs(reached - wanted).max() <= 1e-5


def test_the_steps_of_the_inverse_are_as_many_as_the_block_needs() -> None:
    assert operator(0, 0).steps == 3
    block = kinked()
    assert block.steps > 3
    v = jumps(block, 20_000)
    fewer = Compiled(block, float(v[0]), alter=(f"step < {block.steps}u", "step < 3u"))
    wanted, _ = Compiled(block, float(v[0])).apply(v)
    _, reached, _ = fewer.follow(wanted)
    assert np.abs(reached - wanted).max() > 1e-5


def scaled(block: Hysteresis, factor: float) -> Hysteresis:
    """`factor` times the output."""
    parts = {name: tuple(factor * x for x in getattr(block, name)) for name in ("curve_um", "plays_um", "duhem_um")}
    return dataclasses.replace(block, **parts)


def shipped() -> Hysteresis:
    """The hysteresis of the model `extended`, 2.8 um."""
    return next(block for block in load_model("extended").blocks if isinstance(block, Hysteresis))


@pytest.mark.parametrize("factor", [0.02, 0.2, 1.0, 20.0])
@pytest.mark.parametrize("source", [shipped, kinked])
def test_random_jumps_leave_less_than_what_sets_the_status_bit(source: Callable[[], Hysteresis], factor: float) -> None:
    """The limit of the status bit is a part of the range of w, whatever the range: 5e-6 um set it below 5.2 um."""
    block, lanes = scaled(source(), factor), 20_000
    rng = np.random.default_rng(3)
    v = rng.uniform(block.low_V, block.high_V, (11, lanes)).astype(np.float32)
    forward, inverse = (block.mirror(v[0], TS_S) for _ in range(2))
    worst = 0.0
    for jump in v[1:]:
        wanted = forward.apply(jump)
        reached = inverse.apply(inverse.solve(wanted))
        forward.restore([word.view(np.uint32) for word in inverse.state()])
        worst = max(worst, float(np.abs(reached - wanted).max()))
    assert worst <= TOLERANCE * block.image(Interval(block.low_V, block.high_V)).width


@by_block
@pytest.mark.parametrize(("rate_Hz", "samples"), [(50_000.0, 200_000), (2_000.0, 100_000)])
def test_the_inverse_follows_a_reference(block: Hysteresis, rate_Hz: float, samples: int) -> None:
    """100 Hz, 500 and 20 samples a period."""
    wanted = sine_um(block, rate_Hz, samples)
    start = 0.5 * (block.low_V + block.high_V)
    _, reached, _ = Compiled(block, start).follow(wanted)
    # The inverse starts elsewhere than the plant did, so its memory differs; what it is asked for, it finds.
    assert np.abs(reached - wanted)[100:].max() < RESIDUAL_UM


@with_memory
def test_the_inverse_finds_jumps_over_the_whole_range(block: Hysteresis) -> None:
    """A million displacements drawn at random: the last Newton step leaves more than the roundings in 0.1 % of them."""
    v = voltages(block, 1_000_000, seed=7)
    v = np.random.default_rng(5).permutation(v)
    h, _ = Compiled(block, float(v[0])).apply(v)
    _, reached, _ = Compiled(block, float(v[0])).follow(h)
    late = np.abs(reached - h)
    assert np.quantile(late, 0.999) < RESIDUAL_UM
    assert late.max() < 1e-4


@with_memory
def test_the_inverse_goes_to_the_end_of_the_range_for_what_lies_beyond(block: Hysteresis) -> None:
    compiled = Compiled(block, 50.0)
    v, _, _ = compiled.follow(np.array([1e3, 1e3, -1e3, -1e3], np.float32))
    assert v.tolist() == [120.0, 120.0, -20.0, -20.0]
