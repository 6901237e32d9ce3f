"""The model file: JSON with a versioned schema, exact, in units, deterministic to the byte.

Every number is written with the fewest digits that read back as the same float64. Nothing in the file depends on the
machine or the clock. Reading executes no code and refuses unknown or malformed fields, naming file and field.
"""

import json
import os
import sys
from collections.abc import Mapping, Sequence
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from hysgen.display import Quantities
from hysgen.errors import HysgenError, ModelError
from hysgen.machine.files import write_whole
from hysgen.model.disturbances import Term, term_from_json
from hysgen.model.feedback import Feedback
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import SCHEMA, VERSION, Grid, Model
from hysgen.model.path import InputBlock, block_from_json

SUFFIX = ".json"

Kind = TypeVar("Kind")
KINDS = {"dict": "an object", "list": "a list", "str": "a string", "int": "a whole number"}


def dump_model(model: Model) -> str:
    """The text of the model file. Raises ModelError if history, scores or certificates contain non-JSON values."""
    try:
        return _text(model.to_json()) + "\n"
    except (TypeError, ValueError) as fault:
        raise ModelError(
            f"{model.name}: cannot be written as JSON ({fault}); keep plain finite values in it"
        ) from fault


def save_model(model: Model, path: str | os.PathLike[str]) -> None:
    """Write the model file, whole or not at all. Raises HysgenError if the folder cannot be written."""
    write_whole(Path(path), dump_model(model))


def parse_model(text: str, source: str) -> Model:
    """The model that `dump_model` wrote; `source` names the file in messages.

    Raises ModelError with one line: file, field, what is wrong, what to do.
    """
    try:
        data = json.loads(text, parse_constant=_refuse_constant, object_pairs_hook=_unique)
    except (ValueError, RecursionError) as fault:
        raise ModelError(f"{source}: is not a model file ({fault}); write it with hysgen fit") from fault
    try:
        return _model(_as(dict, data, "file"))
    except (ModelError, OverflowError) as fault:
        # A name may be that of no character, or fill a page.
        plain = "".join(c if c.isprintable() else repr(c)[1:-1] for c in str(fault))
        raise ModelError(f"{source}: {plain if len(plain) <= 400 else plain[:397] + '...'}") from fault


def model_of(given: Any) -> Model:
    """A Model from itself, or from the name of a file or of a shipped model. Raises ModelError for anything else."""
    if isinstance(given, Model):
        return given
    if isinstance(given, (str, os.PathLike)):
        return load_model(Path(given))
    raise ModelError(f"a {type(given).__name__} is no model; give a Model, or the name of its file")


def load_model(path_or_name: Path | str) -> Model:
    """A model from a file, or one that ships with hysgen by its name (`shipped_models`).

    Raises ModelError if the file is missing, unreadable or malformed.
    """
    if not isinstance(path_or_name, (str, os.PathLike)):
        raise ModelError(
            f"a {type(path_or_name).__name__} is no name of a model; give a path, or a shipped model's name"
        )
    path = Path(path_or_name)
    if str(path_or_name) in shipped_models() and not path.exists():
        text = (_shipped() / f"{path_or_name}{SUFFIX}").read_text(encoding="utf-8")
        return parse_model(text, f"{path_or_name}{SUFFIX}")
    try:
        return parse_model(path.read_text(encoding="utf-8"), str(path))
    except OSError as fault:
        raise ModelError(
            f"{path}: cannot be read ({fault.strerror}); give a model file, or one of {', '.join(shipped_models())}"
        ) from fault
    except UnicodeDecodeError as fault:
        raise ModelError(f"{path}: is not a text file (byte {fault.start}); give a model file") from fault


def is_model(path_or_name: str) -> bool:
    """Whether a name is that of a shipped model, or of a file that says it is one."""
    path = Path(path_or_name)
    if path.is_file():
        with path.open("rb") as stream:
            return f'"{SCHEMA}"'.encode() in stream.read(200)
    return path_or_name in shipped_models()


def shipped_models() -> tuple[str, ...]:
    """Names of the models that ship with hysgen."""
    entries = (entry.name for entry in _shipped().iterdir())
    return tuple(sorted(name.removesuffix(SUFFIX) for name in entries if name.endswith(SUFFIX)))


