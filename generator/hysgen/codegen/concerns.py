"""What a concern beyond prediction (learning, committing) adds to the generated files without touching the others.

A concern brings a template with the macros `declarations()` for the header and `definitions()` for the source, the
facts that they print, and its sections of `<name>_params.h`. If it brings a self-test, that template has the macros
`functions()`, a static function with its tables, and `call()`, an expression that runs it: the number of mismatches.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hysgen.codegen.parameters import Section


@dataclass(frozen=True)
class Concern:
    """template: file in templates/; facts: names for its macros; sections: its numbers; selftest: file or none."""

    template: str
    facts: Mapping[str, Any] = field(default_factory=dict)
    sections: Sequence[Section] = ()
    selftest: str | None = None
