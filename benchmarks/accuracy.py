"""Largest error of a step that a sweep finds, beside its proved bound.

python benchmarks/accuracy.py MODEL... --samples 100000000    minutes each; a MODEL is that of a file, one that comes
    with hysgen, a function of tests/fixtures/generated_models.py, `structure` of benchmarks/proofs.py, `smooth_N` of N
    rules, or the kind of a block or of a disturbance: the rules of `path` behind it alone, or beside it
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import numpy as np
from proofs import structure

from hysgen.float32.reference.accuracy import accuracy
from hysgen.model import disturbances, regression
from hysgen.model import path as blocks
from hysgen.model.file import load_model
from hysgen.model.model import Model


def model_of(name: str) -> Model:
    """The model of a name on the command line."""
    from fixtures import generated_models

    made = ("path", "diagnosed", "everything")
    makers = {"structure": structure} | {maker: getattr(generated_models, maker) for maker in made}
    if name in makers:
        return makers[name]()
    if name.startswith("smooth_"):
        return generated_models.smooth(int(name.removeprefix("smooth_")))
    path, rng = generated_models.path(), np.random.default_rng(1)
    if name in disturbances.kinds():
        term = disturbances.kinds()[name].examples(rng)[0]
        weights = np.resize([1e-2, -1e-2], term.size)
        return dataclasses.replace(path, name=name, blocks=(), terms=(term,), weights=weights)
    if name in blocks.kinds():
        own = [block for block in path.blocks if block.kind == name] or blocks.kinds()[name].examples(rng)
        return dataclasses.replace(path, name=name, blocks=(own[0],))
    return load_model(name)


def main() -> None:
    """Print a line for each model: found, bound, and bound over found."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("models", nargs="+", metavar="MODEL")
    parser.add_argument("--samples", type=int, default=4_000_000)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    # The truth of a sweep need not have the same bits on every machine.
    setattr(regression, "exponential", np.exp)  # noqa: B010  # the type checker
    print(f"{'model':12} {'samples':>10} {'of':22} {'found':>9} {'bound':>9} ratio")
    for name in arguments.models:
        begun, model = time.monotonic(), model_of(name)
        solved = all(block.solves(model.Ts_s) for block in model.blocks)
        found = accuracy(model, arguments.samples, inverse=solved, seed=arguments.seed)
        inverse = ("predict_of_inverse_um", "inverse_um") if model.responds else ("inverse_V", "inverse_V")
        for field, of_bound in (("predict_um", "predict_um"), ("path", "path"), inverse, ("correct_um", "correct_um")):
            most, bound = getattr(found, field), getattr(found.proved, of_bound, None)
            if most:
                said = "none" if bound is None else f"{bound:9.3g} {bound / most:5.2f}"
                took = f"{time.monotonic() - begun:.0f} s"
                print(f"{name:12} {found.samples:10} {field:22} {most:9.3g} {said}  {took}", flush=True)


if __name__ == "__main__":
    main()
