"""A virtual piezo stage: the plant for tests, tutorial and the bundled record.

It is physics of its own: Preisach or Bouc-Wen hysteresis, logarithmic creep, modes and converters in continuous time.
It shares no equation and no constant with the models that are fitted to its records, and neither imports the other.
"""

from hysgen.stage.description import Stage
from hysgen.stage.effects import (
    Aging,
    Bandwidth,
    Coupling,
    Creep,
    Delay,
    Drift,
    Noise,
    Outliers,
    Periodic,
    Resonance,
    Saturation,
    Slew,
    StageError,
    StickSlip,
)
from hysgen.stage.hysteresis import BoucWen, Curve, Density, Preisach, Relays
from hysgen.stage.measure import Measurement, Truth, run, static_loop, without
from hysgen.stage.state import StageState, static_path

__all__ = [
    "Aging",
    "Bandwidth",
    "BoucWen",
    "Coupling",
    "Creep",
    "Curve",
    "Delay",
    "Density",
    "Drift",
    "Measurement",
    "Noise",
    "Outliers",
    "Periodic",
    "Preisach",
    "Relays",
    "Resonance",
    "Saturation",
    "Slew",
    "Stage",
    "StageError",
    "StageState",
    "StickSlip",
    "Truth",
    "run",
    "static_loop",
    "static_path",
    "without",
]
