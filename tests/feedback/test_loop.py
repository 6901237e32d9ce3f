"""The loop that is designed from a model keeps its word around stages that share no equation with it."""

import dataclasses
import importlib.util
import json
import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import signal

import hysgen
from fixtures import soft_springs
from hysgen.cli import main
from hysgen.diagnosis import diagnose
from hysgen.errors import HysgenError
from hysgen.feedback.certificate import margins
from hysgen.feedback.design import Notch, filter_block, largest_gains, zpk
from hysgen.float32.reference.instance import Instance
from hysgen.model.feedback import Feedback
from hysgen.model.file import load_model
from hysgen.model.path.delay import Delay
from hysgen.model.path.softening import Softening
from hysgen.model.path.structure import Structure
from hysgen.record.read import demo_record, record_csv

SCRIPT = importlib.util.spec_from_file_location("loops", Path(__file__).parents[2] / "benchmarks" / "loops.py")
assert SCRIPT is not None
assert SCRIPT.loader is not None
loops = importlib.util.module_from_spec(SCRIPT)
SCRIPT.loader.exec_module(loops)


@pytest.mark.slow
@pytest.mark.parametrize("modes", [2, *(pytest.param(modes, marks=pytest.mark.proof) for modes in (1, 3))])
def test_a_thousand_chains_settle_with_six_tenths_of_their_first_mode(modes: int) -> None:
    model = loops.model_of(modes)
    loop = hysgen.design_loop(model)
    assert loop.certificate.holds
    assert loop.certificate.pole == round(loop.certificate.pole, 9) < 1.0  # the digits of a bound
    assert loop.first_Hz == pytest.approx(min(model.blocks[0].f_Hz))
    assert loop.certificate.bandwidth_Hz >= max(0.6 * loop.first_Hz, 3.0 * loop.certificate.integral_Hz)
    for settling_s, said in ((0.0123, "in 12.3 ms"), (None, "in not settled")):
        settled = dataclasses.replace(loop.certificate, settling_s=settling_s)
        assert said in str(dataclasses.replace(loop, certificate=settled))
    samples = math.ceil(20.0 / (2.0 * math.pi * 0.6 * loop.first_Hz * model.Ts_s))
    y = np.abs(loops.pushed(model, loop, np.random.default_rng(modes), 2 * samples))
    # What is left rings in the light modes, which the loop lets alone.
    assert (y.max() < 2.5, y[:, samples:].max() < 0.1, y[:, -50:].max() < 0.05) == (True, True, True)


@pytest.mark.parametrize("s", [0.0, 0.5])
def test_a_held_amplitude_is_a_linear_stage_of_the_own_drive(s: float) -> None:
    """Against the equations of `softening` sample by sample, at an amplitude that does not move."""
    block = Softening.examples(np.random.default_rng(0))[0]
    (Q, R), poles, a = block.of_drives, block.poles(block.Ts_s, s), math.exp(-block.Ts_s / block.lag_s)
    x = np.append(0.0, np.random.default_rng(1).normal(size=400))
    c, y = np.zeros(2, dtype=complex), np.zeros(401)
    for k in range(1, 401):
        y[k] = c.real.sum()
        c = c + (1.0 - poles) * (Q[:, 0] * x[k] - c) + s * R[:, 0] * (x[k] - x[k - 1])
    system = (*(np.atleast_2d(part) for part in block.held(s, block.Ts_s)), 1.0)
    _, w, _ = signal.dlsim((system[0], system[1].T, *system[2:]), x)
    np.testing.assert_allclose(w[1:-1, 0], (y[2:] - a * y[1:-1]) / (1.0 - a), atol=1e-9 * np.abs(w).max())


