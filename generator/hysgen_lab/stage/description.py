"""A virtual piezo stage, described by physical constants: what it is made of, and the effects it suffers from."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from hysgen_lab.stage.effects import Effect, StageError, effects, require
from hysgen_lab.stage.effects.memory import Hysteresis, Preisach
from hysgen_lab.stage.effects.readings import NoiseEffect

E = TypeVar("E", bound=Effect)


@dataclass(frozen=True)
class Stage:
    """A stage: D/A -> amplifier -> hysteresis -> creep -> friction -> modes -> lag -> delay -> sensor -> A/D.

    stroke_um over 0 .. full_V: closed full stroke of the ceramic at low frequency (DC gain stroke_um / full_V).
    lag_s: time constant of the one pole that amplifier, ceramic, stage and sensor make together.
    dac_*, adc_*: ranges and bits of the converters, 0 bits: ideal. sensor_step_um: resolution, 0: ideal.
    history_V: voltages visited, in order, before the record. zero_V: where the sensor reads 0 after them.
    memory: hysteresis of the ceramic, None: proportional. noise: of the sensor, None: without.
    others: all further effects, in the order of their ranks; `with_effects` sets them by name.
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
    memory: Hysteresis | None = field(default_factory=Preisach)
    noise: NoiseEffect | None = field(default_factory=NoiseEffect)
    others: tuple[Effect, ...] = ()

    def __post_init__(self) -> None:
        require(self.stroke_um > 0 and self.full_V > 0, "Stage: stroke_um and full_V must be above 0")
        require(math.isfinite(self.lag_s) and self.lag_s >= 0, f"Stage.lag_s: {self.lag_s} s; give a time from 0 up")
        require(math.isfinite(self.zero_V), f"Stage.zero_V: {self.zero_V} V is not a voltage; give a finite number")
        require(self.dac_low_V < self.dac_high_V, "Stage: the D/A's range is empty; dac_low_V must be below dac_high_V")
        require(self.adc_low_um < self.adc_high_um, "Stage: the A/D's range is empty; adc_low_um must be below")
        for kind in {type(effect) for effect in self.others}:
            count = len(self.of(kind))
            require(count <= kind.most, f"Stage: {count} times {kind.name}; a stage has at most {kind.most}")
        ranked = sorted(self.others, key=lambda effect: (effect.rank, effect.name))
        object.__setattr__(self, "others", tuple(ranked))

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
            bandwidth=10e3,
            slew=100e3,
            creep=0.012,
            resonance=(780.0, 0.03, 0.25),
            drift=(0.0, 0.0005),
            periodic=(50.0, 0.002, 0.6),
        )

    def with_effects(self, **values: object) -> Stage:
        """This stage with effects switched on, changed or (None) off, by name.

        Each value is the effect's dataclass, or the arguments of one: a number, or a tuple of numbers
        (creep=0.03, resonance=(780.0, 0.02), delay=1.6 in samples, coupling={"axis2_V": 0.004}). An effect that a stage
        may have several times also takes a list. Raises StageError for an unknown name or an impossible value.
        """
        parts: dict[str, Any] = {}
        others = self.others
        for name, value in values.items():
            given = _given(name, value)
            if name in (Hysteresis.name, NoiseEffect.name):
                parts[name] = given[0] if given else None
            else:
                others = (*(effect for effect in others if effect.name != name), *given)
        return replace(self, others=others, **parts)

    def quiet(self) -> Stage:
        """This stage with an ideal sensor and A/D: no noise, no resolution. The other effects stay."""
        return replace(self, noise=None, sensor_step_um=0.0, adc_bits=0)

    @property
    def effects(self) -> tuple[Effect, ...]:
        """All effects, memory first."""
        return tuple(effect for effect in (self.memory, *self.others, self.noise) if effect is not None)

    def of(self, kind: type[E]) -> tuple[E, ...]:
        """The effects of a class; () if the stage has none."""
        return tuple(effect for effect in self.effects if isinstance(effect, kind))

    def one(self, kind: type[E]) -> E | None:
        """The first effect of a class; None if the stage has none."""
        return next(iter(self.of(kind)), None)

    @property
    def active(self) -> tuple[str, ...]:
        """Names of the effects that count, each once, in the order of their ranks."""
        return tuple(dict.fromkeys(effect.name for effect in self.effects if effect.active))

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the further channels that act on the stage."""
        return tuple(name for effect in self.effects for name in effect.channels)


def _given(name: str, value: Any) -> tuple[Effect, ...]:
    """The effects made from `value`; () if `value` switches the effect off."""
    known = effects()
    if name not in known:
        raise StageError(f"{name}: no such effect; the stage knows {', '.join(known)}")
    kind = known[name]
    if value is None or value == ():
        return ()
    several = isinstance(value, list) or (isinstance(value, tuple) and isinstance(value[0], kind | tuple))
    return tuple(kind.made(item) for item in (value if several else [value]))
