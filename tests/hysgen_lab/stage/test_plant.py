"""The stage as a whole: gain and bandwidth, one plant at every rate, the bundled record, effects in new files."""

import dataclasses
import importlib
import math
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import hysgen
from hysgen.record.read import bundled_csv
from hysgen_lab.stage import BoucWen, Preisach, Stage, StageError, StageState, effect_shares, run, static_loop, without
from hysgen_lab.stage.demo_record import demo_csv, demo_measurement, identification_rows
from hysgen_lab.stage.effects import Action, Effect
from hysgen_lab.studies.bank import scenario

Floats = NDArray[np.float64]
TS_S = 20e-6
# The nominal stage's promises, from the paper: nominal stroke and voltage (section 4), pole of 1 ms (Appendix A).
GAIN_UM_PER_V = 10.0 / 120.0
POLE_HZ = 1 / (2 * math.pi * 1e-3)

EVERYTHING = Stage.laboratory().with_effects(
    saturation=(0.0, 44.0),
    delay=2.3,
    drift=(0.1, 0.01),
    aging=(-0.1, 0.05),
    outliers=(0.01, 0.2),
    coupling={"axis2_V": 0.01, "axis3_V": -0.02},
    stick_slip=0.004,
    noise=(0.001, 0.001),
)


def drive(n: int) -> Floats:
    t_s = TS_S * np.arange(n)
    return 25.0 + 14.0 * np.sin(2 * np.pi * 100.0 * t_s) + 8.0 * np.sin(2 * np.pi * 37.0 * t_s)


def test_dc_gain_of_the_nominal_stage_is_ten_micrometres_over_120_volts() -> None:
    held_V = np.repeat([0.0, 120.0, 0.0, 120.0, 0.0], 100)
    measured = run(Stage.nominal(), held_V, 1e-3, seed=1).displacement_um.reshape(5, 100)[:, 50:].mean(axis=1)
    # 50 readings with 0.5 nm of noise and 0.5 nm of resolution: their mean is good to 0.1 nm; five times that.
    np.testing.assert_allclose(np.abs(np.diff(measured)) / 120.0, GAIN_UM_PER_V, atol=0.0005 / 120.0)


