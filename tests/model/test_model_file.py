"""The model file: exact, deterministic, and refused with file and field when malformed."""

import dataclasses
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fixtures.printed_models import PRINTED_CENTRES_UM, appendix
from fixtures.random_models import random_model
from hysgen.certify.certificates import certify
from hysgen.errors import ModelError
from hysgen.model.disturbances.drift import Drift
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.file import dump_model, load_model, parse_model, save_model, shipped_models
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Model

TERMS = (Periodic((50.0, 101.7)), Drift(0.1, 0.05))


def same(one: Model, other: Model) -> bool:
    """Equal in every bit of every number, and in everything else."""
    arrays = (one.parameters.tobytes(), other.parameters.tobytes())
    plain = [dataclasses.replace(model, consequents=np.zeros((model.grid.rules, 3))) for model in (one, other)]
    texts = [dump_model(dataclasses.replace(model, weights=np.zeros(model.weights.size))) for model in plain]
    return arrays[0] == arrays[1] and texts[0] == texts[1] and one.grid == other.grid and one.terms == other.terms


@given(st.integers(0, 2**32 - 1), st.integers(2, 20), st.booleans())
@settings(max_examples=60)
def test_model_file_keeps_every_bit(seed: int, rules: int, extended: bool) -> None:
    model = random_model(seed, rules, terms=TERMS if extended else ())
    read = parse_model(dump_model(model), "m.json")
    assert same(model, read)
    assert dump_model(read) == dump_model(model)


def change(path: str, value: Any) -> Callable[[dict[str, Any]], None]:
    """Put `value` where `path` points; None removes the field."""

    def apply(data: dict[str, Any]) -> None:
        keys = path.split(".")
        for key in keys[:-1]:
            data = data[int(key) if isinstance(data, list) else key]  # type: ignore[call-overload]
        if value is None:
            del data[keys[-1]]
        else:
            data[int(keys[-1]) if isinstance(data, list) else keys[-1]] = value  # type: ignore[call-overload]

    return apply


MALFORMED: dict[str, Callable[[dict[str, Any]], None]] = {
    "schema: 'other' instead of 'hysgen-model'": change("schema", "other"),
    "version: 2 is not 1": change("version", 2),
    "version: None is not 1": change("version", None),
    "extra: no such field": change("extra", 1),
    "units: {'time': 'ms'": change("units.time", "ms"),
    "name: is missing": change("name", None),
    "name: 7 is not a string": change("name", 7),
    "Ts_s: '2e-5' is not a finite number": change("Ts_s", "2e-5"),
    "Ts_s: -1.0 is not a sampling period": change("Ts_s", -1.0),
    "Ts_s: 1000000": change("Ts_s", 10**400),
    "grid.rules: 6.0 is not a whole number": change("grid.rules", 6.0),
    "grid.rules: True is not a whole number": change("grid.rules", True),
    "grid.y_max_um: is missing": change("grid.y_max_um", None),
    "grid: [] is not an object": change("grid", []),
    "input_range_V: 1 numbers instead of 2": change("input_range_V", [1.0]),
    "consequents: shape (7, 3) does not fit 6 rules": lambda data: data["consequents"].append([0, 0, 0]),
    "consequents[2][1]: 'x' is not a finite number": change("consequents.2.1", "x"),
    "consequents[1]: 2 numbers instead of 3": change("consequents.1", [1.0, 2.0]),
    "terms[0]: 'drift' is not an object": change("terms.0", "drift"),
    "terms: kind 'magic' is unknown": change("terms.0.kind", "magic"),
    "terms: periodic: f_Hz must be positive and rising": change("terms.0.f_Hz", [3.0, 2.0]),
    "weights[0]: False is not a finite number": change("weights.0", False),
    "int too large": change("terms.0.f_Hz", [10**400]),
    "learner: worse: 1000": change("learner.worse", 10**400),
    "learner: learned: 7": change("learner.learned", 7),
    "learner: learned \\x1a": change("learner.learned", ["\x1a"]),
    "terms: kind 'xxx": change("terms.0.kind", "x" * 5000),
    "blocks: 3 is not a list": change("blocks", 3),
    "scores: 'good' is not an object": change("scores", "good"),
}


