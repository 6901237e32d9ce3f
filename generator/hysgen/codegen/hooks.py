"""Named places in the templates where the proof inserts annotations or takes lines out.

`{% hook "finite: bits" %}`, alone on its line, renders to nothing in generated C. In the text for the proof it renders
to a line that holds HOOK and the name. A hook `guard: NAME | CALL INPUTS | C` stands before a line without which the
proof of CALL must fail, and holds the C in its place (tests/fixtures/guards.py).
"""

from __future__ import annotations

from typing import Final

from jinja2 import nodes
from jinja2.ext import Extension
from jinja2.parser import Parser

HOOK: Final = "//hook "
"""Start of the line of a hook; the rest of the line is the name."""


class Hook(Extension):
    """The tag `hook` in a template that renders to nothing."""

    tags = {"hook"}  # noqa: RUF012  # jinja2 declares it as a plain attribute

    def parse(self, parser: Parser) -> nodes.Node:
        """The tag and its name as an output node."""
        line = next(parser.stream).lineno
        return nodes.Output([self.call_method("line", [parser.parse_expression()])], lineno=line)

    def line(self, name: str) -> str:
        """The text that the hook `name` renders to."""
        return ""


class MarkedHook(Hook):
    """The tag `hook` that renders to a line with its name."""

    def line(self, name: str) -> str:
        return f"{HOOK}{name}\n"
