"""An effect in a file of its own is found, planted and drawn like those that ship, though no other file names it."""

from __future__ import annotations

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

import hysgen
from hysgen_lab.stage import Stage, StageError, StageState, run
from hysgen_lab.stage.effects import Action, Effect
from hysgen_lab.studies.bank import scenario

ECHO = """
from dataclasses import dataclass
from typing import ClassVar

from hysgen_lab.stage.effects.base import Action, Effect, Tolerance, require_finite


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


EFFECT = EchoEffect
"""

BANK = """
import numpy as np
from hysgen_lab.stage import effect_shares, run
from hysgen_lab.studies.bank import scenario
from hysgen_lab.studies.bank.judge_records import parameter_errors
from hysgen_lab.studies.bank.limits import PARAMETERS

hidden = scenario("echo", 3)
assert hidden.planted == ("memory", "echo"), hidden.planted
(um_per_V,) = (effect.um_per_V for effect in hidden.stage.others)
measured = run(hidden.stage, hidden.u_V, hidden.Ts_s, hidden.seed, hidden.aux)
past_V = np.concatenate([hidden.u_V[:1], hidden.u_V[:1], hidden.u_V[:-2]])
share_um = um_per_V * np.std(past_V)
assert abs(effect_shares(measured)["echo"] / share_um - 1.0) < 1e-6
assert PARAMETERS["echo.um_per_V"] == 0.1
assert abs(parameter_errors(hidden, {"echo.um_per_V": 1.05 * um_per_V})["echo.um_per_V"] - 0.05) < 1e-12
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
        found: type[Effect] = importlib.import_module("made_up_echo").EFFECT
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
