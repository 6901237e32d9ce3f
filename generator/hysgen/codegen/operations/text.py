"""Syntax tree of generated C, with a preprocessor for the directives that generated C uses.

Code within include guards is kept, and code under `#ifdef` of a known macro. Of `#if` the `#else` branch is kept, which
is the portable one. Macros without parameters are replaced by their definitions.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from pycparser import CParser, c_ast

from hysgen.errors import HysgenError

_PRELUDE = "typedef unsigned int uint32_t; typedef int int32_t; typedef unsigned long long uint64_t;\n"
_DIRECTIVE = re.compile(r"\s*#\s*(\w+)\s*(.*)")
_DEFINE = re.compile(r"(\w+)(\(\))?\s*(.*)")


def syntax_tree(texts: Mapping[str, str], names: tuple[str, ...]) -> c_ast.FileAST:
    """The syntax tree of the concatenated files `names`; the macros of a file are defined in the files after it.

    Raises HysgenError at a preprocessor directive that generated code does not use.
    """
    return parsed(concatenated(texts, names), names[-1])


def concatenated(texts: Mapping[str, str], names: tuple[str, ...], defined: tuple[str, ...] = ()) -> str:
    """The preprocessed text of the files `names`; the macros of a file are defined in the files after it.

    defined: macros without a value that are defined in every file.
    """
    macros: dict[str, str] = {"UINT32_MAX": "4294967295u", **dict.fromkeys(defined, "")}
    return "".join(preprocessed(texts[name], macros) for name in names)


def parsed(text: str, name: str) -> c_ast.FileAST:
    """The syntax tree of a preprocessed text."""
    return CParser().parse(_PRELUDE + text, filename=name)


def preprocessed(text: str, macros: dict[str, str]) -> str:
    """`text` without comments and directives, macros replaced; adds the macros that `text` defines to `macros`."""
    text = re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL).replace("\\\n", " ")
    kept: list[str] = []
    open_branches: list[bool] = []
    for line in text.splitlines():
        directive = _DIRECTIVE.fullmatch(line)
        if directive is None:
            if all(open_branches):
                kept.append(_replaced(line, macros))
            continue
        word, rest = directive[1], directive[2].strip()
        if word in ("if", "ifdef", "ifndef"):
            open_branches.append((rest in macros) == (word == "ifdef") and word != "if")
        elif word in ("elif", "else"):
            open_branches[-1] = word == "else" and not open_branches[-1]
        elif word == "endif":
            open_branches.pop()
        elif word == "define" and all(open_branches):
            _define(rest, macros)
        elif word not in ("include", "error", "pragma", "define", "undef"):
            raise HysgenError(f"#{word}: generated C does not use this directive; only generated files can be counted")
    return "\n".join(kept) + "\n"


def _define(rest: str, macros: dict[str, str]) -> None:
    parts = _DEFINE.fullmatch(rest)
    if parts is None:
        raise HysgenError(f"#define {rest}: generated C does not use macros with parameters")
    name, call, value = parts[1], parts[2] or "", parts[3].strip()
    macros[name + call] = _replaced(value, macros)


def _replaced(line: str, macros: Mapping[str, str]) -> str:
    def replacement(match: re.Match[str]) -> str:
        return macros.get(match[0], macros.get(match[1], match[1]) + match[2])

    return re.sub(r"\b([A-Za-z_]\w*)\b((?:\(\))?)", replacement, line)
