"""A running stage: the compiled plant, advanced sample by sample or over a whole record.

The mesh inside one D/A period: where the signals of the plant are evaluated.
"""

import functools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.machine import native
from hysgen_lab.stage.description import Stage
from hysgen_lab.stage.effects import Action, Linear, Period, StageError, effects, require
from hysgen_lab.stage.effects.memory import GRID_LOW_V, GRID_STEP_V, KIND_EVERETT, KIND_MESH, straight

Floats = NDArray[np.float64]

FINEST_S = 4e-6  # first substep behind the D/A's instant, where a fast amplifier bends most: 250 kHz
GROWTH = 0.05  # a substep t after the D/A's instant is at most this share of t


@dataclass(frozen=True)
class Mesh:
    """Substeps h_s of one sampling period; the A/D's sample is taken after substep `tap`, `late` periods on."""

    h_s: Floats
    tap: int
    late: int


def mesh(stage: Stage, Ts_s: float) -> Mesh:
    """The instants between two D/A instants at which the signals are evaluated.

    With an ideal amplifier, which holds its voltage, one substep is exact. Where an effect bends the amplifier's output
    after a D/A instant, the mesh is fine there and grows with time. A fractional delay of the reading adds a node.
    """
    require(math.isfinite(Ts_s) and Ts_s > 0, f"Ts_s: {Ts_s} s is no sampling period; give a time above 0")
    late_s = sum(effect.late_s(Ts_s) for effect in stage.effects)
    # A rounding error short of a whole number of periods is that whole number.
    periods = math.floor(late_s / Ts_s + 1e-9)
    tap_s = Ts_s - max(late_s - periods * Ts_s, 0.0)
    longest_s = min((effect.longest_substep_s for effect in stage.effects), default=math.inf)
    bends = any(effect.bends_amplifier for effect in stage.effects)
    nodes = [0.0]
    while nodes[-1] < Ts_s * (1 - 1e-9):
        h_s = min(max(FINEST_S, GROWTH * nodes[-1]), longest_s) if bends else longest_s
        # Equal pieces up to the end, so that no sliver is left.
        left_s = Ts_s - nodes[-1]
        nodes.append(nodes[-1] + left_s / max(1, math.ceil(left_s / h_s - 1e-9)))
    nodes[-1] = Ts_s
    if min(abs(node - tap_s) for node in nodes) > 1e-9 * Ts_s:
        nodes = sorted([*nodes, tap_s])
    tap = int(np.argmin(np.abs(np.array(nodes) - tap_s))) - 1
    return Mesh(np.diff(np.array(nodes)), tap, periods)


SOURCES = ("plant.h", "hysteresis.c", "preisach_mesh.c", "jiles_atherton.c", "thermal.c", "plant.c")
TURNS = 65536  # capacity for nested turning points
CALLED = ("hysteresis_clear", "hysteresis_move", "hysteresis_path", "plant_rest", "plant_run", "plant_step")
OUT_OF_MEMORY = f"voltage: more than {TURNS} nested turning points; shorten the record or stop its amplitude's decay"


@functools.cache
def plant() -> native.Library:
    """The compiled plant. Raises BuildError where no C compiler is installed."""
    texts = [(name, resources.files(__package__).joinpath(name).read_text(encoding="utf-8")) for name in SOURCES]
    directives = ("#define HYSGEN_STAGE", "#ifndef", "#endif")
    header = "\n".join(line for line in texts[0][1].splitlines() if not line.startswith(directives))
    return native.build(texts, header, called=CALLED)


@dataclass(frozen=True)
class PlantOutput:
    """The signals of a run, each (n,): readings, true displacement, voltage across the ceramic, drift, outliers."""

    reading_um: Floats
    true_um: Floats
    actuator_V: Floats
    drift_um: Floats
    outlier: NDArray[np.bool_]


