"""Numbers of the hysteresis block: box of the state, float32 constants, JSON, what has no float32 form."""

import dataclasses
import functools
import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from fixtures.hysteresis_blocks import BLOCKS, TS_S, Compiled, by_block, model_of, operator, voltages
from fixtures.tools import need
from hysgen.checking.proof.eva.calls import prove_call
from hysgen.codegen import generate
from hysgen.model.float32_arithmetic import LEAST
from hysgen.model.intervals import Interval
from hysgen.model.model import Model
from hysgen.model.path import block_from_json
from hysgen.model.path.base import BlockBox
from hysgen.model.path.hysteresis import Hysteresis


@by_block
def test_the_state_stays_in_its_box_and_has_no_denormal_number(block: Hysteresis) -> None:
    v = voltages(block, 30_000, seed=3)
    compiled = Compiled(block, float(v[0]))
    h, trace = compiled.apply(v, traced=True)
    _, _, followed = compiled.follow(np.float32(1.2) * h, traced=True)
    states = np.vstack([trace, followed]).view(np.float32)
    box = block.box(Interval(block.low_V, block.high_V), TS_S)
    paths = [word.path for member in block.members() for word in member.words()]
    assert sorted(box.floats) == sorted(paths)
    for column, path in zip(states.T, paths, strict=True):
        assert box.floats[path].low <= column.min() <= column.max() <= box.floats[path].high
    assert box.through.low <= h.min() <= h.max() <= box.through.high
    # The steps of plays that relax are multiples of 2^-61 (`float32_arithmetic`).
    least = 2.0**-63 if block.relaxes else LEAST / 2
    assert (np.abs(states[states != 0.0]) >= least).all()


@functools.cache
def small() -> tuple[Model, Mapping[str, str]]:
    """A model with three plays, and its C; a box is no part of the C."""
    model = model_of(operator(3, 2), rules=2)
    return model, generate(model)


@pytest.mark.parametrize(
    ("function", "inputs"),
    [
        pytest.param("init", "finite", marks=pytest.mark.proof),
        pytest.param("predict", "any", marks=pytest.mark.proof),
        ("inverse", "any"),
    ],
)
@pytest.mark.slow
def test_the_box_is_proved(function: str, inputs: Any) -> None:
    need("frama-c")
    verdict, expected = prove_call(*small(), function, inputs)
    assert not verdict.alarms
    assert verdict.held == verdict.checks >= expected > 15


@pytest.mark.parametrize(
    "path",
    [
        "play[1]",
        "sum_um[0]",
        *(pytest.param(path, marks=pytest.mark.proof) for path in ("left[0]", "back[1]", "turn", "last", "h_um")),
    ],
)
@pytest.mark.slow
def test_a_box_that_is_too_small_is_not_proved(path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    need("frama-c")
    whole = Hysteresis.box

    def narrow(self: Hysteresis, u_V: Interval, Ts_s: float) -> BlockBox:
        box = whole(self, u_V, Ts_s)
        given = box.floats[path]
        return dataclasses.replace(
            box, floats={**box.floats, path: Interval(given.low, given.high - 0.2 * given.width)}
        )

    monkeypatch.setattr(Hysteresis, "box", narrow)
    model, texts = small()
    verdict, _ = prove_call(model, texts, "predict", "finite")
    assert [alarm for alarm in verdict.alarms if path.split("[")[0] in alarm]


@by_block
def test_constants_are_the_exact_ones_rounded(block: Hysteresis) -> None:
    """Every row of `curve` against exact fractions: g0 and the first n plays taken along, in powers of side x."""
    exact_curve = powers([Fraction(a) for a in block.curve_um])
    number = block.numbers
    size = sum(abs(float(a)) for a in exact_curve) + float(np.abs(number.play[:, 1:]).sum())
    for direction, side in enumerate((1, -1)):
        row = exact_curve + [Fraction(0)] * (number.curve.shape[2] - len(exact_curve))
        row[0] += sum((powers([Fraction(0), *map(Fraction, a)])[0] for a in block.series.plays), Fraction(0))
        for n in range(block.plays + 1):
            found = side * float(side) ** np.arange(len(row)) * number.curve[direction, n].astype(np.float64)
            assert np.abs(found - [float(a) for a in row]).max() < 1.2e-7 * size
            if n < block.plays:
                taken = powers([Fraction(0), *map(Fraction, block.series.plays[n])])
                taken[0] = Fraction(0)
                row = [
                    a + b
                    for a, b in zip(row, shifted(taken, -side * Fraction(block.half_widths[n]), len(row)), strict=True)
                ]


def powers(series: list[Fraction]) -> list[Fraction]:
    """Coefficients of the powers of x of a Chebyshev series."""
    before, now = [Fraction(1)], [Fraction(0), Fraction(1)]
    found = [Fraction(0)] * len(series)
    for m, a in enumerate(series):
        if m == 0:
            term = before
        elif m == 1:
            term = now
        else:
            term = [2 * c for c in [Fraction(0), *now]]
            term = [c - (before[k] if k < len(before) else 0) for k, c in enumerate(term)]
            before, now = now, term
        found = [c + (a * term[k] if k < len(term) else 0) for k, c in enumerate(found)]
    return found


def shifted(coefficients: list[Fraction], by: Fraction, size: int) -> list[Fraction]:
    """Coefficients of p(x + by)."""
    found = [Fraction(0)] * size
    for m, c in enumerate(coefficients):
        for k in range(m + 1):
            found[k] += c * math.comb(m, k) * by ** (m - k)
    return found


def test_json_round_trip_is_exact() -> None:
    for block in BLOCKS.values():
        assert block_from_json(block.to_json()) == block


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"low_V": 120.0}, "low_V must be below high_V"),
        ({"curve_um": (1.0,)}, "at least two coefficients"),
        ({"half_widths": (0.2, 0.1, *operator().half_widths[2:])}, "half_widths must rise"),
        ({"half_widths": (1e-4, *operator().half_widths[1:])}, "half_widths must rise and lie between 2^-12 and 1"),
        ({"plays_um": (1.0,) * 23}, "the same number of coefficients for every play"),
        ({"reach": 0.36}, "reach must be at least 0.3607 half ranges"),
        ({"reach": 0.7}, "that of the last Duhem state 0.0451"),
        ({"reach": math.nan}, "reach must be positive"),
        ({"duhem_um": (0.1,) * 3}, "two coefficients for each state"),
        ({"curve_um": (1.0, math.inf)}, "the coefficients must be finite"),
    ],
)
def test_what_has_no_float32_form_is_refused(changes: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint.replace("^", r"\^")):
        dataclasses.replace(operator(), **changes)
