"""A virtual piezo stage: the plant for tests, tutorial and the bundled record.

It is physics of its own: Preisach or Bouc-Wen hysteresis, logarithmic creep, modes and converters in continuous time.
It shares no equation and no constant with the models that are fitted to its records, and neither imports the other.
"""

from hysgen.stage.description import Stage
from hysgen.stage.effects import Effect, StageError, effects
from hysgen.stage.effects.aging import Aging
from hysgen.stage.effects.bandwidth import Bandwidth
from hysgen.stage.effects.coupling import Coupling
from hysgen.stage.effects.creep import Creep
from hysgen.stage.effects.delay import Delay
from hysgen.stage.effects.drift import Drift
from hysgen.stage.effects.memory import BoucWen, Curve, Density, Hysteresis, Preisach, Relays
from hysgen.stage.effects.noise import Noise
from hysgen.stage.effects.outliers import Outliers
from hysgen.stage.effects.periodic import Periodic
from hysgen.stage.effects.resonance import Resonance
from hysgen.stage.effects.saturation import Saturation
from hysgen.stage.effects.slew import Slew
from hysgen.stage.effects.stick_slip import StickSlip
from hysgen.stage.measure import Measurement, Truth, effect_shares, run, static_loop, without
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
    "Effect",
    "Hysteresis",
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
    "effect_shares",
    "effects",
    "run",
    "static_loop",
    "static_path",
    "without",
]
