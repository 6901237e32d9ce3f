"""The mesh inside one D/A period: where the signals of the plant are evaluated."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen_lab.stage.description import Stage
from hysgen_lab.stage.effects import require

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
