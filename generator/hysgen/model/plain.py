"""Frozen dataclasses as plain JSON values and back: terms and input blocks in a model file."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

READERS: Mapping[str, Callable[[Any], Any]] = {
    "float": float,
    "int": int,
    "str": str,
    "tuple[float, ...]": lambda values: tuple(float(value) for value in values),
    "tuple[str, ...]": lambda values: tuple(str(value) for value in values),
}
"""How a field is read, by its annotation; bool is strict."""


def to_plain(one: Any) -> dict[str, Any]:
    """Fields of a dataclass by name, in their order, tuples as lists; exact."""
    values = {item.name: getattr(one, item.name) for item in dataclasses.fields(one)}
    return {name: list(value) if isinstance(value, tuple) else value for name, value in values.items()}


def arguments(kind: type[Any], data: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of a dataclass out of `to_plain` of it; a field with a default may be missing.

    Raises KeyError if a field is missing, TypeError or ValueError if a value is malformed or the annotation of a field
    is not in READERS.
    """
    found: dict[str, Any] = {}
    for item in dataclasses.fields(kind):
        if item.name not in data and item.default is not dataclasses.MISSING:
            continue
        value = data[item.name]
        if item.type == "bool":
            if not isinstance(value, bool):
                raise TypeError(f"{item.name} must be true or false")
            found[item.name] = value
        elif isinstance(item.type, str) and item.type in READERS:
            found[item.name] = READERS[item.type](value)
        else:
            raise TypeError(
                f"{item.name}: no reader for {item.type}; write to_json() and from_json() of {kind.__name__}"
            )
    return found
