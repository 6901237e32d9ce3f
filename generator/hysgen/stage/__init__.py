"""A virtual piezo stage: the plant for tests, tutorial and the bundled record.

The plant has its own equations: Preisach or Bouc-Wen hysteresis, logarithmic creep, modes and converters in continuous
time. It shares no equation and no constant with the models that are fitted to its records; neither imports the other.
"""

from hysgen.stage.description import Stage
from hysgen.stage.effects import Effect, StageError, effects
from hysgen.stage.effects.aging import AgingEffect
from hysgen.stage.effects.bandwidth import BandwidthEffect
from hysgen.stage.effects.coupling import CouplingEffect
from hysgen.stage.effects.creep import CreepEffect
from hysgen.stage.effects.delay import DelayEffect
from hysgen.stage.effects.drift import DriftEffect
from hysgen.stage.effects.memory import BoucWen, Curve, Density, Hysteresis, Preisach, Relays
from hysgen.stage.effects.noise import NoiseEffect
from hysgen.stage.effects.outliers import OutliersEffect
from hysgen.stage.effects.periodic import PeriodicEffect
from hysgen.stage.effects.resonance import ResonanceEffect
from hysgen.stage.effects.saturation import SaturationEffect
from hysgen.stage.effects.slew import SlewEffect
from hysgen.stage.effects.stick_slip import StickSlipEffect
from hysgen.stage.measure import Measurement, Truth, effect_shares, run, static_loop, without
from hysgen.stage.state import StageState, static_path

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
