"""model.h binds the firmware to one generated model; the hand-written C of the firmware."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.certify.certificates import certify
from hysgen.codegen import Options, generate
from hysgen.codegen.parameters import Constant
from hysgen.codegen.render import render
from hysgen.errors import ModelError
from hysgen.float32.coefficients import coefficients, commit_numbers
from hysgen.machine.files import data_folder, digest, version
from hysgen.model.file import dump_model
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Model
from hysgen.model.path import preview

BINDING: Final = "model.h"
TYPES: Final = ("t", "bank_t", "learner_t")
FUNCTIONS: Final = ("init", "simulate", "limits", "inverse", "learn_init", "learn", "commit", "selftest", "correct")
"""Structs and functions of the generated model that the firmware uses, under the names `model_t`, `model_init`, ..."""


def firmware_model(model: Model, *, aligned: bool = False, forced: bool = False) -> dict[str, str]:
    """The files of the model's folder in firmware/models by name: generated C and model.h.

    aligned: whether the learner is aligned for kernels; forced: as in `Options`.

    Raises ModelError if the firmware cannot drive the model, and the errors of `generate`.
    """
    require_drivable(model)
    model = unphased(model)
    return generate(model, Options(aligned=aligned, forced=forced)) | {BINDING: binding(model)}


def unphased(model: Model) -> Model:
    """The model with weight 0 for its periodic disturbances: their phase at the board's START is unknown, and with a
    wrong one they would add to the error."""
    gains = [0.0 if term.timed else 1.0 for term in model.terms for _ in range(term.size)]
    return replace(model, weights=model.weights * gains) if 0.0 in gains else model


def with_learner(model: Model) -> Model:
    """The model with a learner of the rules' consequents.

    alpha is small, so the prior holds the parameters near their identified values, and the forgetting factor is 1 until
    the window is full. One sine does not excite all parameters; without these settings the unexcited ones would drift
    until commit refuses them.
    """
    return replace(model, learner=LearnerSettings(forgetting=1.0, alpha=1e-6))


def require_drivable(model: Model) -> None:
    """Raise ModelError unless the model has a learner and needs no auxiliary channels."""
    if model.learner is None:
        raise ModelError(
            f"{model.name}: has no learner settings, whose commit certifies parameter images; fit or generate with "
            "a learner"
        )
    if model.quantities.other:
        raise ModelError(
            f"{model.name}: has quantities that the firmware's board layer does not set and read ('V', 'um')"
        )
    if model.channels:
        raise ModelError(f"{model.name}: listens to auxiliary channels, which the firmware's board layer does not have")


def binding(model: Model) -> str:
    """The text of model.h."""
    numbers = coefficients(model)
    commit = commit_numbers(model, numbers, certify(model))
    constants = [
        Constant("Y_MIN_UM", numbers.y_min_um),
        Constant("Y_MAX_UM", numbers.y_max_um),
        Constant("U_MIN_V", numbers.u_min_V),
        Constant("U_MAX_V", numbers.u_max_V),
        Constant("PERIOD_NS", np.uint32(round(1e9 * model.Ts_s))),
        Constant("COMMIT_POINTS", np.uint32(commit.points)),
        Constant("COMMIT_MATURE", np.uint32(commit.settings.mature)),
    ]
    facts = {
        "name": model.name,
        "NAME": model.name.upper(),
        "version": version(),
        "weights": len(model.weights),
        "preview": preview(model.blocks),
        "functions": FUNCTIONS[: len(FUNCTIONS) - (model.feedback is None)],
        "types": typedefs(model.name),
        "constants": constants,
        "build": f"0x{build_id(model):08x}u",
        "digest": [f"0x{word:08x}u" for word in structure_digest(model)],
    }
    return render("firmware/model.h.j2", facts)


def typedefs(name: str) -> list[str]:
    """The firmware's names for the structs of model `name`, as C."""
    return [f"typedef {name}_{struct} model_{struct};" for struct in TYPES]


def build_id(model: Model) -> int:
    """One word of the SHA-256 of the model file, never 0: the build of a firmware with these built-in numbers."""
    return int(digest(dump_model(unphased(model)).encode())[:8], 16) or 1


def structure_digest(model: Model) -> tuple[int, ...]:
    """Four words of the SHA-256 of name, sampling period, ranges, partition, and shapes of terms, blocks and feedback.

    Models with equal digests differ only in the numbers of a bank (rules, weights, integral of the feedback) and in
    their history.
    """
    numbers, loop = coefficients(model), model.feedback
    fixed: dict[str, Any] = {
        "name": model.name,
        "Ts_s": model.Ts_s.hex(),
        "rules": numbers.rules,
        "ranges": _hex([numbers.y_min_um, numbers.y_max_um, numbers.u_min_V, numbers.u_max_V]),
        "partition": _hex([numbers.origin_um, numbers.per_step, *numbers.strength]),
        "terms": [[term.kind, term.size, _shapes(term.constants(model.Ts_s))] for term in model.terms],
        "blocks": [[block.kind, _shapes(block.constants(model.Ts_s))] for block in model.blocks],
    }
    if loop is not None:
        filtered = {} if loop.filter is None else _shapes(loop.filter.constants(model.Ts_s))
        fixed["feedback"] = [filtered, _hex([np.float32(loop.limit_um)])]
    whole = digest(json.dumps(fixed, sort_keys=True).encode())
    return tuple(int(whole[8 * i : 8 * i + 8], 16) for i in range(4))


def _shapes(tables: Mapping[str, NDArray[Any]]) -> dict[str, str]:
    return {name: np.ascontiguousarray(values).tobytes().hex() for name, values in tables.items()}


def _hex(values: list[np.float32]) -> str:
    return np.array(values, dtype="<f4").tobytes().hex()


CONTROLLER: Final = "controller"
HOST_BOARD: Final = "board/host"
SIMULATOR_BOARD: Final = "board/simulator"
TARGET_BOARD: Final = "board/c6748"
EMPTY_STORE: Final = ("board", "empty_store.c")
"""Folder and name of the parameter store without memory, of SIMULATOR_BOARD and of boards without flash."""

Sources = list[tuple[str, str]]


def firmware_folder() -> Path:
    """The folder of controller/ and board/. Raises BuildError if the installation lacks them."""
    return data_folder("firmware", holds=CONTROLLER)


def read_sources(folder: str, *patterns: str) -> Sources:
    """(file name, text) of the files in `folder` that match `patterns` (default: the C), sorted by name."""
    paths = [path for pattern in patterns or ("*.[ch]",) for path in (firmware_folder() / folder).glob(pattern)]
    return [(path.name, path.read_text(encoding="utf-8")) for path in sorted(paths)]
