"""The model as one component with a mode, the form that every export presents to its caller; template variables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from hysgen.codegen import Options
from hysgen.codegen.render import render
from hysgen.float32.coefficients import coefficients
from hysgen.machine.files import version
from hysgen.model.disturbances import channels_of
from hysgen.model.model import Model


@dataclass(frozen=True)
class Mode:
    """A mode of the component: its number in C, arguments of a step, and result."""

    number: int
    name: str
    arguments: str
    result: str
    about: str


MODES: Final = (
    Mode(0, "predict", "y(k) [um], u(k) [V]", "y(k+1) [um]", "one step ahead of a measured displacement"),
    Mode(1, "simulate", "u(k) [V]", "y(k+1) [um]", "free run"),
    Mode(2, "inverse", "y(k) [um], y(k+1) [um]", "u(k) [V]", "the voltage that takes y(k) to y(k+1)"),
    Mode(3, "learn", "y(k) [um], u(k) [V], commit", "y(k+1) [um]", "learn from y(k), u(k), commit on demand, predict"),
)


def modes_of(model: Model, options: Options) -> tuple[Mode, ...]:
    """The modes that the generated C of `model` has."""
    left_out = ([] if options.inverse else ["inverse"]) + ([] if model.learner else ["learn"])
    return tuple(mode for mode in MODES if mode.name not in left_out)


def component_facts(model: Model, options: Options) -> dict[str, Any]:
    """Variables of the templates in templates/export/."""
    numbers = coefficients(model)
    modes = modes_of(model, options)
    middle_V = 0.5 * (float(numbers.u_min_V) + float(numbers.u_max_V))
    upper = model.name.upper()
    return {
        "name": model.name,
        "NAME": upper,
        "version": version(),
        "Ts_us": f"{1e6 * model.Ts_s:.9g}",
        "Ts_text": repr(model.Ts_s),
        "stop_text": repr(1000 * model.Ts_s),
        "modes": modes,
        "all_modes": [mode.name for mode in MODES],
        "known": " || ".join(f"(mode == {upper}_COMPONENT_{mode.name.upper()})" for mode in modes),
        "inverse": options.inverse,
        "learns": model.learner is not None,
        "channels": channels_of(model.terms),
        "u_min": exact(numbers.u_min_V),
        "u_max": exact(numbers.u_max_V),
        "y_min": exact(numbers.y_min_um),
        "y_max": exact(numbers.y_max_um),
        "reference_min": exact(numbers.reference_min_um),
        "reference_max": exact(numbers.reference_max_um),
        "rest_um": exact(numbers.rest_um),
        "middle_V": exact(np.float32(middle_V)),
        "quarter_V": exact(np.float32(0.25 * (float(numbers.u_max_V) - float(numbers.u_min_V)))),
    }


def exact(value: np.float32) -> str:
    """`value` with 9 significant digits and a decimal point: reads back to the same float32.

    >>> exact(np.float32(22))
    '22.0'
    """
    text = f"{float(value):.9g}"
    return text if "." in text or "e" in text else f"{text}.0"


def component_texts(facts: Mapping[str, Any]) -> dict[str, str]:
    """The component in C by file name."""
    return {f"{facts['name']}_component.{end}": render(f"export/component.{end}.j2", facts) for end in "hc"}
