"""The project file: options of the command line, read from `hysgen.toml` in the working folder.

    [record]                    options of every verb that reads a record
    columns = "voltage=U [V],displacement=Sensor [nm],time=t [ms]"
    jitter = 0.1

    [diagnose]                  options of one verb
    rules = 8

A key is the long name of an option. An option on the command line wins.
"""

from __future__ import annotations

import argparse
import tomllib
from pathlib import Path
from typing import Any

from hysgen.errors import HysgenError

NAME = "hysgen.toml"
RECORD = "record"
"""Table whose options are those of every verb that reads a record."""


def project_options(verb: str, parser: argparse.ArgumentParser, known: tuple[str, ...]) -> dict[str, Any]:
    """Defaults for the parser of a verb, by destination. known: names of all verbs.

    Raises HysgenError for a file that is no TOML, for a table that is no verb, and for a key that is no option.
    """
    path = Path(NAME)
    if not path.is_file():
        return {}
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as fault:
        raise HysgenError(f"{NAME}: cannot be read ({fault}); correct it, or remove it") from fault
    for table, options in tables.items():
        if not isinstance(options, dict):
            raise HysgenError(f"{NAME}: {table} stands outside a table; write it below [{RECORD}] or a verb")
        if table != RECORD and table not in known:
            raise HysgenError(f"{NAME}: [{table}] is no verb; write [{RECORD}] or one of {', '.join(known)}")
    actions = {
        option[2:]: action for action in parser._actions for option in action.option_strings if option.startswith("--")
    }
    given: dict[str, Any] = {}
    for table in (RECORD, verb):
        for key, value in tables.get(table, {}).items():
            action = actions.get(key.replace("_", "-"))
            if action is not None:
                given[action.dest] = _converted(action, key, value)
            elif table == verb or "columns" in actions:
                from hysgen.record.columns import nearest  # imports NumPy, which --help does without

                raise HysgenError(
                    f"{NAME}: [{table}] {key}: hysgen {verb} has no option --{key}{nearest(key, actions)}; "
                    f"see hysgen {verb} --help"
                )
    return given


def _converted(action: argparse.Action, key: str, value: Any) -> Any:
    """A value as the option would have it. Raises HysgenError if it does not suit."""
    try:
        if action.type is not None and not isinstance(value, (bool, list)):
            value = action.type(str(value))  # type: ignore[operator]
    except (TypeError, ValueError) as fault:
        raise HysgenError(f"{NAME}: {key} = {value!r} does not suit --{key}; correct it") from fault
    if action.choices is not None:
        for item in value if isinstance(value, list) else [value]:
            if item not in action.choices:
                raise HysgenError(f"{NAME}: {key} = {item!r}: choose from {', '.join(map(str, action.choices))}")
    return value