@pytest.mark.slow
@pytest.mark.proof
def test_a_loop_around_modes_that_soften_holds_on_springs_that_yield_under_another_drive() -> None:
    """128 stages of which no model of hysgen has the equation, shaken by the other drive from nothing to all of it."""
    known, again = soft_springs.record((0.5, 1.0, 2.0), 3000, 1, 40.0), soft_springs.record((1.0,), 3000, 2, 40.0)
    loop = hysgen.design_loop(model := diagnose(known, again).model)
    assert [block.kind for block in model.blocks][-1] == "softening"
    assert loop.certificate.holds
    assert loop.certificate.bandwidth_Hz > 10.0 * loop.certificate.integral_Hz
    looped = loop.around(model)
    assert "float stage_correct(stage_t *self" in hysgen.generate(looped)["stage.h"]
    level = np.repeat([0.0, 0.3, 1.0, 2.0], 32)
    t = soft_springs.TS_S * np.arange(2400)

    def displaced(closed: bool) -> NDArray[np.float64]:
        """(samples, lanes): 1500 samples of noise on top of a slow push of the other drive, then the push alone."""
        rng, rest = np.random.default_rng(3), np.zeros(level.size, np.float32)
        varied = [
            1.0 + share * rng.uniform(-1.0, 1.0, (level.size, n)) for share, n in ((0.009, 2), (0.2, 1), (0.2, 1))
        ]
        stage = soft_springs.Springs(
            level.size, varied[0] * soft_springs.F_HZ, varied[1] * soft_springs.ZETA, varied[2] * 40.0
        )
        gain, inverse = rng.uniform(0.9, 1.1, level.size), Instance(looped, rest, rest)
        shaken = np.repeat(rng.uniform(-1.0, 1.0, (750, level.size)), 2, axis=0) * level
        other = 0.3 * np.sin(20.0 * np.pi * t)[:, None] + np.append(shaken, np.zeros((900, level.size)), axis=0)
        other, asked, u_V, y_um = np.clip(other, -2.0, 2.0), rest, 0.0 * level, np.empty((t.size, level.size))
        for k in range(t.size):
            y_um[k] = stage.x.sum(axis=1)
            inverse.aux([other[k].astype(np.float32)])
            aim = inverse.correct((-y_um[k]).astype(np.float32)) if closed else rest
            # The voltage of the sample before acts now.
            stage.step(np.stack([gain * u_V, other[k]], axis=1))
            u_V, asked = inverse.inverse(asked, aim).astype(np.float64), aim
        return y_um

    left, pushed = displaced(True), displaced(False)
    assert np.abs(left[1000:, :32]).max() < 0.15 * np.abs(pushed[1000:, :32]).max()
    assert (np.abs(left).max(axis=0) < 1.5 * np.abs(pushed).max(axis=0))[32:].all()
    # What shook it dies out at every amplitude.
    assert (np.abs(left[2300:]).max(axis=0) < 0.1 * np.abs(left[:1500]).max(axis=0))[32:].all()


def test_a_filter_is_better_than_none_where_few_draws_miss_the_one_that_bounds_the_integral() -> None:
    mode = Structure((780.0,), (0.0286,), (0.255,), 1.6e-5, (0.0,), loops.TS_S)
    certificate = hysgen.design_loop(dataclasses.replace(loops.model_of(1), blocks=(Delay(1.8), mode))).certificate
    assert certificate.holds
    assert certificate.bandwidth_Hz > max(certificate.integral_Hz, 0.6 * 780.0)


def test_the_gain_is_the_largest_that_keeps_the_margins() -> None:
    """L = K z^-4 z/(z - 1): phase -90 - 3.5 w, |L| = K / (2 sin w/2)."""
    w = np.geomspace(1e-4, math.pi * 0.999, 20_000)
    gain = float(largest_gains(np.array([np.exp(-3j * w) / (np.exp(1j * w) - 1.0)]))[0])
    away, size_dB = (np.degrees(3.5 * w) - 90.0) / 45.0, 20.0 * np.log10(gain / (2.0 * np.sin(0.5 * w)))
    nearest = np.min(away**2 + (size_dB / 6.0) ** 2)
    assert nearest == pytest.approx(1.0, abs=1e-3)
    assert size_dB[np.argmin(np.abs(away))] <= -6.0
    # |L| = 1 where w = 2 asin(K / 2), and L is real and negative where w = pi / 7, 3 pi / 7 ...
    loop, crossing = gain * np.exp(-3j * w) / (np.exp(1j * w) - 1.0), 2.0 * math.asin(0.5 * gain)
    own = -20.0 * math.log10(gain / (2.0 * math.sin(math.pi / 14.0))), 90.0 - math.degrees(3.5 * crossing)
    assert margins(np.array([loop, 0.5 * loop])[:, ::300]) == pytest.approx(own, rel=0.01)
    assert margins(np.full((1, 9), 0.5 + 0.1j)) == (math.inf, 180.0)


