"""What a model costs per sample, for the ladder of a diagnosis."""

from __future__ import annotations

from hysgen.certify.certificates import certify
from hysgen.codegen import Options, generate
from hysgen.codegen.operations import figures
from hysgen.codegen.operations.cycles import cycles_of, per_sample
from hysgen.diagnosis.answer import Price
from hysgen.errors import BudgetError, CertificateError
from hysgen.model.model import Model


def price_of(model: Model) -> Price | None:
    """Cycles of one sample period and bytes of structs and constants, for a model as it runs.

    A sample takes the dearest of predict, simulate and inverse, and with a learner `learn` and `commit` beside it, as
    `hysgen cost` counts. Counted in the C that is generated of the model; cycles are the estimate of
    `hysgen.codegen.operations.cycles`. None without C: a sample does not fit its period, or nothing could be committed.
    """
    try:
        texts = generate(model, Options(inverse=certify(model).inverse_holds))
    except (BudgetError, CertificateError):
        return None
    found = figures(model.name, texts)
    cycles = per_sample(cycles_of(found.operations))
    held = sum(found.struct_bytes.get(f"{model.name}_{struct}", 0) for struct in ("t", "learner_t"))
    return Price(cycles.value, held + found.constant_bytes)
