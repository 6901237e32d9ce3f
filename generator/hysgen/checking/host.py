"""Generated C on this machine: compiled with a driver that runs a function over arrays and records every state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.codegen.interface import Function, interface_of
from hysgen.codegen.manifest import c_files
from hysgen.codegen.render import render
from hysgen.machine.native import Library, Toolchain, build

Words = NDArray[np.uint32]


class Host:
    """A model's generated C, compiled by one toolchain.

    texts: file name -> text, as `generate` returns them. declarations: C prototypes of functions that the texts define
    beside the interface. Raises BuildError if the compiler refuses the texts.
    entries: the functions that step a struct by one sample, by name; channels: auxiliary channels that the model
    listens to; selftested: there is a self-test among the texts; commits: there is a `<name>_commit`.
    """

    def __init__(
        self, name: str, texts: Mapping[str, str], toolchain: Toolchain | None = None, *, declarations: str = ""
    ) -> None:
        self.name = name
        self.interface = interface_of(name, texts)
        self.entries = {function.name: function for function in self.interface.functions if function.floats}
        self.channels = self.interface.channels
        self.commits = self.interface.has("commit")
        self.selftested = f"{name}_selftest.c" in texts
        facts = {
            "name": name,
            "structs": self.interface.structs,
            "entries": list(self.entries.values()),
            "channels": self.channels,
            "commits": self.commits,
        }
        driver = render("driver.c.j2", facts)
        sources = list(c_files(texts).items())
        declared = self.interface.declarations() + declarations
        declared += "".join(_driver_declaration(entry) for entry in self.entries.values())
        declared += "int32_t hysgen_driver_flushes(void);\n"
        if self.commits:
            declared += f"uint32_t hysgen_driver_commit({name}_t *self, {name}_learner_t *learner, int32_t flush);\n"
        self._library: Library = build([*sources, ("driver.c", driver)], declared, toolchain, libraries=())

    @property
    def flushes(self) -> bool:
        """Whether this machine has a mode that flushes denormal numbers to zero."""
        return bool(self._library.lib.hysgen_driver_flushes())

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
        return int(self._library.lib.hysgen_driver_commit(instance, learner, int(flush)))

    def words_of(self, struct: Any) -> Words:
        """The 32-bit words of a struct, as a live view."""
        return np.frombuffer(self._library.ffi.buffer(struct), dtype=np.uint32)

    def layout(self, struct: str) -> dict[str, int]:
        """Word index of every scalar in a struct, by its C path: `y_um`, `inputs.creep.low[2]`, `bank[1].gain[0]`."""
        return {word.path: place for place, word in enumerate(self.interface.struct(struct).words())}

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
        step = getattr(self._library.lib, f"hysgen_driver_{function}")
        step(struct, n, pointers, ffi.from_buffer("uint32_t *", out), recorded, first, words, int(flush))
        return out, trace


def _driver_declaration(entry: Function) -> str:
    return (
        f"void hysgen_driver_{entry.name}({entry.state} *self, size_t n, const uint32_t *const in[], uint32_t *out,"
        " uint32_t *trace, size_t first, size_t words, int32_t flush);\n"
    )
