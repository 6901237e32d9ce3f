"""Extension of the Takagi-Sugeno model for a cause: term, input block, correction, weights of samples."""

import abc
import dataclasses
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.fitting.operator import PathSize
from hysgen.model.disturbances import Term
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.model import Model
from hysgen.model.path import InputBlock
from hysgen.model.remaining import Named
from hysgen.record import Segment

Floats = NDArray[np.float64]


class Correction(abc.ABC):
    """A slow change that is removed from the displacement before a fit. Subclasses are frozen and comparable."""

    @abc.abstractmethod
    def removed(self, y_um: Floats, t_s: Floats) -> Floats:
        """(n,) displacement y_um without the slow change [um]; t_s: (n,) time since the start of the segment."""

    @property
    def level_um(self) -> float:
        """What of the change is the level of the model, which the displacement has without it."""
        return 0.0

    def course(self, t_s: Floats, predicted_um: Floats) -> Floats:
        """(n,) the change with size 1: its size in another record is unknown. predicted_um: (n,) of a model."""
        return -self.removed(np.zeros(len(t_s)), t_s)

    def online_term(self, model: Model, span_s: float) -> Term | None:
        """The term with weight 1 that follows the slow change in operation, or None. span_s: length of the record."""
        return None


def corrected(segment: Segment, corrections: Sequence[Correction], Ts_s: float) -> Segment:
    """A segment without changes of the displacement, whose time counts from its start."""
    time_s: Floats = Ts_s * np.arange(segment.samples, dtype=np.float64)
    y_um = segment.y_um
    for correction in corrections:
        y_um = correction.removed(y_um, time_s)
    return dataclasses.replace(segment, y_um=y_um + sum(correction.level_um for correction in corrections))


@dataclass(frozen=True, eq=False)
class Extension:
    """Extension for one cause: a term, a block of the path, a correction, or settings of the fit and the learner.

    in_place: the block of an earlier cause as it is beside this one, and the blocks that follow it; none without it.
    replaces: kinds of blocks and terms of earlier causes whose place the block takes.
    size: size of the hysteresis, None for a cause without memory. relaxation: s_j / r_j of the plays, 0 for plays that
    do not relax. lag_s: lag of the chain that the block belongs to. past: as of `FitSettings`.
    trust: (m,) weight of each row in the fit, for the first m rows of the record, or None for 1 throughout.
    correction: slow change that is removed from the displacement before the fit.
    forgetting_s: time constant of the learner, by which it follows a change of the gain; None for no forgetting.
    gate: whether the learner rejects samples that are far from its prediction.
    """

    term: Term | None = None
    block: InputBlock | None = None
    in_place: tuple[InputBlock, ...] = ()
    replaces: tuple[str, ...] = ()
    size: PathSize | None = None
    relaxation: float = 0.0
    past: tuple[float, float] | None = None
    lag_s: float | None = None
    trust: Floats | None = None
    correction: Correction | None = None
    forgetting_s: float | None = None
    gate: bool = False

    @property
    def content(self) -> Hashable:
        """Key for a cache of fits; extensions with equal keys give equal models."""
        trust = None if self.trust is None else self.trust.tobytes()
        path = (self.block, self.in_place, self.replaces, self.size, self.relaxation, self.past, self.lag_s)
        return (self.term, *path, trust, self.correction, self.learns)

    @property
    def on_path(self) -> bool:
        """Whether the extension is a part of the path between command and rules."""
        return self.block is not None or self.size is not None

    @property
    def learns(self) -> bool:
        """Whether the extension requires a learner."""
        return self.gate or self.forgetting_s is not None


def named_by(extensions: Mapping[str, Extension]) -> Named:
    """What the extensions of causes, by name, say of a record that no model can know before it."""
    blocks = [e.block for e in extensions.values() if e.block is not None and e.block.responds]
    lines_Hz = [f_Hz for e in extensions.values() if isinstance(e.term, Periodic) for f_Hz in e.term.f_Hz]
    courses = [(name, e.correction.course) for name, e in extensions.items() if e.correction is not None]
    level = bool(blocks or courses) or any(e.size is not None for e in extensions.values())
    return Named(tuple(blocks), tuple(lines_Hz), tuple(courses), level)
