"""Generated C in a folder of its own for tools that look at files, with lines of a proof at the hooks."""

import difflib
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from hysgen.codegen import marked_source
from hysgen.codegen.manifest import c_files
from hysgen.codegen.render import HOOK
from hysgen.codegen.structs import interface_of
from hysgen.errors import ModelError
from hysgen.model.model import Model


@contextmanager
def folder_of(texts: Mapping[str, str]) -> Iterator[Path]:
    """A folder with the C sources and headers among `texts`, gone afterwards."""
    with tempfile.TemporaryDirectory(prefix="hysgen-") as scratch:
        for file, text in c_files(texts).items():
            Path(scratch, file).write_text(text, encoding="utf-8", newline="\n")
        yield Path(scratch)


@dataclass(frozen=True)
class _Hooks:
    """The hooks of the templates of `<name>.c`: lines of the C, and (number of lines before it, name) of each hook."""

    lines: list[str]
    places: list[tuple[int, str]]


def hooked(model: Model, texts: Mapping[str, str], lines: Mapping[str, Sequence[str]]) -> str:
    """`<name>.c` of generated `texts` with `lines` inserted at the hooks that bear their names.

    The templates give the places. In a text that has changed since its generation, for example without a guard, a hook
    is found by an unchanged line before or behind it. Raises ModelError if both lines have changed.
    """
    source = texts[f"{model.name}.c"].splitlines(keepends=True)
    hooks = _hooks(model, texts)
    moved = _same_lines(hooks.lines, source)
    parts: list[str] = []
    start = 0
    for place, name in hooks.places:
        if name not in lines:
            continue
        if place - 1 in moved:
            end = moved[place - 1] + 1
        elif place in moved:
            end = moved[place]
        else:
            raise ModelError(f"{model.name}: the lines at the hook `{name}` are not those of the templates")
        parts += [*source[start:end], *(f"{line}\n" for line in lines[name])]
        start = end
    return "".join([*parts, *source[start:]])


def hook_names(model: Model, texts: Mapping[str, str]) -> list[str]:
    """Names of the hooks in the templates of `<name>.c`, in the order of the text."""
    return [name for _, name in _hooks(model, texts).places]


def _hooks(model: Model, texts: Mapping[str, str]) -> _Hooks:
    hooks = _Hooks([], [])
    inverse = interface_of(model.name, texts).has("inverse")
    for line in marked_source(model, inverse=inverse).splitlines(keepends=True):
        if line.startswith(HOOK):
            hooks.places.append((len(hooks.lines), line.removeprefix(HOOK).rstrip("\n")))
        else:
            hooks.lines.append(line)
    return hooks


def _same_lines(one: Sequence[str], other: Sequence[str]) -> dict[int, int]:
    """Index in `other` of the lines of `one` that are the same there."""
    if one == other:
        return {i: i for i in range(len(one))}
    blocks = difflib.SequenceMatcher(None, one, other, autojunk=False).get_matching_blocks()
    return {block.a + i: block.b + i for block in blocks for i in range(block.size)}