class StageState:
    """A running stage, in equilibrium at `rest_V` before the first step.

    y_um is the reading at the present instant; `step(u_V)` holds u_V for one period and returns the reading at its end:
    a controller reads y(k), computes u(k), and gets y(k+1). The same inputs give the same readings as `run`.
    channels: values of `stage.channels` during the period; without new values the last ones hold.
    Raises StageError for an impossible sampling period, rest voltage or number of channels.
    """

    def __init__(
        self, stage: Stage, Ts_s: float, seed: int = 0, rest_V: float = 0.0, channels: Sequence[float] = ()
    ) -> None:
        require(math.isfinite(rest_V), f"rest_V: {rest_V} is not a voltage; give a finite number")
        require(seed >= 0, f"seed: {seed} is below 0; give a whole number from 0 up")
        self.stage = stage
        self._library = plant()
        self._ffi = self._library.ffi
        self._kept: list[object] = []
        self._plant = self._ffi.new("plant_t *")
        self._plant_step = self._library.lib.plant_step
        cells = mesh(stage, Ts_s)
        self._fill_converters(cells, Ts_s, seed)
        self._fill_effects(Period(Ts_s, cells.h_s, stage.lag_s))
        _fill_hysteresis(self._library, self._plant.hysteresis, stage, self._kept)
        self._set_channels(channels if len(channels) else (0.0,) * self._plant.channels)
        started = [effect.action(Ts_s, seed, rest_V) for effect in stage.effects]
        self._actions: list[Action] = [action for action in started if action is not None]
        self._given_V = rest_V
        self._library.lib.plant_rest(self._plant, self._commanded_V(rest_V))

    @property
    def y_um(self) -> float:
        """The A/D's reading at the present instant."""
        return float(self._plant.reading_um)

    @property
    def true_um(self) -> float:
        """The displacement at the present instant, before sensor noise, outliers and quantisation."""
        return float(self._plant.true_um)

    @property
    def actuator_V(self) -> float:
        """The voltage across the ceramic at the present instant."""
        return float(self._plant.hysteresis.u_V)

    @property
    def address(self) -> tuple[int, int]:
        """Addresses of the compiled step, `double (*)(void *plant, double u_V)`, and of its plant, for driving C code.

        Raises StageError if an effect acts in Python: the compiled step does not contain it.
        """
        require(not self._actions, "address: an effect of this stage acts in Python; use step()")
        lib, ffi = self._library.lib, self._ffi
        step = ffi.addressof(lib, "plant_step")
        return int(ffi.cast("uintptr_t", step)), int(ffi.cast("uintptr_t", self._plant))

    def step(self, u_V: float, channels: Sequence[float] = ()) -> float:
        """Hold u_V for one sampling period; returns the reading at its end in um. A NaN holds the last voltage.

        Raises StageError when the hysteresis runs out of memory for turning points.
        """
        if channels:
            self._set_channels(channels)
        y_um: float = self._plant_step(self._plant, self._commanded_V(u_V) if self._actions else u_V)
        if y_um != y_um:
            raise StageError(OUT_OF_MEMORY)
        return y_um

    def advance(self, u_V: Floats, channels: Floats) -> PlantOutput:
        """Run the command u_V (n,) with channels (n, c): row k is read when u_V[k] is put out; u_V[n-1] is not held.

        Raises StageError when the hysteresis runs out of memory for turning points.
        """
        n = len(u_V)
        volts = np.ascontiguousarray(u_V, dtype=np.float64)
        others = np.ascontiguousarray(channels, dtype=np.float64)
        reading, true, actuator, drift = (np.empty(n) for _ in range(4))
        outlier = np.empty(n, dtype=np.uint8)
        columns = (reading, true, actuator, drift, outlier)
        if not self._actions:
            self._run(volts, others, columns)
            return PlantOutput(reading, true, actuator, drift, outlier.astype(np.bool_))
        for k in range(n):
            self._run(volts[k : k + 1], others[k : k + 1], tuple(column[k : k + 1] for column in columns))
            if k < n - 1:
                self.step(float(volts[k]), others[k].tolist())
        return PlantOutput(reading, true, actuator, drift, outlier.astype(np.bool_))

    def _run(self, u_V: Floats, channels: Floats, columns: tuple[NDArray[Any], ...]) -> None:
        """`plant_run` into `columns`; a run of one sample reads the present instant and does not advance the plant."""
        pointers = [_pointer(self._library, array) for array in (u_V, channels, *columns)]
        if self._library.lib.plant_run(self._plant, len(u_V), *pointers):
            raise StageError(OUT_OF_MEMORY)

    def _commanded_V(self, u_V: float) -> float:
        """The voltage for the D/A, changed by the effects in Python; sets the displacement that they add."""
        if u_V == u_V:
            self._given_V = u_V
        given_V = commanded_V = self._given_V
        for action in self._actions:
            commanded_V = action.command_V(commanded_V)
        self._plant.added_um = sum(action.added_um(given_V) for action in self._actions)
        return commanded_V

    def _keep(self, array: NDArray[Any]) -> object:
        """A pointer to a copy of `array` that lives as long as this state."""
        return _kept_pointer(self._library, self._kept, array)

    def _set_channels(self, values: Iterable[float]) -> None:
        given = list(values)
        count = self._plant.channels
        require(len(given) == count, f"channels: {len(given)} values for {count} coupled channels; give one for each")
        for i, value in enumerate(given):
            self._plant.channel[i] = value

    def _fill_linear(self, place: Any, part: Linear) -> None:
        place.n, place.d = len(part.c), part.d
        place.phi, place.g0, place.g1 = self._keep(part.phi), self._keep(part.g0), self._keep(part.g1)
        place.c, place.rest = self._keep(part.c), self._keep(part.rest)
        place.x = self._keep(np.zeros(len(part.c)))

    def _fill_converters(self, cells: Mesh, Ts_s: float, seed: int) -> None:
        """Set timing, D/A, sensor and A/D."""
        p, stage = self._plant, self.stage
        p.Ts_s, p.substeps, p.tap, p.late = Ts_s, len(cells.h_s), cells.tap, cells.late
        p.h_s, p.ring = self._keep(cells.h_s), self._keep(np.zeros(cells.late + 1))
        p.dac_low_V, p.dac_high_V = stage.dac_low_V, stage.dac_high_V
        p.dac_step_V = (stage.dac_high_V - stage.dac_low_V) / 2**stage.dac_bits if stage.dac_bits else 0.0
        p.sensor_step_um, p.adc_low_um, p.adc_codes = stage.sensor_step_um, stage.adc_low_um, float(2**stage.adc_bits)
        p.adc_step_um = (stage.adc_high_um - stage.adc_low_um) / p.adc_codes if stage.adc_bits else 0.0
        p.seed = seed % 2**64

    def _fill_effects(self, period: Period) -> None:
        """Set the constants of the effects that act in the compiled plant."""
        for kind in effects().values():
            for member, value in kind.constants(self.stage.of(kind), period).items():
                if isinstance(value, Linear):
                    self._fill_linear(getattr(self._plant, member), value)
                else:
                    setattr(self._plant, member, self._keep(value) if isinstance(value, np.ndarray) else value)


