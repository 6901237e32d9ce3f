"""Hysteresis block: float64 against plain Python, mirror against float64, C against mirror, inverse, box, refusals."""

from __future__ import annotations

import dataclasses
import functools
import math
import shutil
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.generated_models import hysteresis
from fixtures.tools import need
from hysgen.checking.proof.eva.calls import prove_call
from hysgen.checking.proof.warnings import wall
from hysgen.codegen import Options, generate
from hysgen.machine.native import Library, Toolchain, build
from hysgen.model.file import load_model
from hysgen.model.float32_constants import LEAST
from hysgen.model.intervals import Interval
from hysgen.model.model import Grid, Model
from hysgen.model.path import block_from_json
from hysgen.model.path.base import TOLERANCE, BlockBox
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.path.hysteresis_mirror import HysteresisMirror

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]

TS_S = 2e-5
ERROR_UM = 5e-6
"""Worst distance of float32 from float64 for a stroke of 10 um, whose last bit is 9.5e-7 um: twenty terms are rounded,
and x, 1.2e-7 of the half range off, is multiplied by a slope of up to 11 um."""
RESIDUAL_UM = 4e-6
"""What float32 leaves of the inverse: h rounds by 1e-6 um, and the voltage, at 120 V, by 4e-6 V times 0.1 um/V."""

TOOLCHAINS = [Toolchain("gcc", ("-O0",)), Toolchain("gcc", ("-O2",)), Toolchain("gcc", ("-O3",))]
TOOLCHAINS += [Toolchain("clang", ("-O2",)), Toolchain("clang", ("-O3",))]

DRIVER = """
#include "{name}_source.h"

#include <stddef.h>
#include <string.h>

float driver_init({type} *self, float v) {{ return {prefix}_init(self, v); }}
void driver_run({type} *self, size_t n, const float *wanted, int32_t solves, float *v, float *h, uint32_t *trace)
{{
    for (size_t i = 0; i < n; ++i) {{
        v[i] = solves ? {prefix}_solve(self, wanted[i]) : v[i];
        h[i] = {prefix}_apply(self, v[i]);
        if (trace) memcpy(trace + i * (sizeof *self / 4), self, sizeof *self);
    }}
}}
"""


def operator(plays: int = 8, states: int = 5, seed: int = 0) -> Hysteresis:
    """A rising operator with a stroke of 10 um over -20 .. 120 V, half-widths as the fit places them."""
    rng = np.random.default_rng(seed)
    r = (np.arange(1, plays + 1) / (plays + 1)) ** 1.5
    density = rng.uniform([0.8, -0.15, 0.0], [3.0, 0.15, 0.15], (plays, 3)) / max(plays, 1)
    duhem = rng.uniform(0.0, 0.08, (states, 2)) * 0.5 ** np.arange(states)[:, None]
    curve = (5.0, 4.0, 0.2, 0.1, 0.03, 0.02, 0.01, 0.005)
    plays_um = tuple(density.ravel().tolist())
    return Hysteresis(-20.0, 120.0, curve, tuple(r.tolist()), plays_um, 1.0, tuple(duhem.ravel().tolist()))


def falling() -> Hysteresis:
    """The same operator with the opposite sign."""
    block = operator()
    curve, plays, duhem = (tuple(-a for a in values) for values in (block.curve_um, block.plays_um, block.duhem_um))
    return dataclasses.replace(block, curve_um=curve, plays_um=plays, duhem_um=duhem)


BLOCKS = {
    "usual": operator(),
    "twelve plays": operator(12, 2),
    "five plays": operator(5, 0),
    "one play of degree 1": Hysteresis(-20.0, 120.0, (5.0, 4.0), (0.3,), (1.0,)),
    "plays above the curve's degree": Hysteresis(-20.0, 120.0, (5.0, 4.0), (0.1, 0.5), (0.5, 0.01, 0.02) * 2),
    "states without plays": operator(0, 2),
    "curve": operator(0, 0),
    "falling": falling(),
    "relaxing": dataclasses.replace(operator(6, 2), relaxation=0.03),
    "relaxing plays alone": dataclasses.replace(operator(3, 0), relaxation=0.0625),
    "symmetric range": dataclasses.replace(operator(), low_V=-70.0, high_V=70.0),
}
by_block = pytest.mark.parametrize("block", BLOCKS.values(), ids=BLOCKS.keys())
with_memory = pytest.mark.parametrize("block", [BLOCKS["usual"], BLOCKS["twelve plays"]], ids=["usual", "twelve plays"])


