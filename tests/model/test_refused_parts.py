"""Numbers that a block or a term cannot have are refused by name, those at the edge are taken."""

import dataclasses
import math
from typing import Any

import pytest

from fixtures.term_models import BLOCKS, RESPONSES, TERMS
from hysgen.model.part import ModelPart
from hysgen.model.path.loop import MOST_STATES
from hysgen.model.path.modes import LEAST_DAMPING, MOST_DAMPING

PARTS: dict[str, ModelPart] = {part.kind: part for part in (*TERMS, *BLOCKS, *RESPONSES)}


@pytest.mark.parametrize(
    ("kind", "changes", "complaint"),
    [
        ("periodic", {"f_Hz": ()}, "f_Hz must be positive and rising"),
        ("periodic", {"f_Hz": (0.0, 1.0)}, "f_Hz must be positive and rising"),
        ("periodic", {"f_Hz": (2.0, 1.0)}, "f_Hz must be positive and rising"),
        ("periodic", {"f_Hz": (2.0, math.inf)}, "f_Hz must be positive and rising"),
        ("drift", {"tau_s": 0.0}, "tau_s and limit_um must be positive"),
        ("drift", {"limit_um": -1.0}, "tau_s and limit_um must be positive"),
        ("drift", {"tau_s": math.inf}, "tau_s and limit_um must be positive"),
        ("drift", {"limit_um": math.nan}, "tau_s and limit_um must be positive"),
        ("coupling", {"channels": ("a", "a")}, "each auxiliary channel once"),
        ("coupling", {"channels": (), "low": (), "high": ()}, "each auxiliary channel once"),
        ("coupling", {"channels": ("a", "b */ c")}, "a C comment; rename the column"),
        ("coupling", {"channels": ("a", "/* b")}, "a C comment; rename the column"),
        ("coupling", {"channels": ("a", "b\n")}, "a C comment; rename the column"),
        ("coupling", {"low": (1.0,)}, "one number for each channel"),
        ("coupling", {"high": (24.0, math.inf)}, "low must lie below high in each channel"),
        ("coupling", {"low": (24.0, -1.0)}, "low must lie below high in each channel"),
        ("coupling", {"taps": 0}, "taps must be 1 to"),
        ("coupling", {"taps": 1000}, "taps must be 1 to"),
        ("drives", {"taps": 2}, "for each mode and channel, taps must be 1"),
        ("drives", {"share": (0.1,) * 3}, "for each mode and channel, taps must be 1"),
        ("drives", {"quadrature": (0.1,) * 5}, "for each mode and channel, taps must be 1"),
        ("drives", {"quadrature": (0.1, 0.1, 0.1, math.nan)}, "share and quadrature must be finite"),
        ("drives", {"f_Hz": (-1.0, 730.0)}, "f_Hz must be positive and rising"),
        ("delay", {"samples": -0.5}, "samples must be 0 to"),
        ("creep", {"tau_s": ()}, "tau_s must be positive and rising"),
        ("creep", {"tau_s": (0.0, 1.0)}, "tau_s must be positive and rising"),
        ("creep", {"tau_s": (1.0, 1.0)}, "tau_s must be positive and rising"),
        ("creep", {"tau_s": (1.0, math.inf)}, "tau_s must be positive and rising"),
        ("creep", {"amount": -1.0 / 3.0}, "amount must be above -1 over the number of states"),
        ("modes", {"f_Hz": (), "zeta": (), "share": ()}, "f_Hz must be positive and rising"),
        ("modes", {"f_Hz": (0.0, 730.0)}, "f_Hz must be positive and rising"),
        ("modes", {"f_Hz": (731.0, 730.0)}, "f_Hz must be positive and rising"),
        ("modes", {"zeta": (0.1,)}, "one finite number for each mode"),
        ("modes", {"share": (0.1, math.inf)}, "one finite number for each mode"),
        ("modes", {"zeta": (0.1, 0.999 * LEAST_DAMPING)}, "a damping ratio of"),
        ("modes", {"zeta": (0.1, 1.001 * MOST_DAMPING)}, "a damping ratio of"),
        ("modes", {"lag_s": 0.0}, "lag_s must be positive"),
        ("modes", {"early_s": math.nan}, "early_s must be finite"),
        ("structure", {"quadrature": (0.1,)}, "one finite number for each mode"),
        ("structure", {"quadrature": (0.1, math.nan)}, "one finite number for each mode"),
        ("structure", {"early_s": 1e-5}, "early_s stands in the quadrature"),
        ("structure", {"Ts_s": 0.0}, "Ts_s must be positive"),
        ("softening", {"channels": (), "low": (), "high": ()}, "several drives: name a channel"),
        ("softening", {"fall": ()}, "one of every number"),
        ("softening", {"swing": (0.1,)}, "one of every number"),
        ("softening", {"gain": math.inf}, "every number must be finite, env_s and Ts_s positive"),
        ("softening", {"env_s": 0.0}, "every number must be finite, env_s and Ts_s positive"),
        ("softening", {"Ts_s": 0.0}, "every number must be finite, env_s and Ts_s positive"),
        ("softening", {"lag_s": 0.0}, "lag_s must be positive"),
        ("loop", {"force": ()}, f"1 to {MOST_STATES} states"),
        ("loop", {"loading": (0.1, 0.2)}, f"1 to {MOST_STATES} states"),
        ("loop", {"gain": math.nan}, "every number must be finite, and unloading not negative"),
        ("loop", {"unloading": (-1e-9,)}, "every number must be finite, and unloading not negative"),
        ("loop", {"box_um": (0.0,)}, "box_um must be positive and parts 1 or 2"),
        ("loop", {"parts": 3}, "box_um must be positive and parts 1 or 2"),
        ("loop", {"parts": 0}, "box_um must be positive and parts 1 or 2"),
        ("loop", {"zeta": 2.0}, "a damping ratio of"),
    ],
)
def test_what_a_part_cannot_be_is_refused_by_name(kind: str, changes: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        dataclasses.replace(PARTS[kind], **changes)


@pytest.mark.parametrize(
    ("kind", "changes"),
    [
        ("periodic", {"f_Hz": (1.0, 1.0)}),
        ("coupling", {"taps": 1}),
        ("delay", {"samples": 0.0}),
        ("creep", {"amount": -0.333}),
        ("modes", {"f_Hz": (730.0, 730.0), "zeta": (LEAST_DAMPING, MOST_DAMPING), "early_s": None}),
        ("loop", {"unloading": (0.0,), "parts": 1}),
    ],
)
def test_what_lies_at_the_edge_is_taken(kind: str, changes: dict[str, Any]) -> None:
    assert dataclasses.replace(PARTS[kind], **changes) != PARTS[kind]