def static_path(stage: Stage, u_V: Floats) -> Floats:
    """w(u) in um, (n,): the hysteresis alone along the path u_V (n,), after the stage's voltage history."""
    library, owned = plant(), list[object]()
    place = library.ffi.new("hysteresis_t *")
    _fill_hysteresis(library, place[0], stage, owned)
    path, w_um = np.ascontiguousarray(u_V, dtype=np.float64), np.empty(len(u_V))
    library.lib.hysteresis_path(place, len(path), _pointer(library, path), _pointer(library, w_um))
    if place.failed:
        raise StageError(OUT_OF_MEMORY)
    return w_um


def _fill_hysteresis(library: native.Library, place: Any, stage: Stage, owned: list[object]) -> None:
    """Set the constants of the hysteresis, its state after the voltage history, and the sensor's zero."""
    form = (stage.memory or straight(stage.stroke_um, stage.full_V)).form(stage.stroke_um, stage.full_V)
    place.kind = form.kind
    place.grid_low_V, place.grid_step_V = GRID_LOW_V, GRID_STEP_V
    for name, value in form.scalars.items():
        setattr(place, name, value)
    for name, array in form.arrays.items():
        setattr(place, name, _kept_pointer(library, owned, array))
    place.capacity = TURNS
    if form.kind in (KIND_EVERETT, KIND_MESH):
        place.turns = _kept_pointer(library, owned, np.empty((TURNS, 5)))
    lib, here = library.lib, library.ffi.addressof(place)
    lib.hysteresis_clear(here)
    for u_V in (*stage.history_V, stage.zero_V):
        lib.hysteresis_move(here, u_V)
    offset_um = place.w_um
    place.offset_um = offset_um
    lib.hysteresis_clear(here)
    for u_V in stage.history_V:
        lib.hysteresis_move(here, u_V)


def _pointer(library: native.Library, array: NDArray[Any]) -> object:
    kinds = {"f": "double *", "i": "int *", "u": "unsigned char *"}
    return library.ffi.cast(kinds[array.dtype.kind], array.ctypes.data)


def _kept_pointer(library: native.Library, owned: list[object], array: NDArray[Any]) -> object:
    copy = np.array(array, order="C")
    owned.append(copy)
    return _pointer(library, copy)
