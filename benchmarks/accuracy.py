"""Largest error of a step that a sweep finds, beside its proved bound.

python benchmarks/accuracy.py MODEL... --samples 100000000    minutes each; a MODEL is that of a file, one that comes
    with hysgen, a function of tests/fixtures/generated_models.py, or `structure` of benchmarks/proofs.py
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from proofs import structure

from hysgen.float32.reference.accuracy import accuracy
from hysgen.model.file import load_model
from hysgen.model.model import Model


def model_of(name: str) -> Model:
    """The model of a name on the command line."""
    from fixtures import generated_models

    makers = {"structure": structure} | {made: getattr(generated_models, made) for made in ("path", "diagnosed")}
    return makers[name]() if name in makers else load_model(name)


def main() -> None:
    """Print a line for each model: found, bound, and bound over found."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("models", nargs="+", metavar="MODEL")
    parser.add_argument("--samples", type=int, default=4_000_000)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    print(f"{'model':12} {'samples':>10} {'of':22} {'found':>9} {'bound':>9} ratio")
    for name in arguments.models:
        begun, model = time.monotonic(), model_of(name)
        solved = all(block.solves(model.Ts_s) for block in model.blocks)
        found = accuracy(model, arguments.samples, inverse=solved, seed=arguments.seed)
        inverse = ("predict_of_inverse_um", "inverse_um") if model.responds else ("inverse_V", "inverse_V")
        for field, of_bound in (("predict_um", "predict_um"), ("path", "path"), inverse):
            most, bound = getattr(found, field), getattr(found.proved, of_bound, None)
            if most:
                said = "none" if bound is None else f"{bound:9.3g} {bound / most:5.2f}"
                took = f"{time.monotonic() - begun:.0f} s"
                print(f"{name:12} {found.samples:10} {field:22} {most:9.3g} {said}  {took}", flush=True)


if __name__ == "__main__":
    main()
