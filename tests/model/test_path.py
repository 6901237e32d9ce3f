"""Input blocks: physics, float32 mirrors, and their inverse."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hysgen.certify.certificates import certify
from hysgen.checking import Host
from hysgen.codegen import generate
from hysgen.errors import ModelError
from hysgen.model.disturbances.drift import Drift
from hysgen.model.file import load_model
from hysgen.model.model import Model
from hysgen.model.path import InputBlock, block_from_json, kinds, preview
from hysgen.model.path.chain import ChainMirror, PathLimits
from hysgen.model.path.creep import Creep
from hysgen.model.path.delay import Delay
from hysgen.model.path.limits import Saturation, Slew
from hysgen.model.path.loop import Loop
from hysgen.model.path.modes import Modes
from hysgen.model.path.softening import Softening
from hysgen.model.path.structure import Structure

TS_S = 2e-5
LAST_BIT = 2.0**-24
LIMITERS: list[InputBlock] = [Saturation(-5.0, 95.0), Slew(1.2e5, 0.9e5)]
RESPONSES: list[InputBlock] = [
    Creep(0.01, (1e-3, 0.1, 10.0)),
    Modes((730.0,), (0.05,), (0.3,), 4e-4, early_s=2e-5),
    Structure((730.0, 2100.0), (0.05, 0.1), (0.3, 0.2), 4e-4, (0.1, -0.2), TS_S),
    Softening.examples(np.random.default_rng(3))[0],
    Loop(730.0, 0.02, (-1e-3, -2e-3), (0.02, 0.03), (0.01, 0.0), (0.02, 0.5), (40.0, 3.0), 2, 4e-5, 1.0),
]
ORDER = "saturation, slew, delay, hysteresis, creep, modes, structure, softening, loop"
BLOCKS: list[InputBlock] = [*LIMITERS, Delay(3.4), *RESPONSES]
by_kind = pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.kind)


def commands(samples: int, seed: int = 4) -> NDArray[np.float64]:
    """Steps and a sine between -20 and 120 V, rounded to float32."""
    rng = np.random.default_rng(seed)
    steps = np.repeat(rng.uniform(-20, 120, samples // 50 + 1), 50)[:samples]
    k = np.arange(samples)
    return np.where(k % 1000 < 500, steps, 50 + 69 * np.sin(k / 30)).astype(np.float32).astype(np.float64)


def limits(low: float = -20.0, high: float = 120.0) -> PathLimits:
    """Commands within -20 .. 120 V, w within low .. high."""
    return PathLimits(*(np.float32(x) for x in (-20.0, 120.0, low, high, 2.0**-20 * (high - low))))


def test_every_kind_is_in_this_list() -> None:
    """The hysteresis has a file of its own."""
    assert sorted(kinds()) == sorted([*(block.kind for block in BLOCKS), "hysteresis"])
    assert all(isinstance(block, InputBlock) for block in BLOCKS)


@by_kind
def test_mirror_agrees_with_float64(block: InputBlock) -> None:
    u = commands(5000)
    mirror = block.mirror(u[:1].astype(np.float32), TS_S)
    single = np.array([float(mirror.apply(np.array([value], dtype=np.float32))[0]) for value in u])
    # The slew limit adds a rounded step and rounds the sum, up to 60 times in a row from one step of u to the next. The
    # modes' three products and their sums are rounded in each sample, at up to 1.6 times the input.
    bits = {"saturation": 1, "slew": 60, "delay": 3, "creep": 2, "modes": 8}
    assert np.abs(single - block.apply(u, TS_S)).max() < bits.get(block.kind, 64) * LAST_BIT * 120


@by_kind
def test_rest_under_a_constant_command_stays(block: InputBlock) -> None:
    gain = 1.0 + 3 * 0.01 if block.kind == "creep" else 1.0
    assert block.apply(np.full(100, 30.0), TS_S) == pytest.approx(np.full(100, 30.0 * gain), rel=1e-15)
    mirror = block.mirror(np.full(1, 30.0, np.float32), TS_S)
    rest = mirror.rest()
    assert all(mirror.apply(np.full(1, 30.0, np.float32)) == rest for _ in range(100))


def test_a_limiter_passes_its_own_output_unchanged() -> None:
    u = commands(4000).astype(np.float32)
    first, second = (ChainMirror(LIMITERS, u[:1], TS_S, limits()) for _ in range(2))
    for value in u:
        passed = first.apply(np.array([value]))
        again = second.apply(passed)
        assert again.view(np.uint32)[0] == passed.view(np.uint32)[0]


@pytest.mark.parametrize("samples", [0.0, 0.25, 1.0, 2.5, 17.9])
@pytest.mark.parametrize("per_period", [100, 500])
def test_delay_of_a_sine_is_the_delay_and_its_loss_is_bounded(samples: float, per_period: int) -> None:
    w = 2 * np.pi / per_period
    k = np.arange(40 * per_period)
    v = Delay(samples).apply(np.sin(w * k), TS_S)[-20 * per_period :]
    phasor = 2 * np.mean(v * np.exp(-1j * w * k[-20 * per_period :]))
    delay, mu = -np.angle(phasor * 1j) / w, samples % 1
    # (1 - mu) + mu exp(-iw): its phase is -mu w (1 + O(w^2 / 6)), its modulus 1 - mu (1 - mu) w^2 / 2.
    assert delay == pytest.approx(samples, abs=w * w / 6)
    assert abs(phasor) == pytest.approx(1 - 0.5 * mu * (1 - mu) * w * w, abs=w**4)


@pytest.mark.parametrize("samples", [0.0, 0.3, 1.0, 3.5, 6.8])
def test_command_arrives_after_the_preview(samples: float) -> None:
    block = Delay(samples)
    wanted = (50 + 40 * np.sin(2 * np.pi * np.arange(2000) / 500)).astype(np.float32)
    ahead, plant = (block.mirror(wanted[:1], TS_S) for _ in range(2))
    arrived = np.array([plant.apply(ahead.command(wanted[k : k + 1]))[0] for k in range(wanted.size)])
    late = arrived[block.preview + 1 :] - wanted[1 : wanted.size - block.preview]
    mu, w = samples % 1, 2 * np.pi / 500
    # Two interpolations, each loses mu (1 - mu) w^2 / 2 of the 40 V; the rest is float32 rounding.
    assert np.abs(late).max() <= 40 * mu * (1 - mu) * w * w + 3 * LAST_BIT * 90


def test_blocks_out_of_order_or_twice_are_refused() -> None:
    base = load_model("appendix_a")
    for blocks in ((BLOCKS[1], BLOCKS[0]), (BLOCKS[2], BLOCKS[2])):
        with pytest.raises(ModelError, match=f"each may stand once, in the order {ORDER}"):
            dataclasses.replace(base, blocks=blocks)


@pytest.mark.parametrize(
    ("data", "complaint"),
    [
        ({"kind": "echo"}, f"blocks: kind 'echo' is unknown; this hysgen knows {', '.join(sorted(ORDER.split(', ')))}"),
        ({"kind": "saturation", "low_V": 1.0, "high_V": 1.0}, "blocks: saturation: low_V must lie below high_V"),
        ({"kind": "slew", "rise_V_s": -1.0, "fall_V_s": 1.0}, "blocks: slew: rise_V_s and fall_V_s must be positive"),
        ({"kind": "delay", "samples": -0.5}, "blocks: delay: samples must be 0 to 1000"),
        ({"kind": "delay", "samples": float("nan")}, "blocks: delay: samples must be 0 to 1000"),
        ({"kind": "delay"}, "blocks: delay: 'samples'"),
    ],
)
def test_malformed_blocks_are_refused_in_one_line(data: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ModelError) as fault:
        block_from_json(data)
    assert complaint in str(fault.value)
    assert "\n" not in str(fault.value)


def extended(*blocks: InputBlock) -> Model:
    """Appendix A with drift, certified for the inverse."""
    model = dataclasses.replace(
        load_model("appendix_a"), terms=(Drift(0.1, 0.05),), weights=np.array([1.0]), blocks=blocks
    )
    assert certify(model).inverse_holds
    return model


@pytest.mark.parametrize("samples", [None, 0.0, 3.0, 4.6])
@pytest.mark.slow
def test_inverse_with_preview_makes_the_free_run_follow_its_reference(samples: float | None) -> None:
    blocks: list[InputBlock] = [Saturation(-10.0, 110.0), Slew(2e6, 2e6)]
    blocks += [] if samples is None else [Delay(samples)]
    model = extended(*blocks)
    host = Host(model.name, generate(model))
    # Where the model rests under 40 V, the reference starts.
    settle = host.instance(2.0, 40.0)
    rest, _ = host.run("simulate", settle, [np.full(20_000, 40.0, np.float32).view(np.uint32)])
    y0 = float(rest.view(np.float32)[-1])
    n = 6000
    reference = (y0 + 0.2 * (1 - np.cos(2 * np.pi * np.maximum(np.arange(n) - 50, 0) / 500))).astype(np.float32)
    inverse, plant = host.instance(y0, 40.0), host.instance(y0, 40.0)
    layout = host.layout(f"{model.name}_t")
    columns = [reference[:-1].view(np.uint32), reference[1:].view(np.uint32)]
    command, trace = host.run("inverse", inverse, columns, words=layout["status"] + 1)
    assert not trace[:, layout["status"]].any()
    reached, _ = host.run("simulate", plant, [command])
    ahead = preview(blocks)
    error = reached.view(np.float32)[ahead:] - reference[1 : n - ahead]
    mu, w = (samples or 0.0) % 1, 2 * np.pi / 500
    # A round trip through Eq. (11) is good to 1e-5 um; of a fractional delay two interpolations lose mu (1 - mu) w^2 of
    # the command's swing, below 6 V here, at a static gain of 0.083 um/V.
    assert np.ptp(command.view(np.float32)) < 6.0
    assert np.abs(error).max() < 1e-5 + 6.0 * mu * (1 - mu) * w * w * 0.083


def test_inverse_tells_when_the_limiters_hold_it_back() -> None:
    model = extended(Slew(1e4, 1e4))
    host = Host(model.name, generate(model))
    struct = host.instance(2.0, 40.0)
    layout = host.layout(f"{model.name}_t")
    columns = [np.float32([2.0, 2.0]).view(np.uint32), np.float32([2.05, 2.05]).view(np.uint32)]
    command, trace = host.run("inverse", struct, columns, words=len(layout))
    unreachable = 0x20
    assert trace[0, layout["status"]] & unreachable
    u = command.view(np.float32)
    assert np.abs(np.diff(np.append(40.0, u))).max() <= np.float32(0.2) * (1 + 4 * LAST_BIT * 200)
    # The state follows what was let through, not what was asked for.
    assert trace[-1, layout["inputs.v_V"]] == trace[-1, layout["inputs.slew.last_V"]] == command[-1]