def test_bandwidth_of_the_nominal_stage_is_the_pole_of_appendix_a() -> None:
    stage = Stage.nominal().with_effects(memory=None)
    gains = []
    for f_Hz in (2.0, POLE_HZ):
        n = round(4 / f_Hz / TS_S)
        w_t = 2 * np.pi * f_Hz * TS_S * np.arange(n)
        y_um = run(stage, 50.0 + 20.0 * np.sin(w_t), TS_S).displacement_um[n // 2 :]
        base = np.stack([np.sin(w_t), np.cos(w_t), np.ones(n)], axis=1)[n // 2 :]
        (s, c, _), *_ = np.linalg.lstsq(base, y_um, rcond=None)
        gains.append(math.hypot(s, c) / 20.0)
    # -3 dB at the pole. The start has died to exp(-12), the noise of 0.5 nm averages out over 600 readings: 1e-4.
    assert gains[0] == pytest.approx(GAIN_UM_PER_V, rel=2e-4)
    assert gains[1] / gains[0] == pytest.approx(math.sqrt(0.5), rel=2e-4)


def test_without_effects_exactly_a_proportional_ceramic_behind_one_pole_remains() -> None:
    stage = Stage(memory=None, dac_bits=0).quiet()
    u_V = drive(3000)
    y_um = run(stage, u_V, TS_S).displacement_um
    keep = math.exp(-TS_S / 1e-3)
    # Rounding of one multiplication and addition at 4 um.
    np.testing.assert_allclose(y_um[1:], keep * y_um[:-1] + (1 - keep) * GAIN_UM_PER_V * u_V[:-1], atol=1e-14)
    assert stage.active == ()


@pytest.mark.parametrize("memory", [Preisach(), BoucWen()])
@pytest.mark.parametrize(("slew", "tolerance_um"), [(None, 1e-6), (100e3, 2.5e-4)])
def test_it_is_the_same_plant_at_every_sampling_rate(
    slew: float | None, tolerance_um: float, memory: Preisach | BoucWen
) -> None:
    # The D/A's instants are the same, the mesh between them is not. Substeps are exact but for the bend of the
    # hysteresis within one; where a rate limit ends between two nodes, up to half a step of the sensor is lost.
    stage = Stage.laboratory().quiet().with_effects(memory=memory, slew=slew, drift=None, delay=(0.0, 1.3e-3))
    held_V = np.random.default_rng(3).uniform(0.0, 110.0, 60)
    slow = run(stage, held_V, 5e-3, rest_V=20.0).displacement_um
    for ratio in (5, 50, 250):
        fast = run(stage, np.repeat(held_V, ratio), 5e-3 / ratio, rest_V=20.0).displacement_um[::ratio]
        np.testing.assert_allclose(fast, slow, atol=tolerance_um)


def test_a_run_equals_the_same_inputs_step_by_step() -> None:
    n = 6000
    u_V, others = drive(n), np.random.default_rng(1).normal(size=(n, 2))
    aux = {"axis3_V": others[:, 1], "axis2_V": others[:, 0]}
    whole = run(EVERYTHING, u_V, TS_S, 9, aux, rest_V=10.0)
    state = StageState(EVERYTHING, TS_S, 9, 10.0, others[0].tolist())
    readings, true = [state.y_um], [state.true_um]
    for k in range(n - 1):
        readings.append(state.step(float(u_V[k]), others[k].tolist()))
        true.append(state.true_um)
    assert np.array(readings).tobytes() == whole.displacement_um.tobytes()
    assert np.array(true).tobytes() == whole.truth.true_um.tobytes()
    assert whole.truth.outlier.sum() > 10


def test_same_seed_same_bytes_other_seed_other_noise() -> None:
    u_V = drive(2000)
    aux = {"axis2_V": u_V, "axis3_V": u_V}
    first, again, other = (run(EVERYTHING, u_V, TS_S, seed, aux).displacement_um for seed in (4, 4, 5))
    assert first.tobytes() == again.tobytes()
    assert (first != other).mean() > 0.5


def test_readings_are_multiples_of_the_sensors_step_and_end_at_the_converters_range() -> None:
    stage = Stage.nominal().with_effects(noise=0.003)
    y_um = run(stage, drive(5000), TS_S).displacement_um
    codes = y_um / 0.0005
    np.testing.assert_allclose(codes, np.round(codes), atol=1e-9)
    assert len(np.unique(codes.round())) > 1000
    far = run(stage.with_effects(drift=(1000.0, 0.0)), np.full(2000, 20.0), TS_S).displacement_um
    assert far.max() == pytest.approx(13.108 - 16.384 / 2**16, abs=1e-12)
    near = run(stage.with_effects(drift=(-1000.0, 0.0)), np.full(2000, 20.0), TS_S).displacement_um
    assert near.min() == pytest.approx(-3.276, abs=1e-12)


def test_the_dac_has_twenty_bits_and_ends_at_its_range() -> None:
    volts = run(Stage.nominal(), np.linspace(-40.0, 140.0, 5001), TS_S).truth.actuator_V
    codes = (volts + 20.0) / (140.0 / 2**20)
    np.testing.assert_allclose(codes, np.round(codes), atol=1e-6)
    assert volts.min() == -20.0
    assert volts.max() == 120.0


def test_a_voltage_that_is_not_a_number_holds_the_last() -> None:
    good, bad = (StageState(Stage.nominal(), TS_S, rest_V=5.0) for _ in range(2))
    good.step(30.0)
    bad.step(30.0)
    assert bad.step(math.nan) == good.step(30.0)
    assert bad.actuator_V == good.actuator_V


def test_shares_are_the_plant_with_and_without_the_effect() -> None:
    stage = Stage.nominal().with_effects(periodic=(50.0, 0.02), creep=0.02)
    u_V = drive(10_000)
    measured = run(stage, u_V, TS_S)
    shares_um = effect_shares(measured)
    assert set(shares_um) == {"memory", "creep", "periodic"}
    assert shares_um["periodic"] == pytest.approx(0.02 / math.sqrt(2), rel=1e-6)  # 10 whole periods
    plain = (
        run(stage.quiet(), u_V, TS_S).displacement_um
        - run(stage.quiet().with_effects(creep=None), u_V, TS_S).displacement_um
    )
    assert shares_um["creep"] == pytest.approx(float(np.std(plain)), rel=1e-12)
    # Memory's share: the loop over the visited range against its middle; a sine fills about half of its opening.
    _, rising, falling = static_loop(stage, u_V.min(), u_V.max())
    assert 0.2 < shares_um["memory"] / float((falling - rising).max() / 2) < 1.0
    middle = without(stage, "memory", 5.0, 45.0)
    _, up, down = static_loop(middle, 5.0, 45.0)
    np.testing.assert_allclose(up, down, atol=1e-12)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"u_V": np.array([])}, "one row of voltages"),
        ({"u_V": np.array([1.0, math.nan])}, "u_V: holds values that are not finite"),
        ({"u_V": np.ones(3), "Ts_s": 0.0}, "Ts_s: 0.0 s is no sampling period"),
        ({"u_V": np.ones(3), "aux": {"t_C": np.ones(2)}}, "aux t_C: .* for 3 samples"),
        ({"u_V": np.ones(3), "aux": {"t_C": np.array([1.0, 2.0, math.inf])}}, "aux t_C: holds values"),
        ({"u_V": np.ones(3), "seed": -1}, "seed: -1"),
        ({"u_V": np.ones(3), "rest_V": math.nan}, "rest_V: nan"),
    ],
)
def test_input_that_drives_no_stage_is_refused_in_one_line(arguments: dict[str, object], complaint: str) -> None:
    with pytest.raises(StageError, match=complaint) as refusal:
        run(Stage.nominal(), **{"Ts_s": TS_S, **arguments})  # type: ignore[arg-type]
    assert "\n" not in str(refusal.value)


