"""The generated C with the lines of a proof at the hooks of its templates."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence

from hysgen.codegen import marked_source
from hysgen.codegen.hooks import HOOK
from hysgen.codegen.interface import interface_of
from hysgen.errors import ModelError
from hysgen.model.model import Model


def hooked(model: Model, texts: Mapping[str, str], lines: Mapping[str, Sequence[str]]) -> str:
    """`<name>.c` of generated `texts` with `lines` inserted at the hooks that bear their names.

    The templates give the places. A text that was changed after its generation, by a guard taken out, keeps every hook
    beside an unchanged line. Raises ModelError if both lines beside a hook have changed.
    """
    source = texts[f"{model.name}.c"].splitlines(keepends=True)
    places: list[tuple[int, str]] = []
    plain: list[str] = []
    inverse = interface_of(model.name, texts).has("inverse")
    for line in marked_source(model, inverse=inverse).splitlines(keepends=True):
        if line.startswith(HOOK):
            places.append((len(plain), line.removeprefix(HOOK).rstrip("\n")))
        else:
            plain.append(line)
    moved = _same_lines(plain, source)
    found = []
    start = 0
    for place, name in places:
        if name not in lines:
            continue
        if place - 1 in moved:
            end = moved[place - 1] + 1
        elif place in moved:
            end = moved[place]
        else:
            raise ModelError(f"{model.name}: the lines at the hook `{name}` are not those of the templates")
        found += [*source[start:end], *(f"{line}\n" for line in lines[name])]
        start = end
    return "".join([*found, *source[start:]])


def hook_names(model: Model, texts: Mapping[str, str]) -> list[str]:
    """Names of the hooks in the templates of `<name>.c`, in the order of the text."""
    marked = marked_source(model, inverse=interface_of(model.name, texts).has("inverse"))
    return [line.removeprefix(HOOK) for line in marked.splitlines() if line.startswith(HOOK)]


def _same_lines(one: Sequence[str], other: Sequence[str]) -> dict[int, int]:
    """Index in `other` of the lines of `one` that are the same there."""
    if one == other:
        return {i: i for i in range(len(one))}
    blocks = difflib.SequenceMatcher(None, one, other, autojunk=False).get_matching_blocks()
    return {block.a + i: block.b + i for block in blocks for i in range(block.size)}