def test_the_emitted_correction_is_the_designed_integral_and_notches() -> None:
    """Against scipy's recursions in float64: K/2 (1 + z^-1)/(1 - z^-1) behind second-order sections."""
    notches = (Notch(800.0, 0.01, 900.0, 0.5), Notch(2100.0, 0.3, 5000.0, 0.9))
    model = load_model("appendix_a")
    feedback = Feedback(0.05, 10.0, filter_block(notches, model.Ts_s))
    looped = Instance(
        dataclasses.replace(model, feedback=feedback), np.full(1, 2.0, np.float32), np.zeros(1, np.float32)
    )
    looped.u_V[:] = 50.0
    residual = np.random.default_rng(5).uniform(-1.0, 1.0, 3000).astype(np.float32)
    found = np.concatenate([looped.correct(r) for r in residual[:, None]])
    moves = signal.sosfilt(signal.zpk2sos(*zpk(notches, model.Ts_s)), residual.astype(np.float64))
    exact = signal.lfilter([0.025, 0.025], [1.0, -1.0], moves)
    assert np.abs(found - exact).max() < 1e-4 * np.abs(exact).max()


@pytest.mark.parametrize("falls", [False, True])
def test_the_correction_is_bounded_and_does_not_wind_up(falls: bool) -> None:
    """Lanes: the voltage inside its limits, at the upper and at the lower one."""
    model = load_model("appendix_a")
    if falls:
        model = dataclasses.replace(model, consequents=model.consequents * [1.0, -1.0, 1.0])
    looped = Instance(
        dataclasses.replace(model, feedback=Feedback(0.1, 0.5)), np.full(3, 2.0, np.float32), np.zeros(3, np.float32)
    )
    looped.u_V = np.array([50.0, model.u_max_V, model.u_min_V], np.float32)
    up, down = (1, 2) if falls else (2, 1)
    for _ in range(300):
        raised = looped.correct(np.full(3, 0.01, np.float32))
    assert np.array_equal(raised[[0, up, down]], np.float32([raised[0], raised[0], 0.0]))
    assert 0.29 < raised[0] < 0.31
    assert np.array_equal(looped.correct(np.full(3, np.nan, np.float32)), looped.loop.correction_um)
    assert (looped.counters["y_rejected"] == 1).all()
    for _ in range(10):
        lowered = looped.correct(np.full(3, -np.float32(3e38)))
    assert lowered[0] == lowered[down] == -0.5
    assert lowered[up] >= raised[up]
    assert (looped.counters["y_clamped"] == 10).all()


@pytest.mark.slow
def test_verb_and_refusals(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    outputs = ["-o", "looped.json", "--json", "loop.json", "--plot", "loop.png"]
    assert main(["loop", "appendix_a", "--uncertainty", "gain=0.2", *outputs]) == 0
    assert "certificate over 1024 draws of the uncertainty: holds" in capsys.readouterr().out
    designed = json.loads(Path("loop.json").read_text())
    assert designed["uncertainty"]["gain"] == 0.2
    feedback = load_model("looped.json").feedback
    assert feedback is not None
    assert feedback.integral == designed["integral"]
    assert "float appendix_a_correct(appendix_a_t *self" in hysgen.generate("looped.json")["appendix_a.h"]
    Path("looped.json").write_text(Path("looped.json").read_text().replace('"limit_um"', '"limit"'))
    with pytest.raises(HysgenError, match="feedback"):
        load_model("looped.json")
    assert main(["loop", "appendix_a", "--uncertainty", "gain"]) == 2
    assert "write KEY=VALUE" in capsys.readouterr().err
    with pytest.raises(HysgenError, match="gain = 1"):
        hysgen.design_loop("appendix_a", gain=1.5)


@pytest.mark.slow
def test_a_model_identified_again_has_its_loop_if_the_margins_stay(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record = demo_record()[:6000]
    loop = hysgen.design_loop(model := hysgen.fit(record), latency=3.0, frequency=0.05)
    looped = loop.around(model)
    later = hysgen.Record.from_arrays(record.u_V, 1.02 * record.y_um, record.Ts_s)
    again, _ = hysgen.refit(looped, later)
    assert again.history["loop"]["latency"] == 3.0
    assert again.feedback is not None
    assert 0.5 * loop.integral < again.feedback.integral <= loop.integral
    assert again.feedback.limit_um == pytest.approx(1.02 * looped.feedback.limit_um, rel=1e-6)
    hasty = dataclasses.replace(looped, feedback=dataclasses.replace(looped.feedback, integral=5.0 * loop.integral))
    with pytest.warns(
        hysgen.RecordWarning, match="its loop does not keep its margins around the new model and is left"
    ):
        assert hysgen.refit(hasty, later)[0].feedback is None
    (tmp_path / "later.csv").write_text(record_csv(later))
    hysgen.save_model(looped, tmp_path / "old.json")
    assert (
        main(["refit", str(tmp_path / "old.json"), str(tmp_path / "later.csv"), "-o", str(tmp_path / "new.json")]) == 0
    )
    assert "its loop keeps its margins around the new model, with" in capsys.readouterr().out
