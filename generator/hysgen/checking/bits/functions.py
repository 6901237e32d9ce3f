"""The compared structs, the functions that step them, the styles of their inputs, equality of runs by induction.

The C runs a chain of samples and records its state after each. The reference takes all recorded states as lanes, steps
each lane by its sample, and must reproduce the next recorded state and the result. If every step agrees from the first
state on, C and reference would have produced the same run of any length, although the reference never ran in sequence.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from hysgen.checking import Host
from hysgen.float32.coefficients import Coefficients, coefficients
from hysgen.float32.reference.instance import Instance
from hysgen.float32.reference.learner import Learner
from hysgen.float32.struct_words import LEARNER_COUNTERS
from hysgen.model.disturbances import Drive
from hysgen.model.model import Model
from hysgen.model.path import applied
from hysgen.model.simulate import simulate
from hysgen.model.structs import COUNTERS

Words = NDArray[np.uint32]
Floats32 = NDArray[np.float32]
Range = tuple[np.float32, np.float32]

CHUNK: Final = 1 << 16
WEAKER: Final = 0.95
"""Gains of the weaker stage, as a share of the model's gains."""
SENSOR_NOISE: Final = 1e-4
"""rms noise of the weaker stage's sensor, as a share of the displacement range."""

Style = Callable[[np.random.Generator, int, int, Range], Words]
"""(rng, index of the first sample, samples, range of the quantity) -> bits, (samples,)."""


def ranges(model: Model) -> Mapping[str, Range]:
    """The range of each quantity that a generated function takes, in its unit."""
    numbers: Coefficients = coefficients(model)
    return {
        "displacement": (numbers.y_min_um, numbers.y_max_um),
        "reference": (numbers.y_min_um, numbers.y_max_um),
        "measured": (numbers.y_min_um, numbers.y_max_um),
        "residual": (-numbers.reach_um, numbers.reach_um),
        "voltage": (numbers.u_min_V, numbers.u_max_V),
        # Wider than the range of most auxiliary channels, so that their clamps act now and then.
        "channel": (np.float32(-10.0), np.float32(50.0)),
    }


def chunks(
    model: Model, style: str, quantities: Sequence[str], samples: int, seed: int, chunk: int = CHUNK
) -> Iterator[list[Words]]:
    """`samples` of each quantity in chunks: the bits of one column per quantity.

    In the random and smooth styles a reference is the model's own next displacement under a random or smooth voltage: a
    reference drawn on its own would nearly always be clamped. A smooth measured displacement is the output of the
    weaker stage under the voltage column, so that the learner has a parameter error to correct.
    """
    rng = np.random.default_rng([seed, *style.encode()])
    range_of = ranges(model)
    reachable = style in ("random", "smooth")
    drawn = ["voltage" if quantity == "reference" and reachable else quantity for quantity in quantities]
    for first in range(0, samples, chunk):
        n = min(chunk, samples - first)
        columns = [STYLES[style](rng, first, n, range_of[quantity]) for quantity in drawn]
        if reachable and "reference" in quantities:
            y, u = (columns[quantities.index(quantity)] for quantity in ("displacement", "reference"))
            columns[quantities.index("reference")] = _next_displacement(model, y, u)
        if style == "smooth" and "measured" in quantities:
            u = columns[quantities.index("voltage")]
            columns[quantities.index("measured")] = weaker_stage(model, u, rng)
        yield columns


def weaker_stage(model: Model, u: Words, rng: np.random.Generator) -> Words:
    """Measured displacement of a plant that is the model with gains WEAKER times as large, at rest in mid-range.

    u: bits of u(k) in V, (n,). Returns the bits of y(k) in um, (n,), with normal noise of SENSOR_NOISE of the range.
    """
    low, high = model.grid.y_min_um, model.grid.y_max_um
    plant = dataclasses.replace(model, consequents=model.consequents * [1.0, WEAKER, 1.0])
    aux = {channel: np.zeros(u.size) for channel in model.channels}
    drive = Drive(u.view(np.float32).astype(np.float64), model.Ts_s, aux)
    y_um = simulate(plant, drive, 0.5 * (low + high)).y_um
    noise_um = SENSOR_NOISE * (high - low) * rng.standard_normal(y_um.size)
    return (y_um + noise_um).astype(np.float32).view(np.uint32)


def _next_displacement(model: Model, y: Words, u: Words) -> Words:
    """y(k+1) of the model from y(k) under u(k): its path along all of u, its terms at rest."""
    if model.responds:
        u_V = np.clip(u.view(np.float32).astype(np.float64), model.u_min_V, model.u_max_V)
        u = applied(model.blocks, u_V, model.Ts_s, model.w_range).astype(np.float32).view(np.uint32)
        model = model.behind_path
    at_rest = Instance(model, y.view(np.float32), np.zeros(y.size, dtype=np.float32))
    return at_rest.predict(y.view(np.float32), u.view(np.float32)).view(np.uint32)


