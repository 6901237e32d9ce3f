"""Number of Newton steps of the inverse of the hysteresis: the fewest that meet random jumps from random pasts."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from hysgen.machine.reproducible import drawn
from hysgen.model.intervals import Interval
from hysgen.model.path.base import TOLERANCE, Bits, Floats32, InputBlock
from hysgen.model.path.hysteresis_mirror import HysteresisMirror, Numbers, RelaxingMirror

LEAST_STEPS: Final = 3
MOST_STEPS: Final = 6
"""Fewest and most Newton steps of `solve`. Two steps leave 1e-4 um of a stroke of 10 um at 100 Hz and 2 kHz."""

SHARE: Final = 0.75
ROUNDINGS: Final = 2.0**-21
"""Residual of `solve` up to which no further step is taken: SHARE of what the inverse of the model leaves unflagged
(TOLERANCE of the range). The rest is for roundings of the blocks behind and for pasts that no sample met. At least
ROUNDINGS of the largest |h|, eight roundings: that much stays however many steps are taken."""

LANES: Final = 4096
JUMPS: Final = 16
WORST: Final = 256
SEARCHES: Final = 10
"""`newton_steps`: random jumps in each of LANES; a search near the WORST of them, LANES/WORST places around each."""


def accepted_residual(range_um: Interval) -> float:
    """Largest residual in um with which `newton_steps` is content, for h in range_um."""
    return max(SHARE * TOLERANCE * range_um.width, ROUNDINGS * range_um.magnitude)


def newton_steps(block: InputBlock, numbers: Numbers, range_V: Interval, largest: float) -> int:
    """Fewest Newton steps with which `solve` leaves at most `largest` um of random jumps, MOST_STEPS at most.

    The jumps lead from random pasts over the whole range and over parts of it; a search near those that LEAST_STEPS
    meet worst follows. Pasts are a sample: a larger residual of others sets the status bit INVERSE_RESIDUAL.

    The residual is a few tens of last bits of h. Models that differ in their last digits can therefore lie on both
    sides of `largest` and take one step more or less.
    """
    rng = np.random.default_rng(1)
    ends = drawn(rng, range_V.low, range_V.high, (JUMPS + 1) * LANES).reshape(JUMPS + 1, LANES).astype(np.float32)
    sizes = np.repeat(np.array([1.0, 0.3, 0.1, 0.03], np.float32), LANES // 4)
    v_V = ends[0]
    kind = RelaxingMirror if numbers.relax.size else HysteresisMirror
    mirror = kind(numbers, block.members(), MOST_STEPS, v_V)
    states, jumps, residuals = [], [], []
    for end in ends[1:]:
        v_V = v_V + sizes * (end - v_V)
        state = _words(mirror)
        states.append(state)
        jumps.append(v_V)
        residuals.append(_residuals(mirror, state, v_V))
    errors = np.concatenate(residuals, axis=1)
    worst = np.argsort(-errors[0], kind="stable")[:WORST]
    pasts = [np.repeat(np.concatenate(words)[worst], LANES // WORST) for words in zip(*states, strict=True)]
    centre, away = np.concatenate(jumps)[worst], 0.02 * range_V.width
    for _ in range(SEARCHES):
        around = drawn(rng, -away, away, LANES).astype(np.float32).reshape(WORST, -1)
        around[:, 0] = 0.0
        places = centre[:, None] + around
        near = _residuals(mirror, pasts, places.ravel())
        errors = np.column_stack([errors.max(axis=1), near])
        centre = places[np.arange(WORST), near[0].reshape(WORST, -1).argmax(axis=1)]
        away *= 0.6
    enough = errors.max(axis=1) <= largest
    return LEAST_STEPS + int(np.argmax(enough)) if enough.any() else MOST_STEPS


def _residuals(mirror: HysteresisMirror, state: Sequence[Bits], v_V: Floats32) -> Floats32:
    """(1 + MOST_STEPS - LEAST_STEPS, lanes) |h - wanted| of LEAST_STEPS and more steps; wanted: h of v_V from `state`.

    Leaves the mirror behind v_V.
    """
    mirror.restore(state)
    wanted = mirror.apply(v_V)
    behind = _words(mirror)
    mirror.restore(state)
    errors = []
    for solved in mirror.iterates(wanted)[LEAST_STEPS:]:
        mirror.restore(state)
        errors.append(np.abs(mirror.apply(solved) - wanted))
    mirror.restore(behind)
    return np.array(errors)


def _words(mirror: HysteresisMirror) -> list[Bits]:
    """A copy of the state."""
    return [word.copy().view(np.uint32) for word in mirror.state()]
