"""Equality of bits of generated C and reference, with each term and input block alone and with all of them together.

Run:  python benchmarks/terms_equality.py [SAMPLES]      (per model and build, default 1e6)
Each model is generated and given to `verify`, as `hysgen verify DIR --samples SAMPLES` does: results, states, status
words and counters in every build of every compiler that is installed.
"""

from __future__ import annotations

import dataclasses
import sys

import hysgen  # noqa: F401  before NumPy, whose BLAS reads once how many threads it may have

# isort: split
import numpy as np

from hysgen.certify.certificates import certify
from hysgen.checking.bits import VerifySettings, verify_texts
from hysgen.codegen import generate
from hysgen.display import table
from hysgen.model.disturbances import Term
from hysgen.model.disturbances.coupling import Coupling
from hysgen.model.disturbances.drift import Drift
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.file import load_model
from hysgen.model.model import Model
from hysgen.model.path import InputBlock
from hysgen.model.path.creep import Creep
from hysgen.model.path.delay import Delay
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.path.modes import Modes
from hysgen.model.path.saturation import Saturation
from hysgen.model.path.slew import Slew

TERMS: tuple[Term, ...] = (
    Periodic((50.0,)),
    Coupling(("temperature",), (20.0,), (24.0,), taps=2),
    Drift(0.1, 0.05),
)
BLOCKS: tuple[InputBlock, ...] = (
    Saturation(-15.0, 110.0),
    Slew(2e6, 1.5e6),
    Delay(2.4),
    Hysteresis(-20.0, 120.0, (50.0, 60.0, 2.0), (0.1, 0.3, 0.6), (5.0, 0.2, 0.1) * 3, 0.8, (0.5, 0.2, 0.3, 0.0)),
    Creep(0.01, (1e-3, 0.1, 10.0)),
    Modes((730.0,), (0.05,), (0.3,), 4e-4),
)


def model(name: str, terms: tuple[Term, ...], blocks: tuple[InputBlock, ...]) -> Model:
    """Appendix A with these; weights of both signs, small enough for a certified inverse."""
    weights = [1e-5 * (-1.0) ** np.arange(term.size) for term in terms]
    return dataclasses.replace(
        load_model("appendix_a"),
        name=name,
        terms=terms,
        weights=np.concatenate([np.zeros(0), *weights]),
        blocks=blocks,
    )


def main() -> int:
    """Print one table; 0 if every bit is equal."""
    samples = int(float(sys.argv[1])) if len(sys.argv) > 1 else 1_000_000
    models = [model(f"with_{term.kind}", (term,), ()) for term in TERMS]
    models += [model(f"with_{block.kind}", (), (block,)) for block in BLOCKS]
    models.append(model("with_everything", TERMS, BLOCKS))
    rows, equal = [], True
    for each in models:
        report = verify_texts(each, generate(each), VerifySettings(samples, other_models=0))
        equal &= report.equal
        inverse = "certified" if certify(each).inverse_holds else "NOT certified"
        rows.append([each.name, f"{report.samples:,}", str(report.equal), inverse])
        print(f"{each.name}: {'equal' if report.equal else 'NOT EQUAL'}", file=sys.stderr)
    print("\n".join(report.builds), file=sys.stderr)
    print(table(["model", "samples", "every bit equal", "inverse"], rows))
    return 0 if equal else 1


if __name__ == "__main__":
    sys.exit(main())
