"""A virtual piezo stage: the plant for tests, tutorial and the bundled record.

The plant has its own equations: Preisach or Bouc-Wen hysteresis, logarithmic creep, modes and converters in continuous
time. It shares no equation and no constant with the models that are fitted to its records; neither imports the other.
"""

from hysgen_lab.stage.description import Stage
from hysgen_lab.stage.effects import Effect, StageError, effects
from hysgen_lab.stage.effects.aging import AgingEffect
from hysgen_lab.stage.effects.bandwidth import BandwidthEffect
from hysgen_lab.stage.effects.coupling import CouplingEffect
from hysgen_lab.stage.effects.creep import CreepEffect
from hysgen_lab.stage.effects.delay import DelayEffect
from hysgen_lab.stage.effects.drift import DriftEffect
from hysgen_lab.stage.effects.memory import BoucWen, Curve, Density, Hysteresis, Preisach, Relays
from hysgen_lab.stage.effects.noise import NoiseEffect
from hysgen_lab.stage.effects.outliers import OutliersEffect
from hysgen_lab.stage.effects.periodic import PeriodicEffect
from hysgen_lab.stage.effects.resonance import ResonanceEffect
from hysgen_lab.stage.effects.saturation import SaturationEffect
from hysgen_lab.stage.effects.slew import SlewEffect
from hysgen_lab.stage.effects.stick_slip import StickSlipEffect
from hysgen_lab.stage.measure import Measurement, Truth, effect_shares, run, static_loop, without
from hysgen_lab.stage.state import StageState, static_path

__all__ = [
    "AgingEffect",
    "BandwidthEffect",
    "BoucWen",
    "CouplingEffect",
    "CreepEffect",
    "Curve",
    "DelayEffect",
    "Density",
    "DriftEffect",
    "Effect",
    "Hysteresis",
    "Measurement",
    "NoiseEffect",
    "OutliersEffect",
    "PeriodicEffect",
    "Preisach",
    "Relays",
    "ResonanceEffect",
    "SaturationEffect",
    "SlewEffect",
    "Stage",
    "StageError",
    "StageState",
    "StickSlipEffect",
    "Truth",
    "effect_shares",
    "effects",
    "run",
    "static_loop",
    "static_path",
    "without",
]