def _model(data: Mapping[str, Any]) -> Model:
    """The model of a parsed file. Raises ModelError naming the field."""
    if data.get("schema") != SCHEMA:
        raise ModelError(f"schema: {data.get('schema')!r} instead of {SCHEMA!r}; this is not a model file")
    if data.get("version") != VERSION:
        raise ModelError(f"version: {data.get('version')!r} is not {VERSION}; read it with the hysgen that wrote it")
    grid = _as(dict, _get(data, "grid"), "grid")
    input_range = _numbers(_get(data, "input_range_V"), "input_range_V", 2)
    rules = _as(int, _get(grid, "rules", "grid."), "grid.rules")
    model = Model(
        name=_as(str, _get(data, "name"), "name"),
        Ts_s=_number(_get(data, "Ts_s"), "Ts_s"),
        grid=Grid(
            _number(_get(grid, "y_min_um", "grid."), "grid.y_min_um"),
            _number(_get(grid, "y_max_um", "grid."), "grid.y_max_um"),
            rules,
            _centres_range(grid["spread_um"]) if "spread_um" in grid else None,
        ),
        consequents=np.array(
            [
                _numbers(row, f"consequents[{i}]", 3)
                for i, row in enumerate(_as(list, _get(data, "consequents"), "consequents"))
            ]
        ).reshape(-1, 3),
        u_min_V=float(input_range[0]),
        u_max_V=float(input_range[1]),
        terms=_terms(_as(list, _get(data, "terms"), "terms")),
        weights=_numbers(_get(data, "weights"), "weights"),
        blocks=_blocks(_as(list, _get(data, "blocks"), "blocks")),
        learner=LearnerSettings.from_json(_as(dict, data["learner"], "learner")) if "learner" in data else None,
        feedback=Feedback.from_json(_as(dict, data["feedback"], "feedback")) if "feedback" in data else None,
        quantities=_quantities(_as(dict, _get(data, "units"), "units")),
        history=_as(dict, _get(data, "history"), "history"),
        scores=_as(dict, _get(data, "scores"), "scores"),
        certificates=_as(dict, _get(data, "certificates"), "certificates"),
    )
    for unknown in data.keys() - model.to_json().keys():
        raise ModelError(f"{unknown}: no such field in version {VERSION}; remove it")
    return model


def _centres_range(value: Any) -> tuple[float, float]:
    first, last = _numbers(value, "grid.spread_um", 2)
    return float(first), float(last)


def _quantities(units: Mapping[str, Any]) -> Quantities:
    """From the units by quantity: of the time, the input and the output. A voltage is in V, a displacement in um."""
    names, own = list(units), Quantities()
    known = {"time": "s", own.input: own.input_unit, own.output: own.output_unit}
    if len(names) != 3 or names[0] != "time" or any(units[name] != known.get(name, units[name]) for name in names):
        raise ModelError(f"units: {dict(units)!r} instead of {known!r}; convert the numbers and write these units")
    try:
        return Quantities.of(*(f"{name} [{units[name]}]" for name in names[1:]))
    except HysgenError as fault:
        raise ModelError(f"units: {fault}") from fault


def _terms(entries: Sequence[Any]) -> tuple[Term, ...]:
    return tuple(term_from_json(_as(dict, entry, f"terms[{i}]")) for i, entry in enumerate(entries))


def _blocks(entries: Sequence[Any]) -> tuple[InputBlock, ...]:
    return tuple(block_from_json(_as(dict, entry, f"blocks[{i}]")) for i, entry in enumerate(entries))


def _get(data: Mapping[str, Any], key: str, path: str = "") -> Any:
    if key not in data:
        raise ModelError(f"{path}{key}: is missing; write the file with hysgen, do not edit it")
    return data[key]


def _fault(field: str, value: Any, expected: str) -> ModelError:
    shown = repr(value)
    shown = shown if len(shown) <= 40 else shown[:37] + "..."
    return ModelError(f"{field}: {shown} is not {expected}; write the file with hysgen, do not edit it")


def _as(kind: type[Kind], value: Any, field: str) -> Kind:
    if not isinstance(value, kind) or isinstance(value, bool):
        raise _fault(field, value, KINDS[kind.__name__])
    return value


def _number(value: Any, field: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= sys.float_info.max:
        raise _fault(field, value, "a finite number")
    return float(value)


def _numbers(value: Any, field: str, size: int | None = None) -> NDArray[np.float64]:
    entries = _as(list, value, field)
    if size is not None and len(entries) != size:
        raise ModelError(f"{field}: {len(entries)} numbers instead of {size}; write the file with hysgen")
    return np.array([_number(entry, f"{field}[{i}]") for i, entry in enumerate(entries)], dtype=np.float64)


def _refuse_constant(text: str) -> float:
    raise ValueError(f"{text} is not a JSON number")


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    data = dict(pairs)
    if len(data) != len(pairs):
        keys = [key for key, _ in pairs]
        raise ValueError(f"field {next(key for key in keys if keys.count(key) > 1)!r} stands twice")
    return data


def _text(value: Any, indent: int = 0) -> str:
    """JSON with one field per line and lists of scalars on one line, for readable diffs of two models."""
    inner, outer = " " * (indent + 2), " " * indent
    if isinstance(value, dict) and value:
        fields = (f"{inner}{json.dumps(key)}: {_text(entry, indent + 2)}" for key, entry in value.items())
        return "{\n" + ",\n".join(fields) + f"\n{outer}}}"
    if isinstance(value, list | tuple) and any(isinstance(entry, dict | list | tuple) for entry in value):
        return "[\n" + ",\n".join(f"{inner}{_text(entry, indent + 2)}" for entry in value) + f"\n{outer}]"
    return json.dumps(value, allow_nan=False)


def _shipped() -> Traversable:
    """The folder of the models that ship with hysgen."""
    return resources.files(__package__) / "shipped"
