"""What proofs are made for: the paper's models, one that learns, an extended one, and one with everything there is.

python tests/proof_models.py DIR     writes what is generated for each of them into DIR
"""

from __future__ import annotations

import argparse
import dataclasses
import functools
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from generated_models import everything, extended, learning

from hysgen.emit import Options, generate, write
from hysgen.learning import LearnerSettings
from hysgen.model import Model
from hysgen.model_file import load_model

NAMES: Final = ("appendix_a", "appendix_b", "learning", "extended", "everything", "everything_spread")


@functools.lru_cache(maxsize=8)
def model(name: str) -> Model:
    """One of NAMES."""
    if name == "learning":
        return learning()
    if name == "extended":
        return extended()
    if name == "everything_spread":  # what fits into one period of the target: an update takes six of them
        return dataclasses.replace(everything(), name=name, learner=LearnerSettings(calls_per_update=6))
    if name == "everything":
        return dataclasses.replace(everything(), learner=LearnerSettings())
    return load_model(name)


@functools.lru_cache(maxsize=8)
def texts(name: str) -> Mapping[str, str]:
    """The generated C of that model, for a processor fast enough for all of it."""
    return generate(model(name), Options(clock_Hz=2e9))


def main() -> None:
    """Write the generated folders, for the long runs that docs/target.md names."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    for name in NAMES:
        write(texts(name), folder / name)
        print(folder / name)


if __name__ == "__main__":
    main()