def _random(rng: np.random.Generator, first: int, n: int, limits: Range) -> Words:
    """Uniform over the range and 15 % of its width beyond either end."""
    low, high = (float(end) for end in limits)
    beyond = 0.15 * (high - low)
    return rng.uniform(low - beyond, high + beyond, n).astype(np.float32).view(np.uint32)


def _smooth(rng: np.random.Generator, first: int, n: int, limits: Range) -> Words:
    """Signals of a running controller: slow modulated sines with little noise, constant in one block of five."""
    low, high = (float(end) for end in limits)
    k = np.arange(first, first + n, dtype=np.float64)
    phase = 2.0 * np.pi * k / rng.uniform(200.0, 5000.0)
    swing = 0.5 + 0.45 * np.sin(phase) * np.cos(0.01 * phase)
    value = low + (high - low) * (swing + rng.normal(0.0, 1e-4, n))
    value[(k // 3000) % 5 == 4] = value[0]
    return np.asarray(value.astype(np.float32).view(np.uint32))


def _edges(rng: np.random.Generator, first: int, n: int, limits: Range) -> Words:
    """Zeros, denormals, the range's ends and their neighbours, huge values, infinities and NaN, in runs of 1 to 8."""
    special = _special_values(limits)
    picked = rng.integers(0, special.size, n)
    held = np.maximum.accumulate(np.where(rng.random(n) < 0.7, np.arange(n), 0))
    ordinary = _random(rng, first, n, limits)
    return np.where(rng.random(n) < 0.6, special[picked[held]], ordinary)


def _patterns(rng: np.random.Generator, first: int, n: int, limits: Range) -> Words:
    """Uniform 32-bit patterns."""
    return rng.integers(0, 1 << 32, n, dtype=np.uint32)


def _special_values(limits: Range) -> Words:
    infinity = np.float32(np.inf)
    tiny = [2.0**-149, 2.0**-127, 2.0**-126, 2.0**-41, 2.0**-40, 2.0**-39]
    numbers = [0.0, *tiny, 1.0, 1e9, 3e38, np.inf, *limits, 0.5 * (float(limits[0]) + float(limits[1]))]
    around = [np.nextafter(end, way) for end in limits for way in (-infinity, infinity)]
    floats = np.array([*numbers, *around], dtype=np.float32)
    # NaN of either sign, quiet and signalling, with full and with empty payloads.
    nans = np.array([0x7FC00000, 0xFFC00000, 0x7F800001, 0xFFBFFFFF, 0x7FFFFFFF], dtype=np.uint32)
    return np.concatenate([floats.view(np.uint32), (-floats).view(np.uint32), nans])


STYLES: Final[Mapping[str, Style]] = {"random": _random, "smooth": _smooth, "edges": _edges, "patterns": _patterns}
SHARES: Final[Mapping[str, float]] = {"random": 0.25, "smooth": 0.4, "edges": 0.2, "patterns": 0.15}
"""Share of the samples per style; the smooth style gets most because it makes the longest meaningful run."""
LEARNING_SHARE: Final = 0.1
"""Samples of `learn` as a share of another function's, off the host: its state has hundreds of words to compare."""


START_UM: Final = np.float32(0.0)
START_V: Final = np.float32(0.0)
NEARLY_FULL: Final = 0xFFFFFF00
"""A counter value close to the saturation of uint32."""
QUIET_NAN: Final = 0x7FC00000


class Lanes(Protocol):
    """A reference that steps many independent states at once; its methods bear the names of the C functions."""

    def words(self) -> Mapping[str, Words]:
        """Every compared word of the struct by name, in the order of the C, (lanes,) each."""
        ...

    def restore(self, words: Sequence[Words]) -> None:
        """Set all states from their words in the same order, (lanes,) each."""
        ...


@dataclass(frozen=True)
class ComparedStruct:
    """A generated struct and the functions that step it.

    type_suffix: its C type without the model's name. functions: the quantity of each float argument (see `inputs`), by
    function. first_word: C path of the first compared word; the reference's `words` give their number.
    create: a new struct initialised by the C. reference: the same initial state in NumPy, one lane.
    wear: writes the state of a struct after months of operation: counters near saturation.
    has_channels: whether its functions read the model's auxiliary channels. chunk: samples recorded at once; smaller
    for a large state.
    """

    type_suffix: str
    functions: Mapping[str, tuple[str, ...]]
    first_word: str
    create: Callable[[Host], Any]
    reference: Callable[[Model], Lanes]
    wear: Callable[[Host, Any], None]
    has_channels: bool
    chunk: int = CHUNK

    def quantities(self, function: str, host: Host) -> list[str]:
        """The quantity of each argument of `function`, then "channel" for each auxiliary channel of the model."""
        return [*self.functions[function], *(["channel"] * host.channels if self.has_channels else [])]


def _instance(model: Model) -> Lanes:
    return Instance(model, np.full(1, START_UM), np.full(1, START_V))


def _wear_instance(host: Host, struct: Any) -> None:
    """Counters near saturation, the second bank active, the first bank full of NaN; limits of the inverse that act."""
    words, layout = host.words_of(struct), host.layout(f"{host.name}_t")
    for name in COUNTERS:
        words[layout[name]] = NEARLY_FULL
    for path, place in layout.items():
        if path.startswith("bank[0]"):
            words[place] = QUIET_NAN
    words[layout["active"]] = 1
    low, high = (words[layout[name] :].view(np.float32)[0] for name in ("low_V", "high_V"))
    quarter = np.float32(0.25) * (high - low)
    limits = np.array([low + quarter, high - quarter, quarter / np.float32(16.0)], np.float32)
    for name, limit in zip(("low_V", "high_V", "step_V"), limits.view(np.uint32), strict=True):
        words[layout[name]] = limit


def _new_learner(host: Host) -> Any:
    learner = host.struct(f"{host.name}_learner_t")
    host.call("learn_init", learner, host.instance(float(START_UM), float(START_V)))
    return learner


def _learner(model: Model) -> Lanes:
    return Learner(model, Instance(model, np.full(1, START_UM), np.full(1, START_V)))


def _wear_learner(host: Host, struct: Any) -> None:
    """Counters and the age of the shadow near saturation, and a trial under way."""
    words, layout = host.words_of(struct), host.layout(f"{host.name}_learner_t")
    for name in (*LEARNER_COUNTERS, "age", "trying"):
        words[layout[name]] = NEARLY_FULL


MODEL: Final = ComparedStruct(
    type_suffix="t",
    functions={
        "init": ("displacement", "voltage"),
        "predict": ("displacement", "voltage"),
        "simulate": ("voltage",),
        "limits": ("voltage", "voltage", "voltage"),
        "inverse": ("displacement", "reference"),
        "correct": ("residual",),
    },
    first_word="y_um",
    create=lambda host: host.instance(float(START_UM), float(START_V)),
    reference=_instance,
    wear=_wear_instance,
    has_channels=True,
)

LEARNER: Final = ComparedStruct(
    type_suffix="learner_t",
    functions={"learn": ("measured", "voltage")},
    first_word="d[0]",
    create=_new_learner,
    reference=_learner,
    wear=_wear_learner,
    has_channels=False,
    chunk=1 << 12,
)

COMPARED_STRUCTS: Final[list[ComparedStruct]] = [MODEL, LEARNER]
"""Every compared struct; functions that the generated header does not declare are skipped."""


@dataclass(frozen=True)
class CallTrace:
    """A recorded chain of n calls of one function, as bit patterns.

    inputs, aux: arguments and auxiliary channels, (n,) each. before, after: (n, words) states before and after each
    call. results: (n,), 0 where the function returns nothing.
    """

    inputs: Sequence[Words]
    aux: Sequence[Words]
    before: Words
    results: Words
    after: Words

    def equals(self, other: CallTrace) -> bool:
        """Whether two traces of the same inputs agree in every state and result."""
        pairs = ((self.before, other.before), (self.results, other.results), (self.after, other.after))
        return all(np.array_equal(mine, theirs) for mine, theirs in pairs)


@dataclass(frozen=True)
class Difference:
    """The first sample at which C and reference differ: the word that differs, and its bits.

    place: index of the word in the state; None for the result.
    """

    sample: int
    place: int | None
    got: int
    expected: int


def first_difference(lanes: Lanes, function: str, trace: CallTrace) -> Difference | None:
    """The first difference between a recorded run of `function` and the reference, or None."""
    with np.errstate(all="ignore"):
        lanes.restore(list(np.ascontiguousarray(trace.before.T)))
        if trace.aux:
            lanes.aux([column.view(np.float32) for column in trace.aux])  # type: ignore[attr-defined]
        result = getattr(lanes, function)(*(column.view(np.float32) for column in trace.inputs))
    expected = np.zeros_like(trace.results) if result is None else result.view(np.uint32)
    difference = _earlier(None, None, trace.results, expected)
    for place, word in enumerate(lanes.words().values()):
        difference = _earlier(difference, place, trace.after[:, place], word)
    return difference


def _earlier(difference: Difference | None, place: int | None, got: Words, expected: Words) -> Difference | None:
    """`difference`, or the first difference of this word if it comes at an earlier sample."""
    wrong = np.flatnonzero(got != expected)
    if not wrong.size or (difference is not None and difference.sample <= wrong[0]):
        return difference
    sample = int(wrong[0])
    return Difference(sample, place, int(got[sample]), int(expected[sample]))
