"""The antecedent: a uniform partition of the displacement that the record visits, Eqs (6) and (7)."""

from __future__ import annotations

from hysgen.errors import FitError
from hysgen.fitting.settings import FitSettings
from hysgen.model.model import Grid
from hysgen.model.regression import Structure
from hysgen.record import Record


def partition(record: Record, rules: int, margin: float = 0.0, at_least_um: tuple[float, float] | None = None) -> Grid:
    """Steps 1 to 3 of the paper's summary: the range of y over all segments, split among L rules.

    at_least_um: a range that is covered in any case. margin: part of the range added at each end.
    Raises ModelError if the displacement is constant or the number of rules unsupported.
    """
    low, high = record.y_range_um
    if at_least_um is not None:
        low, high = min(low, at_least_um[0]), max(high, at_least_um[1])
    wider = margin * (high - low)
    return Grid(low - wider, high + wider, rules)


def structure_for(record: Record, settings: FitSettings) -> Structure:
    """Partition, input range, terms and blocks that `settings` ask for over this record.

    Raises FitError if the record holds fewer pairs of samples than the structure has parameters.
    """
    u_min_V, u_max_V = settings.input_range_V or record.u_range_V
    grid = partition(record, settings.rules, settings.margin, settings.displacement_range_um)
    structure = Structure(grid, u_min_V, u_max_V, settings.terms, settings.blocks)
    pairs = record.samples - len(record.segments)
    if pairs < structure.size:
        raise FitError(
            f"{record.source}: {pairs} pairs of samples cannot determine {structure.size} parameters; "
            "choose fewer rules or terms, or record longer"
        )
    return structure
