"""The certified box: for every float of a generated instance, the interval that it never leaves.

The proof assumes the box of the state before a call and demands it afterwards: so it holds for ever. It is derived from
the model: ranges, limits of blocks, half-widths, and for y_um the convexity of Eq. (4),

    min_l (q_l1 y + q_l2 v + q_l3)  <=  sum_l p_l (q_l1 y + q_l2 v + q_l3)  <=  max_l (q_l1 y + q_l2 v + q_l3)

widened by WIDENED for rounding and for what an analysis by intervals cannot see. Flags, counters and phases may be
anything.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from hysgen.checking.proof.eva.intervals import Interval, symmetric
from hysgen.errors import ModelError
from hysgen.float32.coefficients import coefficients
from hysgen.model.model import Model
from hysgen.model.terms.twofloat import LIMIT

WIDENED: Final = 0.5
"""By this part of its width the interval of a sum over the rules is widened on either side."""

KEPT: Final = float(LIMIT)
"""The generated code keeps accumulated states below this magnitude ..."""

KEPT_LOW: Final = KEPT
"""... and what their rounding loses is smaller than this."""


@dataclass(frozen=True)
class TermBox:
    """State of a term by C path inside its struct, and the largest magnitude of each regressor."""

    state: Mapping[str, Interval]
    regressors: tuple[float, ...]


def instance_box(model: Model) -> dict[str, Interval]:
    """C path in `<name>_t` -> interval, for every float outside the banks.

    Raises ModelError for a kind of term or block whose box is not written here.
    """
    numbers = coefficients(model)
    command = Interval(float(numbers.u_min_V), float(numbers.u_max_V))
    applied, command, box = _chain(model, command)
    extra = 0.0
    for term, place in zip(model.terms, _places(model), strict=True):
        if term.kind not in _TERMS:
            raise ModelError(f"terms: {term.kind}: its box is not known to the proof; add it to proof/eva/boxes.py")
        found = _TERMS[term.kind](term, applied)
        box |= {f"terms.{term.kind}.{path}": interval for path, interval in found.state.items()}
        extra += sum(abs(w) * size for w, size in zip(model.weights[place:], found.regressors, strict=False))
    rules = _rules(model, applied)
    y = rules.outwards(WIDENED * rules.width + 1.01 * extra)
    return {"y_um": y, "u_V": command} | box


def regressor_sizes(model: Model) -> list[float]:
    """Largest magnitude of every term's regressors, in their order."""
    command = Interval(model.u_min_V, model.u_max_V).outwards()
    applied, _, _ = _chain(model, command)
    return [size for term in model.terms for size in _TERMS[term.kind](term, applied).regressors]


def _chain(model: Model, command: Interval) -> tuple[Interval, Interval, dict[str, Interval]]:
    """What reaches the stage, what is commanded, and the state of the blocks between them."""
    box: dict[str, Interval] = {}
    applied = command
    for block in model.blocks:
        numbers = block.constants(model.Ts_s)
        if block.kind == "saturation":
            low, high = float(numbers["low"][0]), float(numbers["high"][0])
            applied = Interval(max(applied.low, low), min(applied.high, high))
        elif block.kind == "slew":
            box["inputs.slew.last_V"] = applied
        elif block.kind == "delay":
            # An interpolation stays between its ends; seen by intervals it may leave them by its part of the width.
            slack = 1.01 * float(numbers["part"][0]) * applied.width
            box |= {f"inputs.delay.ring[{i}]": applied for i in range(block.ring)}  # type: ignore[attr-defined]
            applied = applied.outwards(slack)
            command = command.hull(applied)
        else:
            raise ModelError(f"blocks: {block.kind}: its box is not known to the proof; add it to proof/eva/boxes.py")
    if model.blocks:
        box["inputs.v_V"] = applied
    return applied, command, box


def _places(model: Model) -> list[int]:
    """Index of each term's first weight."""
    return [sum(term.size for term in model.terms[:k]) for k in range(len(model.terms))]


def _rules(model: Model, applied: Interval) -> Interval:
    """Extremes of every rule's consequent over the ranges of y and v: it is affine, so they lie at corners."""
    y = np.array([model.grid.y_min_um, model.grid.y_max_um])
    v = np.array([applied.low, applied.high])
    q = model.consequents
    values = q[:, 0, None, None] * y[:, None] + q[:, 1, None, None] * v + q[:, 2, None, None]
    return Interval(float(values.min()), float(values.max()))


def _memory(term: Any, v: Interval) -> TermBox:
    """A play stays within its half-width of the input; its polynomials as an analysis by intervals bounds them."""
    numbers = term.constants(1.0)
    plays = [v.outwards(1.0001 * float(r)) for r in numbers["half_width"]]
    reach = [1.001 * float(a) for a in numbers.get("reach", ())]
    even = [(1.4143 * a + 1.0) ** 2 for a in reach]
    odd = [a * (2.0 * size + 1.0) for a, size in zip(reach, even, strict=True)]
    sizes = ([play.magnitude for play in plays], even, odd)[: term.degree]
    return TermBox(
        {f"play[{j}]": play for j, play in enumerate(plays)}, tuple(size for group in sizes for size in group)
    )


def _creep(term: Any, v: Interval) -> TermBox:
    high = {f"high[{j}]": symmetric(KEPT) for j in range(term.size)}
    low = {f"low[{j}]": symmetric(KEPT_LOW) for j in range(term.size)}
    return TermBox(high | low, (KEPT,) * term.size)


def _resonance(term: Any, v: Interval) -> TermBox:
    state: dict[str, Interval] = {}
    for j in range(term.size // 2):
        for word in ("position", "velocity"):
            state |= {f"{word}[{j}]": symmetric(KEPT), f"{word}_low[{j}]": symmetric(KEPT_LOW)}
    return TermBox(state, (KEPT,) * term.size)


def _periodic(term: Any, v: Interval) -> TermBox:
    return TermBox({}, (1.001,) * term.size)


def _coupling(term: Any, v: Interval) -> TermBox:
    numbers = term.constants(1.0)
    state: dict[str, Interval] = {}
    sizes: list[float] = []
    for c, (low, high, middle) in enumerate(zip(*(numbers[name] for name in ("low", "high", "middle")), strict=True)):
        away = Interval(float(low) - float(middle), float(high) - float(middle)).outwards(1e-6 * float(high - low))
        state |= {f"sample[{c}][{i}]": away for i in range(term.taps)}
        sizes += [away.magnitude] * term.taps
    return TermBox(state, tuple(sizes))


def _drift(term: Any, v: Interval) -> TermBox:
    limit = float(term.constants(1.0)["limit"][0])
    return TermBox({"bias_um": symmetric(limit), "bias_low_um": symmetric(KEPT_LOW)}, (limit,))


_TERMS: Final[Mapping[str, Callable[[Any, Interval], TermBox]]] = {
    "memory": _memory,
    "creep": _creep,
    "resonance": _resonance,
    "periodic": _periodic,
    "coupling": _coupling,
    "drift": _drift,
}
