"""A virtual piezo stage, described by physical constants: what it is made of, and what it suffers from."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

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
    require,
)
from hysgen.stage.hysteresis import Memory, Preisach

# Effects that a stage has or has not; of modes and disturbing lines it may have several.
SINGLE: Mapping[str, type[Any]] = MappingProxyType(
    {
        "bandwidth": Bandwidth,
        "saturation": Saturation,
        "slew": Slew,
        "creep": Creep,
        "delay": Delay,
        "drift": Drift,
        "aging": Aging,
        "outliers": Outliers,
        "coupling": Coupling,
        "stick_slip": StickSlip,
        "noise": Noise,
    }
)
SEVERAL: Mapping[str, type[Any]] = MappingProxyType({"resonance": Resonance, "periodic": Periodic})


@dataclass(frozen=True)
class Stage:
    """A stage: D/A -> amplifier -> hysteresis -> creep -> friction -> modes -> lag -> delay -> sensor -> A/D.

    stroke_um over 0 .. full_V: closed full stroke of the ceramic at low frequency (DC gain stroke_um / full_V).
    lag_s: time constant of the one pole that amplifier, ceramic, stage and sensor make together.
    dac_*, adc_*: ranges and bits of the converters, 0 bits: ideal. sensor_step_um: resolution, 0: ideal.
    history_V: voltages visited, in order, before the record. zero_V: where the sensor reads 0 after them.
    Every effect: None or () is off. `memory` None is a proportional ceramic.
    """

    stroke_um: float = 10.0
    full_V: float = 120.0
    lag_s: float = 1.0e-3
    dac_low_V: float = -20.0
    dac_high_V: float = 120.0
    dac_bits: int = 20
    sensor_step_um: float = 0.0005
    adc_low_um: float = -3.276
    adc_high_um: float = 13.108
    adc_bits: int = 16
    history_V: tuple[float, ...] = (-20.0, 120.0, 0.0)
    zero_V: float = 0.0

    memory: Memory | None = field(default_factory=Preisach)
    bandwidth: Bandwidth | None = None
    saturation: Saturation | None = None
    slew: Slew | None = None
    creep: Creep | None = None
    resonance: tuple[Resonance, ...] = ()
    delay: Delay | None = None
    drift: Drift | None = None
    periodic: tuple[Periodic, ...] = ()
    aging: Aging | None = None
    outliers: Outliers | None = None
    coupling: Coupling | None = None
    stick_slip: StickSlip | None = None
    noise: Noise | None = field(default_factory=Noise)

    def __post_init__(self) -> None:
        require(self.stroke_um > 0 and self.full_V > 0, "Stage: stroke_um and full_V must be above 0")
        require(math.isfinite(self.lag_s) and self.lag_s >= 0, f"Stage.lag_s: {self.lag_s} s; give a time from 0 up")
        require(math.isfinite(self.zero_V), f"Stage.zero_V: {self.zero_V} V is not a voltage; give a finite number")
        require(self.dac_low_V < self.dac_high_V, "Stage: the D/A's range is empty; dac_low_V must be below dac_high_V")
        require(self.adc_low_um < self.adc_high_um, "Stage: the A/D's range is empty; adc_low_um must be below")
        require(len(self.resonance) <= 4 and len(self.periodic) <= 16, "Stage: at most 4 modes and 16 disturbing lines")

    @classmethod
    def nominal(cls) -> Stage:
        """The stage of the paper, section 4: P-885.30 (10 um over 120 V), E-712 controller, and no effect but memory.

        Its one pole of 1 ms (159 Hz) is the bandwidth that Appendix A shows. Sensor noise 0.5 nm rms.
        """
        return cls()

    @classmethod
    def laboratory(cls) -> Stage:
        """The nominal stage with the modest imperfections that any real one has, all at once."""
        return cls().with_effects(
            bandwidth=Bandwidth(10e3),
            slew=Slew(100e3),
            creep=Creep(0.012),
            resonance=Resonance(780.0, 0.03, 0.25),
            drift=Drift(walk_um_per_rt_s=0.0005),
            periodic=Periodic(50.0, 0.002, 0.6),
        )

    def with_effects(self, **effects: object) -> Stage:
        """This stage with effects switched on, changed or (None) off, by name.

        Each value is the effect's dataclass, or the arguments of one: a number, or a tuple of numbers
        (creep=0.03, resonance=(780.0, 0.02), delay=1.6 in samples, coupling={"axis2_V": 0.004}). `resonance` and
        `periodic` also take a list of several. Raises StageError for a name or a value that is none.
        """
        changes: dict[str, Any] = {name: _effect(name, value) for name, value in effects.items()}
        return replace(self, **changes)

    def quiet(self) -> Stage:
        """This stage with an ideal sensor and A/D: no noise, no resolution. What the others do is unchanged."""
        return replace(self, noise=None, sensor_step_um=0.0, adc_bits=0)

    @property
    def active(self) -> tuple[str, ...]:
        """Names of the effects that are on, memory first; `noise` is the sensor's and does not count."""
        names = ("memory", *SINGLE, *SEVERAL)
        return tuple(name for name in names if name != "noise" and getattr(self, name) not in (None, ()))


def _effect(name: str, value: object) -> object:
    """The dataclass, tuple of them, or None that the field `name` of a Stage takes."""
    if name == "memory":
        require(value is None or hasattr(value, "form"), "memory: give Preisach, Relays, BoucWen, Curve or None")
        return value
    if name in SINGLE:
        return None if value is None else _one(name, SINGLE[name], value)
    if name in SEVERAL:
        if value is None or value == ():
            return ()
        several = isinstance(value, list) or (isinstance(value, tuple) and isinstance(value[0], SEVERAL[name] | tuple))
        listed: Any = value if several else [value]
        return tuple(_one(name, SEVERAL[name], item) for item in listed)
    known = ", ".join(("memory", *SINGLE, *SEVERAL))
    raise StageError(f"{name}: no such effect; the stage knows {known}")


def _one(name: str, kind: type[Any], value: Any) -> Any:
    if isinstance(value, kind):
        return value
    try:
        return kind(*value) if isinstance(value, tuple) else kind(value)
    except TypeError as fault:
        raise StageError(f"{name}: {value!r} makes no {kind.__name__}; give what its fields ask") from fault
