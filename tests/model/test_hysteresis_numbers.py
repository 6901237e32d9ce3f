"""Numbers of the hysteresis block: box of the state, float32 constants, JSON, what has no float32 form."""

import dataclasses
import functools
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from fixtures.hysteresis_blocks import TS_S, Compiled, by_block, model_of, operator, voltages
from fixtures.tools import need
from hysgen.checking.proof.eva.calls import prove_call
from hysgen.codegen import generate
from hysgen.model.float32_arithmetic import LEAST
from hysgen.model.intervals import Interval
from hysgen.model.model import Model
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