@pytest.mark.parametrize(("message", "spoil"), MALFORMED.items(), ids=list(MALFORMED))
def test_malformed_files_are_refused_in_one_line_with_file_and_field(
    message: str, spoil: Callable[[dict[str, Any]], None], tmp_path: Path
) -> None:
    data = json.loads(dump_model(dataclasses.replace(random_model(2, terms=TERMS), learner=LearnerSettings())))
    spoil(data)
    path = tmp_path / "spoilt.json"
    path.write_text(json.dumps(data), encoding="utf-8")
    with pytest.raises(ModelError) as refusal:
        load_model(path)
    line = str(refusal.value)
    assert message in line
    assert (line.startswith(f"{path}: "), line.isprintable(), len(line) < 600) == (True, True, True)


NOT_JSON = {
    "nothing": b"",
    "half a file": dump_model(random_model(2)).encode()[:400],
    "NaN": dump_model(random_model(2)).replace("2e-05", "NaN").encode(),
    "a field twice": dump_model(random_model(2)).replace('"name": ', '"name": "first", "name": ').encode(),
    "a deep nest": b"[" * 100_000,
    "not text": bytes(range(256)),
    "a list": b"[1, 2]",
}


@pytest.mark.parametrize("content", NOT_JSON.values(), ids=list(NOT_JSON))
def test_other_files_are_refused_in_one_line(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "m.json"
    path.write_bytes(content)
    with pytest.raises(ModelError, match=r"m\.json: .+") as refusal:
        load_model(path)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("earlier", "told"),
    [
        ({"calls_per_update": 8}, "calls_per_update 8: every update is one call now; fit again"),
        ({"learned": ["slope", "gain", "offset", "terms"]}, "learned terms: weights of terms are constant now"),
    ],
)
def test_settings_of_earlier_learners_are_refused_with_what_to_do(earlier: dict[str, Any], told: str) -> None:
    data = json.loads(dump_model(dataclasses.replace(load_model("appendix_a"), learner=LearnerSettings())))
    data["learner"] |= {"calls_per_update": 1}
    assert parse_model(json.dumps(data), "model.json").learner == LearnerSettings()
    data["learner"] |= earlier
    with pytest.raises(ModelError, match=told) as refused:
        parse_model(json.dumps(data), "model.json")
    assert "\n" not in str(refused.value)


def test_a_missing_file_names_the_models_that_ship() -> None:
    with pytest.raises(ModelError, match=r"nowhere.json: cannot be read .* appendix_a, appendix_b"):
        load_model("nowhere.json")


def test_shipped_files_are_what_the_tables_give() -> None:
    assert shipped_models() == tuple(sorted([*PRINTED_CENTRES_UM, "extended"]))
    for name in PRINTED_CENTRES_UM:
        shipped, made = load_model(name), appendix(name)
        assert same(dataclasses.replace(shipped, certificates={}), dataclasses.replace(made, certificates={}))
        for kind in ("gain", "contraction", "inverse"):
            assert shipped.certificates[kind]["holds"] == made.certificates[kind]["holds"]
        # Extrema are enclosed to 1e-6, and sums may round differently elsewhere.
        assert abs(shipped.certificates["contraction"]["slope"]["bound"] - certify(made).slope.bound) < 1e-6


def test_values_outside_json_cannot_be_saved(tmp_path: Path) -> None:
    for bad in (float("nan"), object()):
        with pytest.raises(ModelError, match="cannot be written as JSON"):
            save_model(dataclasses.replace(random_model(0), scores={"x": bad}), tmp_path / "m.json")
    assert not (tmp_path / "m.json").exists()