def model_of(block: Hysteresis, rules: int = 6) -> Model:
    """A lag behind the block."""
    y = np.sort([block.image(Interval(block.low_V, block.high_V)).low, 0.0, 11.0])
    consequents = np.tile([0.9, 0.1, 0.0], (rules, 1))
    return Model("stage", TS_S, Grid(y[0] - 1.0, y[-1], rules), consequents, block.low_V, block.high_V, blocks=(block,))


@functools.lru_cache(maxsize=16)
def texts_of(block: Hysteresis) -> dict[str, str]:
    return generate(model_of(block))


class Compiled:
    """The C of a block, at rest under v_V."""

    def __init__(self, block: Hysteresis, v_V: float, toolchain: Toolchain | None = None, alter: Any = None) -> None:
        self.library = library(block, toolchain, alter)
        self.words = sum(1 for member in block.members() for _ in member.words())
        self.struct = self.library.ffi.new("stage_hysteresis_t *")
        self.rest = self.library.lib.driver_init(self.struct, v_V)

    def apply(self, v_V: Floats32, *, traced: bool = False) -> tuple[Floats32, NDArray[np.uint32]]:
        """Outputs (n,), and (n, words) states if traced."""
        _, h, trace = self._run(v_V.copy(), np.zeros(0, np.float32), traced)
        return h, trace

    def follow(self, wanted_um: Floats32, *, traced: bool = False) -> tuple[Floats32, Floats32, NDArray[np.uint32]]:
        """Solved voltages (n,), the outputs that they lead to, and states."""
        return self._run(np.empty_like(wanted_um), wanted_um, traced)

    def _run(self, v: Floats32, wanted: Floats32, traced: bool) -> tuple[Floats32, Floats32, NDArray[np.uint32]]:
        ffi = self.library.ffi
        h, trace = np.empty_like(v), np.empty((v.size if traced else 0, self.words), np.uint32)
        given, solved, out = (ffi.from_buffer("float *", x) for x in (np.ascontiguousarray(wanted), v, h))
        recorded = ffi.from_buffer("uint32_t *", trace) if traced else ffi.NULL
        self.library.lib.driver_run(self.struct, v.size, given, int(wanted.size > 0), solved, out, recorded)
        return v, h, trace


@functools.lru_cache(maxsize=64)
def library(block: Hysteresis, toolchain: Toolchain | None, alter: tuple[str, str] | None) -> Library:
    texts = texts_of(block)
    source = texts["stage.c"]
    if alter:
        assert alter[0] in source
        source = source.replace(*alter)
    names = {"name": "stage", "type": "stage_hysteresis_t", "prefix": "stage_hysteresis"}
    declared = (
        f"typedef struct {{ {''.join(f'{m.declaration(sized=True)}; ' for m in block.members())} }} {names['type']};"
    )
    declared += f"float driver_init({names['type']} *self, float v);"
    declared += f"void driver_run({names['type']} *self, size_t n, const float *wanted, int32_t solves, float *v,"
    declared += " float *h, uint32_t *trace);"
    headers = [(file, text) for file, text in texts.items() if file.endswith(".h")]
    files = [*headers, ("stage_source.h", source), ("driver.c", DRIVER.format(**names))]
    return build(files, declared, toolchain, libraries=())


