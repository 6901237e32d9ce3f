"""What certificates and the dynamics of a model say: each verdict from both sides of its limit, each number printed."""

from __future__ import annotations

import dataclasses
import json

import pytest

from hysgen.certify.certificates import Certificates
from hysgen.certify.dynamics import Dynamics, Loop, SteadyState
from hysgen.certify.enclosure import Extremum
from hysgen.certify.path_inverse import HysteresisSlopes, PathInverse

SLOPES = HysteresisSlopes(least=0.5, largest=1.5, mean_um_per_V=0.08, proved=True)
SOUND = Certificates(
    (0.0, 9.0), (-1.0, 4.0), "um", Extremum(0.2, 0.19, 1.5), Extremum(0.8, 0.81, 2.5), Extremum(0.97, 0.98, 3.5, 0.75),
    (-1.0, 4.0), PathInverse(SLOPES, 0.25, ("modes",)),
)  # fmt: skip


def changed(**parts: object) -> Certificates:
    return dataclasses.replace(SOUND, **parts)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("low", "high", "holds"),
    [
        (0.0101, 1.0, True),
        (0.0099, 1.0, False),
        (-1.0, -0.0101, True),
        (-1.0, -0.0099, False),
        (-0.1, 1.0, False),
        (-1.0, 0.1, False),
    ],
)
def test_a_gain_holds_above_a_hundredth_of_its_largest(low: float, high: float, holds: bool) -> None:
    found = changed(gain_lowest=Extremum(0.0, low, 0.0), gain_highest=Extremum(0.0, high, 0.0))
    assert found.gain_holds is holds
    assert found.inverse_holds is holds


def test_lines_of_certificates_say_the_verdict_with_its_numbers() -> None:
    gain = "gain 0.2 (y = 1.5 um) .. 0.8 (y = 2.5 um) um/um"
    slope = "slope at most 0.9800 (y = 3.5 um, w = 0.75 um)"
    inverse = (
        "inverse: Eq. (11); slope of the hysteresis 0.5 .. 1.5 of its mean 0.08 um/V (for every past); "
        "zeros of creep and modes within 0.250000; modes left out"
    )
    assert SOUND.lines() == (
        f"{gain}: holds",
        f"{slope}: contraction holds, w within -1 .. 4 um",
        f"{inverse}: holds",
    )
    assert SOUND.summary().title == "certificates: gain holds; contraction holds; inverse holds"
    weak = changed(gain_lowest=Extremum(-0.2, -0.21, 1.5))
    assert weak.lines()[0].endswith(": NOT certified, no inverse can be emitted")
    assert weak.lines()[2] == f"{inverse}: NOT certified, for the gain is not"
    assert weak.summary().title == "certificates: gain NOT certified; contraction holds; inverse NOT certified"
    falling = changed(gain_lowest=Extremum(-0.8, -0.81, 1.5), gain_highest=Extremum(-0.2, -0.19, 2.5), w_unit="V")
    assert "um/V: of one sign, but negative: the model falls as u rises; check" in falling.lines()[0]
    steep = changed(slope=Extremum(1.0, 1.0, 3.5, 0.75))
    assert not steep.contraction_holds
    assert steep.lines()[1].endswith(": contraction certified for -1 .. 4 um only, no free run is to be trusted beyond")
    never = dataclasses.replace(steep, contracting=None)
    assert never.lines()[1].endswith(": contraction NOT certified at any w, the free run is not to be trusted")
    for path, holds in (
        (PathInverse(None, 0.999, ()), True),
        (PathInverse(None, 1.0, ()), False),
        (PathInverse(dataclasses.replace(SLOPES, least=1e-9), 0.0, ()), True),
        (PathInverse(dataclasses.replace(SLOPES, least=0.0, proved=False), 0.0, ()), False),
    ):
        assert (path.holds, changed(path=path).inverse_holds) == (holds, holds)
    assert "(sampled, not proved): NOT certified, a voltage may not exist" in changed(path=path).lines()[2]
    assert changed(path=PathInverse(None, 0.0, ())).lines()[2] == "inverse: Eq. (11): holds"


def test_certificates_are_plain_json() -> None:
    assert json.loads(json.dumps(SOUND.to_json())) == {
        "y_range_um": [0.0, 9.0], "w_range": [-1.0, 4.0], "w_unit": "um",
        "gain": {
            "holds": True, "unit": "um/um",
            "lowest": {"value": 0.2, "bound": 0.19, "y_um": 1.5, "w": None},
            "highest": {"value": 0.8, "bound": 0.81, "y_um": 2.5, "w": None},
        },
        "contraction": {
            "holds": True, "inputs": [-1.0, 4.0], "slope": {"value": 0.97, "bound": 0.98, "y_um": 3.5, "w": 0.75},
        },
        "inverse": {
            "holds": True, "zero": 0.25, "left_out": ["modes"],
            "hysteresis_slopes": {"least_of_mean": 0.5, "largest_of_mean": 1.5, "mean_um_per_V": 0.08, "proved": True},
        },
    }  # fmt: skip
    assert changed(contracting=None).to_json()["contraction"]["inputs"] is None


def test_dynamics_say_their_ranges_and_whether_the_loop_stays_open() -> None:
    states = (
        SteadyState(0.0, 1.0, 0.9, 2e-3, 0.05, True),
        SteadyState(50.0, 5.0, 0.95, 4e-3, 0.08, True),
        SteadyState(100.0, 9.0, 0.0, 9.0, 7.0, False),
    )
    loops = (Loop(1.0, 2.5, 0.0101, 3.0), Loop(10.0, 25.0, 0.2, 3.0))
    found = Dynamics("m", states, loops, 50.0, 45.0)
    assert found.describe().splitlines() == [
        "m: first-order lag, time constant 0.002 .. 0.004 s; DC gain 0.05 .. 0.08 um/V",
        "rest line: 1 um at 0 V .. 9 um at 100 V",
        "loop under 45 V sines about 50 V (part of its box filled, area):",
        "          1 Hz    1.01 %         2.5 um V",
        "         10 Hz   20.00 %          25 um V",
        "the loop stays open as the frequency falls: the model has memory",
    ]
    closed = dataclasses.replace(found, loops=(dataclasses.replace(loops[0], filling=0.0099), loops[1]))
    assert (found.has_memory, closed.has_memory) == (True, False)
    assert closed.describe().splitlines()[-1] == "the loop closes as the frequency falls: a lag, not hysteresis"
    flat = dataclasses.replace(found, loops=(dataclasses.replace(loops[0], filling=0.0),), steady_states=states[2:])
    assert not flat.has_memory
    assert flat.describe().splitlines()[0] == "m: first-order lag, time constant none; DC gain none"
    told = json.loads(json.dumps(found.to_json()))
    assert told == {
        "model": "m", "rests": [vars(state) for state in states], "loops": [vars(loop) for loop in loops],
        "centre_V": 50.0, "amplitude_V": 45.0, "remembers": True,
    }  # fmt: skip
