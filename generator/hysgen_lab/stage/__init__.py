"""A virtual piezo stage: the plant for tests, tutorial and the bundled record.

The plant has its own equations: Preisach or Bouc-Wen hysteresis, logarithmic creep, modes and converters in continuous
time. It shares no equation and no constant with the models that are fitted to its records; neither imports the other.
"""

from hysgen_lab.stage.description import Stage
from hysgen_lab.stage.effects import Effect, StageError, effects
from hysgen_lab.stage.effects.amplifier import SaturationEffect
from hysgen_lab.stage.effects.mechanics import CreepEffect, ResonanceEffect, StickSlipEffect
from hysgen_lab.stage.effects.memory import BoucWen, Curve, Density, Hysteresis, Preisach, Relays
from hysgen_lab.stage.effects.readings import DelayEffect, NoiseEffect, PeriodicEffect
from hysgen_lab.stage.measure import Measurement, effect_shares, run, static_loop, without
from hysgen_lab.stage.state import StageState, static_path

__all__ = [
    "BoucWen",
    "CreepEffect",
    "Curve",
    "DelayEffect",
    "Density",
    "Effect",
    "Hysteresis",
    "Measurement",
    "NoiseEffect",
    "PeriodicEffect",
    "Preisach",
    "Relays",
    "ResonanceEffect",
    "SaturationEffect",
    "Stage",
    "StageError",
    "StageState",
    "StickSlipEffect",
    "effect_shares",
    "effects",
    "run",
    "static_loop",
    "static_path",
    "without",
]
