"""What the proofs are made for in the tests: the paper's models and one with every term, every block and a learner."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping

from generated_models import everything

from hysgen.emit import Options, generate
from hysgen.learning import LearnerSettings
from hysgen.model import Model
from hysgen.model_file import load_model


@functools.lru_cache(maxsize=8)
def model(name: str) -> Model:
    """`appendix_a`, `appendix_b` or `everything`."""
    if name == "everything":
        return dataclasses.replace(everything(), learner=LearnerSettings())
    return load_model(name)


@functools.lru_cache(maxsize=8)
def texts(name: str) -> Mapping[str, str]:
    """The generated C of that model, for a processor fast enough for all of it."""
    return generate(model(name), Options(clock_Hz=2e9))