def test_the_bundled_record_is_what_the_stage_makes() -> None:
    assert bundled_csv() == demo_csv()


def test_validation_stays_inside_what_identification_visited_and_drives_otherwise() -> None:
    record, split = demo_measurement(), identification_rows()
    for values in (record.voltage_V, record.displacement_um):
        assert values[:split].min() < values[split:].min()
        assert values[split:].max() < values[:split].max()
    assert record.voltage_V[0] == record.voltage_V[split] == record.voltage_V[-1] == 30.0
    assert len(np.intersect1d(record.voltage_V[:split], record.voltage_V[split:])) < 0.01 * split


ECHO = """
from dataclasses import dataclass
from typing import ClassVar

from hysgen_lab.stage.effects import Action, Effect, Tolerance, require_finite


@dataclass(frozen=True)
class EchoEffect(Effect):
    um_per_V: float

    name = "echo"
    bank_index = 15
    tolerances: ClassVar = {"echo.um_per_V": Tolerance(0.1)}

    def __post_init__(self):
        require_finite(self)

    def action(self, Ts_s, seed, rest_V):
        return _Echo(self.um_per_V, rest_V)

    @classmethod
    def draw(cls, rng, setting):
        return cls(setting.share * setting.span_um / 100.0)

    def true_parameters(self):
        return {"echo.um_per_V": self.um_per_V}


class _Echo(Action):
    def __init__(self, um_per_V, rest_V):
        self.um_per_V, self.past_V = um_per_V, rest_V

    def added_um(self, u_V):
        past_V, self.past_V = self.past_V, u_V
        return self.um_per_V * past_V
"""

