"""The extension of a plant whose parameters are known: what a diagnosis should find."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from hysgen.diagnosis.causes.creep import PER_DECADE, CreepPart
from hysgen.diagnosis.extension import Extension
from hysgen.fitting import PathSize
from hysgen.model.disturbances import Term
from hysgen.model.disturbances.coupling import Coupling
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.part import Mode
from hysgen.model.path import InputBlock
from hysgen.model.path.delay import Delay
from hysgen.model.path.modes import Modes
from hysgen.model.path.saturation import Saturation
from hysgen.model.path.slew import Slew


def true_extension(
    cause: str, parameters: Mapping[str, float], ranges: Mapping[str, tuple[float, float]], span_s: float, lag_s: float
) -> Extension | None:
    """The extension with the true parameters of a plant, by "cause.parameter"; None if it changes the record alone.

    ranges: of the channels that act. span_s: length of the record. lag_s: of the stage.
    """

    def own(*names: str) -> list[float]:
        return [parameters[f"{cause}.{name}"] for name in names]

    made: dict[str, Callable[[], InputBlock | Term]] = {
        "coupling": lambda: Coupling.of(ranges),
        "periodic": lambda: Periodic(tuple(own("f_Hz"))),
        "resonance": lambda: Modes.of([Mode(*own("f_Hz", "zeta", "share"))], lag_s),
        "creep": lambda: CreepPart(own("per_decade")[0], own("from_s")[0]).slow_states(span_s, PER_DECADE),
        "delay": lambda: Delay(*own("delay_samples")),
        "slew": lambda: Slew(*own("rate_V_per_s", "rate_V_per_s")),
        "saturation": lambda: Saturation(*own("low_V", "high_V")),
    }
    if cause not in made:
        return Extension(size=PathSize(), lag_s=lag_s) if cause == "memory" else None
    part = made[cause]()
    return Extension(term=part) if isinstance(part, Term) else Extension(block=part, lag_s=lag_s)
