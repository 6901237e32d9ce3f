"""Hysteresis block: float64 against plain Python, mirror against float64, C against mirror."""

import functools
import math
from typing import Any

import numpy as np
import pytest

from fixtures.hysteresis_blocks import (
    BLOCKS,
    TOOLCHAINS,
    TS_S,
    Compiled,
    advanced,
    by_block,
    model_of,
    operator,
    voltages,
    with_memory,
    words,
)
from fixtures.tools import need
from hysgen.checking.proof.static import wall
from hysgen.codegen import Options, generate
from hysgen.machine.native import Toolchain
from hysgen.model.path.hysteresis import Hysteresis

ERROR_UM = 5e-6
"""Worst distance of float32 from float64 for a stroke of 10 um, whose last bit is 9.5e-7 um: twenty terms are rounded,
and x, 1.2e-7 of the half range off, is multiplied by a slope of up to 11 um."""

QUICK = ("usual", "relaxing plays alone")


class Plainly:
    """The equations of the block one by one, in Python numbers."""

    def __init__(self, block: Hysteresis, v_V: float) -> None:
        self.block = block
        self.last = self.normalised(v_V)
        self.z = [min(max(self.last, r - 1.0), 1.0 - r) for r in block.half_widths]
        self.d = [0.0] * block.states

    def normalised(self, v_V: float) -> float:
        x = (2.0 * v_V - self.block.high_V - self.block.low_V) / (self.block.high_V - self.block.low_V)
        return min(max(x, -1.0), 1.0)

    def relaxed(self, z: float, x: float, r: float, s: float) -> float:
        a = max((r - abs(x - z)) / s, 0.0)
        end = min(1.0, 1.0 - r + 8.0 * s)
        step = s * math.exp(-a * (1.0 + a / 32.0)) if a <= 15.0 else 0.0
        return min(max(z + math.copysign(step, x - z), -end), end)

    def apply(self, v_V: float) -> float:
        block, x = self.block, self.normalised(v_V)
        h = sum(a * math.cos(m * math.acos(x)) for m, a in enumerate(block.curve_um))
        for j, r in enumerate(block.half_widths):
            self.z[j] = max(x - r, min(x + r, self.z[j]))
            row = block.plays_um[j * block.degree : (j + 1) * block.degree]
            h += sum(a * math.cos(m * math.acos(self.z[j])) for m, a in enumerate(row, 1))
            if block.relaxation:
                self.z[j] = self.relaxed(self.z[j], x, r, block.relaxation * r)
        for i in range(block.states):
            end = math.copysign(1.0, x - self.last) if x != self.last else self.d[i]
            self.d[i] = end + (self.d[i] - end) * math.exp(-abs(x - self.last) * 2.0**i / block.reach)
            b, c = block.duhem_um[2 * i : 2 * i + 2]
            h += b * self.d[i] + c * self.d[i] * abs(self.d[i])
        self.last = x
        return h


@by_block
def test_float64_agrees_with_the_equations_in_plain_python(block: Hysteresis) -> None:
    v = voltages(block, 3000).astype(np.float64)
    slow = Plainly(block, float(v[0]))
    # acos loses half the digits at the ends of the range.
    assert block.apply(v, TS_S) == pytest.approx(np.array([slow.apply(float(value)) for value in v]), abs=2e-7)


@pytest.mark.parametrize("toolchain", TOOLCHAINS, ids=str)
@pytest.mark.parametrize(
    "block",
    [pytest.param(BLOCKS[name], id=name, marks=() if name in QUICK else pytest.mark.slow) for name in BLOCKS],
)
def test_c_equals_the_mirror_bit_for_bit(block: Hysteresis, toolchain: Toolchain) -> None:
    need(toolchain.command)
    v, wanted, rest, ahead, back = mirrored(block)
    compiled = Compiled(block, float(v[0]), toolchain)
    assert rest.tobytes() == np.float32(compiled.rest).tobytes()
    h, trace = compiled.apply(v, traced=True)
    assert h.tobytes() == ahead[0].tobytes()
    assert np.array_equal(trace, ahead[1])
    solved, reached, trace = compiled.follow(wanted, traced=True)
    for got, expected in zip((solved, reached, trace), back, strict=True):
        assert got.tobytes() == expected.tobytes()


