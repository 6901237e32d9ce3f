"""What a model costs per sample, for the ladder of a diagnosis."""

from __future__ import annotations

from hysgen.certificates import certify
from hysgen.diagnose.diagnosis import Price
from hysgen.emit import Options, generate
from hysgen.errors import BudgetError
from hysgen.model import Model
from hysgen.operations import figures
from hysgen.operations.cycles import STEPS, estimated


def price_of(model: Model) -> Price | None:
    """Cycles of the dearest of predict, simulate and inverse, and bytes of struct and constants.

    Counted in the C that is generated of the model; cycles are the estimate of `hysgen.operations.cycles`. None if a
    sample of the model does not fit its period, so that there is no C.
    """
    try:
        texts = generate(model, Options(inverse=certify(model).inverse_holds))
    except BudgetError:
        return None
    found = figures(model.name, texts)
    cycles = max(estimated(found.operations[step]).value for step in STEPS if step in found.operations)
    return Price(cycles, found.struct_bytes[f"{model.name}_t"] + found.constant_bytes)
