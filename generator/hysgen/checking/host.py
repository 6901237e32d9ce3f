"""Generated C on this machine: compiled with a driver that runs a function over arrays and records every state."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.codegen.render import render
from hysgen.machine.native import Library, Toolchain, build

Words = NDArray[np.uint32]


@dataclass(frozen=True)
class Entry:
    """A generated function that steps a state by one sample.

    name: without the model's prefix; state: its struct; inputs: float arguments after it; result: C type or "void".
    """

    name: str
    state: str
    inputs: int
    result: str


def entries(name: str, header: str) -> list[Entry]:
    """The functions that the header of model `name` declares with a struct and floats: init and the steps."""
    pattern = rf"^(float|void|uint32_t) {name}_(\w+)\(({name}_\w+) \*self((?:, float \w+)+)\);$"
    found = re.findall(pattern, header, re.MULTILINE)
    return [Entry(function, state, floats.count(","), result) for result, function, state, floats in found]


def channels(header: str) -> int:
    """How many auxiliary channels the model behind a header listens to."""
    told = re.search(r"^#define \w+_CHANNELS (\d+)u\b", header, re.MULTILINE)
    return int(told[1]) if told else 0


def commits(name: str, header: str) -> bool:
    """Whether the header of model `name` declares a commit."""
    return f"{name}_commit({name}_t *self, {name}_learner_t *learner);" in header


class Host:
    """A model's generated C, compiled by one toolchain.

    texts: file name -> text, as `emit.generate` returns them. Raises BuildError if the compiler refuses them.
    channels: auxiliary channels that the model listens to; selftested: there is a self-test among the texts; commits:
    there is a `<name>_commit`.
    """

    def __init__(self, name: str, texts: Mapping[str, str], toolchain: Toolchain | None = None) -> None:
        self.name = name
        header = texts[f"{name}.h"]
        self.entries = {entry.name: entry for entry in entries(name, header)}
        self.channels = channels(header)
        self.commits = commits(name, header)
        found = list(self.entries.values())
        facts = {"name": name, "entries": found, "channels": self.channels, "commits": self.commits}
        driver = render("driver.c.j2", facts)
        sources = [(file, text) for file, text in texts.items() if file.endswith((".c", ".h"))]
        declared = declarations(header) + "".join(_driver_declaration(entry) for entry in self.entries.values())
        declared += "int32_t driver_flushes(void);\n"
        if self.commits:
            declared += f"uint32_t driver_commit({name}_t *self, {name}_learner_t *learner, int32_t flush);\n"
        self.selftested = f"{name}_selftest.h" in texts
        if self.selftested:
            declared += f"uint32_t {name}_selftest(void);\n"
        self._library: Library = build([*sources, ("driver.c", driver)], declared, toolchain, libraries=())

    @property
    def flushes(self) -> bool:
        """Whether this machine can be told to flush denormal numbers to zero."""
        return bool(self._library.lib.driver_flushes())

    def struct(self, name: str) -> Any:
        """A zeroed `<name>` owned by the caller."""
        return self._library.ffi.new(f"{name} *")

    def instance(self, y_um: float, u_V: float) -> Any:
        """A new `<name>_t`, initialised at y_um and u_V."""
        self_t = self.struct(f"{self.name}_t")
        self.call("init", self_t, y_um, u_V)
        return self_t

    def call(self, function: str, *arguments: Any) -> Any:
        """`<name>_<function>(arguments)`."""
        return getattr(self._library.lib, f"{self.name}_{function}")(*arguments)

    def commit(self, instance: Any, learner: Any, *, flush: bool = False) -> int:
        """One call of `<name>_commit`: its answer. flush: with denormal numbers flushed to zero."""
        return int(self._library.lib.driver_commit(instance, learner, int(flush)))

    def words_of(self, struct: Any) -> Words:
        """The 32-bit words of a struct, as a live view."""
        return np.frombuffer(self._library.ffi.buffer(struct), dtype=np.uint32)

    def layout(self, struct: str) -> dict[str, int]:
        """Word index of every scalar in a struct, by its C path: `y_um`, `terms.memory.play[2]`, `bank[1].gain[0]`."""
        found: dict[str, int] = {}
        _walk(self._library.ffi.typeof(struct), "", 0, found)
        return found

    def run(
        self,
        function: str,
        struct: Any,
        inputs: Sequence[Words],
        *,
        first: int = 0,
        words: int = 0,
        flush: bool = False,
    ) -> tuple[Words, Words]:
        """Step `struct` through samples: (n,) results as bits, and (n, words) states from word `first` on.

        inputs: bits of each float argument, (n,) each, then of each auxiliary channel if the struct is an instance of a
        model that has some. flush: with denormal numbers flushed to zero.
        """
        ffi = self._library.ffi
        n = len(inputs[0])
        arrays = [np.ascontiguousarray(column, dtype=np.uint32) for column in inputs]
        out = np.empty(n, dtype=np.uint32)
        trace = np.empty((n, words), dtype=np.uint32)
        pointers = ffi.new("uint32_t const *[]", [ffi.from_buffer("uint32_t const *", array) for array in arrays])
        recorded = ffi.from_buffer("uint32_t *", trace) if words else ffi.NULL
        step = getattr(self._library.lib, f"driver_{function}")
        step(struct, n, pointers, ffi.from_buffer("uint32_t *", out), recorded, first, words, int(flush))
        return out, trace


def declarations(header: str) -> str:
    """What cffi is to know of a generated header: its text without comments and directives, sizes filled in."""
    text = re.sub(r"/\*.*?\*/", "", header, flags=re.DOTALL)
    sizes = dict(re.findall(r"^#define (\w+) (\d+)u\b", text, re.MULTILINE))
    text = re.sub(r"^#.*$", "", text, flags=re.MULTILINE)
    return re.sub(r"\[(\w+)\]", lambda match: f"[{sizes.get(match[1], match[1])}]", text)


def _driver_declaration(entry: Entry) -> str:
    return (
        f"void driver_{entry.name}({entry.state} *self, size_t n, const uint32_t *const in[], uint32_t *out,"
        " uint32_t *trace, size_t first, size_t words, int32_t flush);\n"
    )


def _walk(kind: Any, path: str, offset: int, found: dict[str, int]) -> None:
    if kind.kind == "struct":
        for field, member in kind.fields:
            _walk(member.type, f"{path}.{field}" if path else field, offset + member.offset, found)
    elif kind.kind == "array":
        size = 4 if kind.item.kind == "primitive" else _size(kind.item)
        for i in range(kind.length):
            _walk(kind.item, f"{path}[{i}]", offset + i * size, found)
    else:
        found[path] = offset // 4


def _size(kind: Any) -> int:
    """Bytes of a generated struct or array: all members are 32 bits wide."""
    words: dict[str, int] = {}
    _walk(kind, "", 0, words)
    return 4 * (max(words.values()) + 1)