BANK = """
import numpy as np
from hysgen_lab.stage import effect_shares, run
from hysgen_lab.studies.bank import scenario
from hysgen.diagnosis.causes import Estimate
from hysgen_lab.studies.bank.judge_records import compare_parameters
from hysgen_lab.studies.bank.judge_records import PARAMETERS

hidden = scenario("echo", 3)
assert hidden.planted == ("memory", "echo"), hidden.planted
(um_per_V,) = (effect.um_per_V for effect in hidden.stage.others)
measured = run(hidden.stage, hidden.u_V, hidden.Ts_s, hidden.seed, hidden.aux)
past_V = np.concatenate([hidden.u_V[:1], hidden.u_V[:1], hidden.u_V[:-2]])
share_um = um_per_V * np.std(past_V)
assert abs(effect_shares(measured)["echo"] / share_um - 1.0) < 1e-6
assert PARAMETERS["echo.um_per_V"] == 0.1
found = {"echo.um_per_V": Estimate(1.05 * um_per_V, 1.0)}
assert abs(compare_parameters(hidden, found)["echo.um_per_V"].error - 0.05) < 1e-12
print(scenario("creep", 3).stage == scenario("creep", 3).stage, np.float64(scenario("creep", 3).u_V.sum()).hex())
"""


@pytest.mark.slow
def test_effect_in_a_new_file_is_planted_drawn_and_compared(tmp_path: Path) -> None:
    for package in ("hysgen", "hysgen_lab"):
        source = Path(hysgen.__file__).parents[1] / package
        shutil.copytree(source, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "hysgen_lab" / "stage" / "effects" / "echo.py").write_text(ECHO)
    done = subprocess.run(
        [sys.executable, "-c", BANK], env={"PYTHONPATH": str(tmp_path)}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["True", np.float64(scenario("creep", 3).u_V.sum()).hex()]


@pytest.fixture(scope="module")
def echo(tmp_path_factory: pytest.TempPathFactory) -> type[Effect]:
    folder = tmp_path_factory.mktemp("effect")
    (folder / "made_up_echo.py").write_text(ECHO)
    sys.path.insert(0, str(folder))
    try:
        found: type[Effect] = importlib.import_module("made_up_echo").EchoEffect
    finally:
        sys.path.remove(str(folder))
    return found


def test_effect_in_python_acts_in_a_run_as_step_by_step(echo: type[Effect]) -> None:
    stage = Stage(memory=None, dac_bits=0, others=(echo(0.01),)).quiet()  # type: ignore[call-arg]
    u_V = 20.0 + 10.0 * np.sin(0.1 * np.arange(300))
    whole = run(stage, u_V, 1e-3, rest_V=5.0)
    state = StageState(stage, 1e-3, rest_V=5.0)
    readings = [state.y_um, *(state.step(float(volts)) for volts in u_V[:-1])]
    assert np.array(readings).tobytes() == whole.displacement_um.tobytes()
    bare = run(Stage(memory=None, dac_bits=0).quiet(), u_V, 1e-3, rest_V=5.0)
    past_V = np.concatenate([[5.0, 5.0], u_V[:-2]])
    # Rounding of one sum at 3 um.
    np.testing.assert_allclose(whole.displacement_um - bare.displacement_um, 0.01 * past_V, atol=1e-14)
    with pytest.raises(StageError, match=r"acts in Python; use step\(\)"):
        _ = state.address


@dataclass(frozen=True)
class Divider(Effect):
    """Of the command only a share arrives at the D/A."""

    share: float

    name = "divider"

    def action(self, Ts_s: float, seed: int, rest_V: float) -> Action:
        return _Divided(self.share)


class _Divided(Action):
    def __init__(self, share: float) -> None:
        self.share = share

    def command_V(self, u_V: float) -> float:
        return self.share * u_V


def test_effect_in_python_changes_the_command_from_rest_on() -> None:
    u_V = 40.0 + 20.0 * np.sin(0.1 * np.arange(200))
    divided = run(dataclasses.replace(Stage.nominal(), others=(Divider(0.5),)), u_V, 1e-3, seed=2)
    half = run(Stage.nominal(), 0.5 * u_V, 1e-3, seed=2)
    assert divided.displacement_um.tobytes() == half.displacement_um.tobytes()
    assert divided.voltage_V.tobytes() == u_V.tobytes()  # the record holds the command
    state = StageState(dataclasses.replace(Stage.nominal(), others=(Divider(0.5),)), 1e-3, seed=2, rest_V=u_V[0])
    state.step(60.0)
    at_V = state.actuator_V
    state.step(math.nan)  # holds the last voltage
    assert state.actuator_V == at_V == StageState(Stage.nominal(), 1e-3, rest_V=30.0).actuator_V