def voltages(block: Hysteresis, samples: int, seed: int = 1) -> Floats32:
    """A third each of a sine with noise, held steps and jumps, partly beyond the range; with zeros and tiny numbers."""
    rng = np.random.default_rng(seed)
    middle, half = 0.5 * (block.low_V + block.high_V), 0.5 * (block.high_V - block.low_V)
    k = np.arange(samples)
    sine = np.sin(k / 80.0) * np.cos(k / 3777.0) + rng.normal(0.0, 0.002, samples)
    held = np.repeat(rng.uniform(-1.05, 1.05, samples // 40 + 1), 40)[:samples]
    jumps = rng.uniform(-1.05, 1.05, samples)
    x = np.choose(k // 997 % 3, [sine, held, jumps])
    v = np.asarray(middle + half * x, dtype=np.float32)
    v[rng.integers(101) :: 101] = 0.0
    v[rng.integers(307) :: 307] = 2.0**-40
    v[rng.integers(211) :: 211] = np.float32(middle)
    return v


def sine_um(block: Hysteresis, rate_Hz: float, samples: int) -> Floats32:
    """Reachable displacements of a stage that follows 100 Hz over nearly the whole range, with minor loops."""
    middle, half = 0.5 * (block.low_V + block.high_V), 0.5 * (block.high_V - block.low_V)
    t = np.arange(samples) / rate_Hz
    v = middle + half * (0.7 * np.sin(2 * np.pi * 100.0 * t) + 0.25 * np.sin(2 * np.pi * 37.0 * t + 1.0))
    h, _ = Compiled(block, float(np.float32(v[0]))).apply(v.astype(np.float32))
    return h


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


@by_block
@pytest.mark.parametrize("toolchain", TOOLCHAINS, ids=str)
def test_c_equals_the_mirror_bit_for_bit(block: Hysteresis, toolchain: Toolchain) -> None:
    if shutil.which(toolchain.command) is None:
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


def advanced(mirror: HysteresisMirror, wanted: Floats32) -> tuple[Floats32, Floats32, NDArray[np.uint32]]:
    """Voltage that the mirror solves, its output for this voltage, its state; `solve` must not move the state."""
    before = words(mirror)
    v = mirror.solve(wanted)
    assert np.array_equal(words(mirror), before)
    return v, mirror.apply(v), words(mirror)


def words(mirror: HysteresisMirror) -> NDArray[np.uint32]:
    return np.array([word.view(np.uint32)[0] for word in mirror.state()])


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


def test_no_step_is_taken_for_what_rounding_leaves() -> None:
    """100 um beside 0: the residual of h is roundings of 100 um, above the tolerance of a range of 3 um."""
    block = shipped()
    away = dataclasses.replace(block, curve_um=(100.0 + block.curve_um[0], *block.curve_um[1:]))
    assert away.steps <= block.steps


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


@by_block
def test_the_state_stays_in_its_box_and_has_no_denormal_number(block: Hysteresis) -> None:
    v = voltages(block, 30_000, seed=3)
    compiled = Compiled(block, float(v[0]))
    h, trace = compiled.apply(v, traced=True)
    _, _, followed = compiled.follow(np.float32(1.2) * h, traced=True)
    states = np.vstack([trace, followed]).view(np.float32)
    box = block.box(Interval(block.low_V, block.high_V), TS_S)
    paths = [word.path for member in block.members() for word in member.words()]
    assert sorted(box.floats) == sorted(paths)
    for column, path in zip(states.T, paths, strict=True):
        assert box.floats[path].low <= column.min() <= column.max() <= box.floats[path].high
    assert box.through.low <= h.min() <= h.max() <= box.through.high
    # The steps of plays that relax are multiples of 2^-61 (`twofloat`).
    least = 2.0**-63 if block.relaxes else LEAST / 2
    assert (np.abs(states[states != 0.0]) >= least).all()


@functools.cache
def small() -> tuple[Model, Mapping[str, str]]:
    """A model with three plays, and its C; a box is no part of the C."""
    model = model_of(operator(3, 2), rules=2)
    return model, generate(model)


@pytest.mark.parametrize(
    ("function", "inputs"),
    [
        pytest.param("init", "finite", marks=pytest.mark.proof),
        pytest.param("predict", "any", marks=pytest.mark.proof),
        ("inverse", "any"),
    ],
)
@pytest.mark.slow
def test_the_box_is_proved(function: str, inputs: Any) -> None:
    need("frama-c")
    verdict, expected = prove_call(*small(), function, inputs)
    assert not verdict.alarms
    assert verdict.held == verdict.checks >= expected > 15


@pytest.mark.parametrize(
    "path",
    [
        "play[1]",
        "sum_um[0]",
        *(pytest.param(path, marks=pytest.mark.proof) for path in ("left[0]", "back[1]", "turn", "last", "h_um")),
    ],
)
@pytest.mark.slow
def test_a_box_that_is_too_small_is_not_proved(path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    need("frama-c")
    whole = Hysteresis.box

    def narrow(self: Hysteresis, u_V: Interval, Ts_s: float) -> BlockBox:
        box = whole(self, u_V, Ts_s)
        given = box.floats[path]
        return dataclasses.replace(
            box, floats={**box.floats, path: Interval(given.low, given.high - 0.2 * given.width)}
        )

    monkeypatch.setattr(Hysteresis, "box", narrow)
    model, texts = small()
    verdict, _ = prove_call(model, texts, "predict", "finite")
    assert [alarm for alarm in verdict.alarms if path.split("[")[0] in alarm]


@by_block
def test_rest_is_the_output_under_the_same_input(block: Hysteresis) -> None:
    v = np.array([block.low_V, 0.0, 7.25, block.high_V], np.float32)
    if block.relaxes:  # A play near the end of the range relaxes.
        v = np.array([50.0, 55.0], np.float32)
    mirror = block.mirror(v, TS_S)
    rest = mirror.rest()
    assert all(mirror.apply(v).tobytes() == rest.tobytes() for _ in range(3))
    assert np.abs(rest - [block.apply(np.array([float(x)]), TS_S)[0] for x in v]).max() < ERROR_UM


@by_block
def test_constants_are_the_exact_ones_rounded(block: Hysteresis) -> None:
    """Every row of `curve` against exact fractions: g0 and the first n plays taken along, in powers of side x."""
    exact_curve = powers([Fraction(a) for a in block.curve_um])
    number = block.numbers
    size = sum(abs(float(a)) for a in exact_curve) + float(np.abs(number.play[:, 1:]).sum())
    for direction, side in enumerate((1, -1)):
        row = exact_curve + [Fraction(0)] * (number.curve.shape[2] - len(exact_curve))
        row[0] += sum((powers([Fraction(0), *map(Fraction, a)])[0] for a in block.series.plays), Fraction(0))
        for n in range(block.plays + 1):
            found = side * float(side) ** np.arange(len(row)) * number.curve[direction, n].astype(np.float64)
            assert np.abs(found - [float(a) for a in row]).max() < 1.2e-7 * size
            if n < block.plays:
                taken = powers([Fraction(0), *map(Fraction, block.series.plays[n])])
                taken[0] = Fraction(0)
                row = [
                    a + b
                    for a, b in zip(row, shifted(taken, -side * Fraction(block.half_widths[n]), len(row)), strict=True)
                ]


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


def powers(series: list[Fraction]) -> list[Fraction]:
    """Coefficients of the powers of x of a Chebyshev series."""
    before, now = [Fraction(1)], [Fraction(0), Fraction(1)]
    found = [Fraction(0)] * len(series)
    for m, a in enumerate(series):
        if m == 0:
            term = before
        elif m == 1:
            term = now
        else:
            term = [2 * c for c in [Fraction(0), *now]]
            term = [c - (before[k] if k < len(before) else 0) for k, c in enumerate(term)]
            before, now = now, term
        found = [c + (a * term[k] if k < len(term) else 0) for k, c in enumerate(found)]
    return found


def shifted(coefficients: list[Fraction], by: Fraction, size: int) -> list[Fraction]:
    """Coefficients of p(x + by)."""
    found = [Fraction(0)] * size
    for m, c in enumerate(coefficients):
        for k in range(m + 1):
            found[k] += c * math.comb(m, k) * by ** (m - k)
    return found


def test_json_round_trip_is_exact() -> None:
    for block in BLOCKS.values():
        assert block_from_json(block.to_json()) == block


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"low_V": 120.0}, "low_V must be below high_V"),
        ({"curve_um": (1.0,)}, "at least two coefficients"),
        ({"half_widths": (0.2, 0.1, *operator().half_widths[2:])}, "half_widths must rise"),
        ({"half_widths": (1e-4, *operator().half_widths[1:])}, "half_widths must rise and lie between 2^-12 and 1"),
        ({"plays_um": (1.0,) * 23}, "the same number of coefficients for every play"),
        ({"reach": 0.36}, "reach must be at least 0.3607 half ranges"),
        ({"reach": 0.7}, "that of the last Duhem state 0.0451"),
        ({"reach": math.nan}, "reach must be positive"),
        ({"duhem_um": (0.1,) * 3}, "two coefficients for each state"),
        ({"curve_um": (1.0, math.inf)}, "the coefficients must be finite"),
    ],
)
def test_what_has_no_float32_form_is_refused(changes: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint.replace("^", r"\^")):
        dataclasses.replace(operator(), **changes)
