"""The loop that is designed from a model, around stages that share no equation with it: chains of masses in springs."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import freqz

import hysgen
from hysgen.cli import main
from hysgen.errors import HysgenError
from hysgen.feedback.certificate import LoopDesign
from hysgen.feedback.design import Notch, bandwidths_Hz, filter_block, filter_response, largest_gain
from hysgen.float32.reference.instance import Instance
from hysgen.model.model import Grid, Model
from hysgen.model.path.structure import Structure

Floats = np.ndarray
TS_S = 2e-5
LAG_S = 1e-4
DRAWS = 1000


def chain(masses: Floats, springs: Floats, damping: float) -> tuple[Floats, Floats, Floats]:
    """x' = A x + B force, y = C x: masses in line, (n,), each behind a spring, (n,), the first one at the wall; the
    force moves the first mass, the sensor sees all of them. Damping: the same share of critical in every spring."""
    n = masses.size
    links = np.eye(n) - np.eye(n, k=-1)
    stiff = links.T @ np.diag(springs) @ links
    lossy = links.T @ np.diag(2.0 * damping * np.sqrt(springs * masses)) @ links
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-stiff / masses[:, None], -lossy / masses[:, None]]])
    B = np.concatenate([np.zeros(n), np.eye(n)[0] / masses])
    C = np.concatenate([np.linspace(1.0, 0.3, n), np.zeros(n)])
    return A, B, C / float(C @ np.linalg.solve(-A, B))


def modal(A: Floats, B: Floats, C: Floats) -> Structure:
    """The chain as an identification would find it: frequency, damping and complex share of each mode."""
    poles, V = np.linalg.eig(A)
    shares = -2.0 * (C @ V) * np.linalg.solve(V, B.astype(complex)) / poles
    rows = sorted((abs(p), -p.real / abs(p), q.real, q.imag) for p, q in zip(poles, shares, strict=True) if p.imag < 0)
    w, zeta, share, quadrature = (tuple(map(float, row)) for row in zip(*rows, strict=True))
    return Structure(tuple(np.array(w) / (2.0 * math.pi)), zeta, share, LAG_S, quadrature, TS_S)


def stage(modes: int) -> tuple[Floats, Floats, float]:
    springs = (2.0 * math.pi * 800.0) ** 2 * np.array([1.0, 3.0, 6.0][:modes])
    return np.array([1.0, 0.6, 0.3])[:modes], springs, 0.01


def model_of(modes: int) -> Model:
    keep = math.exp(-TS_S / LAG_S)
    return Model(
        "chain",
        TS_S,
        Grid(-40.0, 140.0, 4),
        np.tile([keep, 1.0 - keep, 0.0], (4, 1)),
        -20.0,
        120.0,
        blocks=(modal(*chain(*stage(modes))),),
    )


def pushed(model: Model, loop: LoopDesign, rng: np.random.Generator, samples: int) -> Floats:
    """(DRAWS, samples) displacement less 50 um after a push of 1 um, by the arithmetic that is emitted.

    Every draw is a chain of its own masses, springs and dampers behind an elasto-slide actuator and a lag.
    """
    masses, springs, damping = stage(len(model.blocks[0].f_Hz))
    n = masses.size
    # A spring of 1 % moves a mode by half of it, so does a mass: within the 1 % of the uncertainty.
    own_masses, own_springs = (x * (1.0 + rng.uniform(-0.009, 0.009, (DRAWS, n))) for x in (masses, springs))
    rates, of = np.zeros((DRAWS, 2 * n + 1, 2 * n + 1)), np.empty((DRAWS, 2 * n))
    for i in range(DRAWS):
        rates[i, :-1, :-1], rates[i, :-1, -1], of[i] = chain(
            own_masses[i], own_springs[i], damping * rng.uniform(0.75, 1.25)
        )
    whole = expm(TS_S * rates)
    step_A, step_B = whole[:, :-1, :-1], whole[:, :-1, -1]
    level = np.full(DRAWS, 50.0, dtype=np.float32)
    inverse = Instance(model, level, level)
    block = loop.block
    notches = None if block is None else block.mirror(np.zeros_like(level), TS_S)
    keep = math.exp(-TS_S / LAG_S) ** (1.0 / rng.uniform(0.92, 1.08, DRAWS))
    gain, slack = rng.uniform(0.97, 1.03, DRAWS), rng.uniform(0.0, 0.2, DRAWS)
    rest = np.linalg.solve(np.eye(2 * n) - step_A, step_B[..., None])[..., 0]
    x, lagged, slid, late = rest * 50.0, np.full(DRAWS, 50.0), np.zeros(DRAWS), np.full(DRAWS, 50.0)
    correction, before, y = np.zeros_like(level), np.zeros_like(level), np.empty((DRAWS, samples))
    for k in range(samples):
        y[:, k] = np.einsum("ij,ij->i", of, x) - 50.0 + 1.0
        residual = (-y[:, k]).astype(np.float32)
        moves = residual if notches is None else notches.apply(residual)
        correction = correction + np.float32(0.5 * loop.integral) * (moves + before)
        before = moves
        # The voltage of the last sample acts now, a sample late; the slider gives way within its friction.
        u, late = late, inverse.inverse(inverse.y_um, level + correction).astype(float)
        slid = np.clip(slid, u - 50.0 - slack, u - 50.0 + slack)
        drive = 50.0 + gain * (0.9 * (u - 50.0) + 0.1 * slid)
        x = np.einsum("ijk,ik->ij", step_A, x) + step_B * lagged[:, None]
        lagged = keep * lagged + (1.0 - keep) * drive
    return y


@pytest.mark.slow
@pytest.mark.parametrize("modes", [1, 2, 3])
def test_a_thousand_chains_settle_with_six_tenths_of_their_first_mode(modes: int) -> None:
    model = model_of(modes)
    loop = hysgen.design_loop(model)
    c = loop.certificate
    assert c.holds
    assert loop.first_Hz == pytest.approx(min(model.blocks[0].f_Hz))
    assert c.bandwidth_Hz >= 0.6 * loop.first_Hz
    assert c.bandwidth_Hz > 3.0 * c.integral_Hz
    samples = math.ceil(20.0 / (2.0 * math.pi * c.bandwidth_Hz * TS_S))
    y = pushed(model, loop, np.random.default_rng(modes), 2 * samples)
    assert np.abs(y).max() < 2.5
    assert np.abs(y[:, samples:]).max() < 0.1
    # What is left rings in the light modes, which the loop lets alone.
    assert np.abs(y[:, -50:]).max() < 0.05


def test_the_gain_is_the_largest_that_keeps_the_margins() -> None:
    """Of an integral behind 3 samples, L = K z^-4 z/(z - 1): phase -90 - 3.5 w, |L| = K / (2 sin w/2)."""
    w = np.geomspace(1e-4, math.pi * 0.999, 20_000)
    z = np.exp(1j * w)
    loops = np.array([z**-4 * z / (z - 1.0)])
    gain, _ = largest_gain(loops)
    turn = math.pi / 7.0
    assert gain <= 0.5012 * 2.0 * math.sin(0.5 * turn)
    crossing = 2.0 * math.asin(0.5 * gain)
    phase_deg = -90.0 - math.degrees(3.5 * crossing)
    assert phase_deg >= -135.0
    away = np.abs(np.angle(-1.01 * gain * loops, deg=True)) / 45.0
    size_dB = 20.0 * np.log10(np.abs(1.01 * gain * loops))
    assert ((away < 1.0) & (away**2 + (size_dB / 6.0) ** 2 < 1.0)).any()
    closed = gain * loops[0] / (1.0 + gain * loops[0])
    at = float(bandwidths_Hz(gain * loops, w)[0])
    assert np.interp(at, w, np.abs(closed)) == pytest.approx(math.sqrt(0.5), rel=1e-3)


def test_the_filter_is_the_structure_that_is_emitted() -> None:
    notches = (Notch(700.0, 0.02, 900.0, 0.6), Notch(1500.0, 0.3, 4000.0, 0.9))
    f_Hz = np.array([1.0, 300.0, 700.0, 1500.0, 9000.0])
    z = np.exp(2j * math.pi * f_Hz * TS_S)
    block = filter_block(notches, TS_S)
    assert block is not None
    impulse = np.zeros(40_000)
    impulse[0] = 1.0
    played = block.apply(impulse, TS_S, block.start(0.0))
    _, seen = freqz(played, worN=2.0 * math.pi * f_Hz * TS_S)
    np.testing.assert_allclose(seen, filter_response(notches, z, TS_S), rtol=1e-6)
    assert abs(filter_response(notches, z, TS_S)[2]) < 0.05


@pytest.mark.slow
def test_verb_and_refusals(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["loop", "appendix_a", "-o", "loop.json", "--plot", "loop.png"]) == 0
    said = capsys.readouterr().out
    assert "certificate over 1024 draws of the uncertainty: holds" in said
    stored = json.loads(Path("loop.json").read_text())
    assert stored["certificate"]["bandwidth_Hz"] > 1.1 * stored["certificate"]["integral_Hz"] > 2000.0
    assert Path("loop.png").stat().st_size > 10_000
    with pytest.raises(HysgenError, match=r"uncertainty: gain = 1\.5"):
        hysgen.design_loop("appendix_a", gain=1.5)
    with pytest.raises(HysgenError, match="gian: is not known"):
        hysgen.design_loop("appendix_a", gian=0.1)
    assert main(["loop", "appendix_a", "--uncertainty", "gain"]) == 2
    assert "'gain' is not KEY=VALUE" in capsys.readouterr().err
