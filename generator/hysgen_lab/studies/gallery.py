"""The gallery of the docs: what each cause does to the motion of the virtual stage, with it and without it."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes import causes
from hysgen.diagnosis.remedy import Motion, Sketch
from hysgen.report.sketches import svg
from hysgen_lab.stage import Stage, run
from hysgen_lab.stage.effects.memory import Curve

Floats = NDArray[np.float64]

TS_S = 1e-4
BENT = tuple(10.0 * v - 6.0 * v * (1.0 - v) for v in np.linspace(0.0, 1.0, 13).tolist())
PLANTED: Mapping[str, tuple[Any, Mapping[str, float]]] = {
    "curve": (Curve(0.0, 10.0, BENT), {}),
    "memory": (Stage.nominal().memory, {"loop_Hz": 2.0}),
    "creep": (0.03, {"per_decade": 0.03, "from_s": 0.01}),
    "resonance": ((400.0, 0.03, 0.6), {"f_Hz": 400.0, "zeta": 0.03}),
    "softening": ((400.0, 0.01, 0.2, 200.0), {"small_f_Hz": 400.0}),
    "delay": (12.0, {"delay_samples": 12.0}),
    "saturation": ((15.0, 95.0), {"low_V": 15.0, "high_V": 95.0}),
    "slew": (5e3, {"rate_V_per_s": 5e3}),
    "drift": (0.004, {"ramp_um_per_s": 0.004}),
    "periodic": ((50.0, 0.02), {"f_Hz": 50.0}),
    "aging": ((-0.15, 60.0), {"per_s": -0.15 / 60.0}),
    "coupling": ({"axis2_V": 0.02}, {}),
    "outliers": ((0.025, 0.5), {"rate": 0.025}),
}
"""The effect of the stage and the parameters of the cause, by its name."""

WITHOUT: Mapping[str, Mapping[str, Any]] = {"softening": {"softening": (400.0, 0.01, 1e-6, 200.0)}}
"""What the stage has where it lacks the cause: a mode that does not slip."""

LOW_V, RANGE_V = 10.0, 100.0

HEAD = """\
# What each cause looks like

Each picture shows one motion of the virtual stage (10 um over 120 V, a lag of 1 ms) with one effect, and without it;
grey is the other of both. Page and text of a diagnosis show the same motions with the numbers of your record, what they
mean, and what to change. `python -m hysgen_lab gallery -o docs` makes this page and its pictures, and a test holds them
to it. From a symptom to its cause: [symptoms.md](symptoms.md).
"""


def gallery() -> dict[str, str]:
    """The files of the gallery by their names: a page, and one SVG for each planted cause."""
    files, lines = {}, [HEAD]
    head = 'xmlns="http://www.w3.org/2000/svg" width="324" height="96" color="#777" '
    for name, (effect, values) in PLANTED.items():
        motion = causes()[name].motion(values, TS_S)
        assert motion is not None
        free = dataclasses.replace(Stage.nominal().quiet(), memory=None).with_effects(**WITHOUT.get(name, {}))
        acting = free.with_effects(**{"memory" if name == "curve" else name: effect})
        sketch = Sketch.of(motion, *(_moved_um(stage, motion, acting.channels) for stage in (acting, free)))
        files[f"gallery/{name}.svg"] = svg(sketch, name, head) + "\n"
        lines.append(f"**`{name}`**\n\n![{name}: {motion.words}](gallery/{name}.svg)\n")
    return {"gallery.md": "\n".join(lines), **files}


def _moved_um(stage: Stage, motion: Motion, channels: Sequence[str]) -> Floats:
    """The readings under a motion, of a loop its second period. Channels, if there are any, move, not the voltage."""
    levels = np.tile(motion.levels, 2) if motion.loop else motion.levels
    voltage = LOW_V + RANGE_V * (np.full(len(levels), 0.5) if channels else levels)
    read = run(stage, voltage, motion.Ts_s, 1, dict.fromkeys(channels, levels))
    return read.displacement_um[-len(motion.levels) :]