@functools.cache
def mirrored(block: Hysteresis) -> tuple[Any, ...]:
    """Voltages and wanted outputs, (300,), and what the mirror makes of them: rest, (outputs, states) along the
    voltages, then (voltages, outputs, states) along the wanted outputs, the last of which lie beyond the range."""
    n, v = 300, voltages(block, 300)
    mirror = block.mirror(v[:1], TS_S)
    rest = mirror.rest()
    rows = [(mirror.apply(v[k : k + 1]), words(mirror)) for k in range(n)]
    h, states = np.concatenate([out for out, _ in rows]), np.stack([row for _, row in rows])
    middle = 0.5 * (float(h.min()) + float(h.max()))
    wanted = np.concatenate([h[: n // 2], np.float32(middle) + np.float32(1.5) * (h[n // 2 :] - np.float32(middle))])
    found = [advanced(mirror, wanted[k : k + 1]) for k in range(n)]
    solved, reached = (np.concatenate([row[i] for row in found]) for i in (0, 1))
    return v, wanted, rest, (h, states), (solved, reached, np.stack([row[2] for row in found]))


@pytest.mark.parametrize("name", ["curve", "one play of degree 1", "states without plays", "usual", "relaxing"])
@pytest.mark.slow
def test_the_c_compiles_without_a_warning(name: str) -> None:
    """One block of each text of the C; the others differ in numbers and sizes of tables."""
    block = BLOCKS[name]
    for inverse in (True, False):
        found = wall("stage", generate(model_of(block), Options(inverse=inverse)))
        assert found.clean, "\n".join(found.lines())


@with_memory
def test_an_operation_that_differs_is_seen_in_the_bits(block: Hysteresis) -> None:
    v = voltages(block, 300)
    h, _ = Compiled(block, float(v[0])).apply(v)
    for alter in (
        ("const float high = x + r;", "const float high = x + 1.0000001f * r;"),
        ("? -1.0f : 1.0f", "? -1.0f : 0.9999999f"),
    ):
        altered, _ = Compiled(block, float(v[0]), alter=alter).apply(v)
        assert (altered != h).any()


def test_lanes_are_independent() -> None:
    block = operator()
    lanes = np.stack([voltages(block, 200, seed) for seed in range(5)])
    together = block.mirror(lanes[:, 0], TS_S)
    outs = np.stack([together.apply(lanes[:, k]) for k in range(200)], axis=1)
    solved = together.solve(outs[:, 100])
    for lane in range(5):
        alone = block.mirror(lanes[lane, :1], TS_S)
        assert np.array_equal([alone.apply(lanes[lane, k : k + 1])[0] for k in range(200)], outs[lane])
        assert alone.solve(outs[lane, 100:101])[0] == solved[lane]


@with_memory
def test_float32_stays_near_float64_over_a_million_samples(block: Hysteresis) -> None:
    v = voltages(block, 1_000_000)
    h, _ = Compiled(block, float(v[0])).apply(v)
    assert np.abs(h - block.apply(v.astype(np.float64), TS_S)).max() < ERROR_UM


@with_memory
def test_slow_motion_does_not_lose_the_duhem_states(block: Hysteresis) -> None:
    """0.06 V/s at 50 kHz: x moves by 1.7e-8 of the half range in a sample, a quarter of the last bit of 1 - e."""
    k = np.arange(600_000)
    v = (30.0 + 1.2e-6 * np.minimum(k, 600_000 - k)).astype(np.float32)
    h, _ = Compiled(block, float(v[0])).apply(v)
    exact = block.apply(v.astype(np.float64), TS_S)
    assert np.abs(h - exact).max() < ERROR_UM
    # The recursion d <- e d + (1 - e) side in float32, of the shortest reach, along the rising half.
    d, last, per_reach = np.float32(0.0), v[0], np.float32(1.0 / (70.0 * block.reaches[-1]))
    for value in np.unique(v):
        e = np.exp(-(value - last) * per_reach)
        d, last = e * d + (np.float32(1.0) - e), value
    way = float(v.max() - v.min()) / 70.0 / block.reaches[-1]
    assert abs(float(d) + math.expm1(-way)) > 1e-4


@by_block
def test_rest_is_the_output_under_the_same_input(block: Hysteresis) -> None:
    v = np.array([block.low_V, 0.0, 7.25, block.high_V], np.float32)
    if block.relaxes:  # A play near the end of the range relaxes.
        v = np.array([50.0, 55.0], np.float32)
    mirror = block.mirror(v, TS_S)
    rest = mirror.rest()
    assert all(mirror.apply(v).tobytes() == rest.tobytes() for _ in range(3))
    assert np.abs(rest - [block.apply(np.array([float(x)]), TS_S)[0] for x in v]).max() < ERROR_UM


@pytest.mark.slow
def test_relaxing_plays_creep_with_the_logarithm_of_time_in_float32_too() -> None:
    """A play of half-width 0.3 and s = 0.009, held for 1e7 samples: its last steps are far below the last bit of z."""
    block = Hysteresis(-20.0, 120.0, (5.0, 4.0), (0.3,), (1.0,), relaxation=0.03)
    v = np.full(10_000_000, 106.0, np.float32)  # x = 0.8: the play rests at 0.7, and is pulled from 0
    v[0] = 50.0
    h, _ = Compiled(block, 50.0).apply(v)
    exact = block.apply(v.astype(np.float64), TS_S)
    assert np.abs(h - exact).max() < ERROR_UM
    decades = np.diff(exact[10 ** np.arange(1, 8) - 1])
    # Without the curvature of the barrier, s ln 10 = 0.0207 per decade; with it 1 + a/16 times less.
    assert (decades > 0.01).all()
    assert (decades < 0.0208).all()


def test_the_threshold_of_relaxing_plays_grows_with_the_rate() -> None:
    """The opening of a loop at 1e4 and 1e6 samples a period differs by s ln 100, less the curvature of the barrier."""
    block = Hysteresis(-20.0, 120.0, (0.0, 1e-9), (0.3,), (1.0,), relaxation=0.03)
    opening = {}
    for samples in (10_000, 1_000_000):
        v = 50.0 + 63.0 * np.sin(2 * np.pi * np.arange(2 * samples) / samples)
        play = block.apply(v, TS_S)[samples:]
        opening[samples] = float(np.abs(play[np.abs(v[samples:] - 50.0) < 2.0]).mean())
    assert 0.6 < (opening[10_000] - opening[1_000_000]) / (0.009 * math.log(100)) < 1.0
