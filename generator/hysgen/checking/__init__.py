"""Generated C on this machine: its builds, a driver that runs a function over arrays, and the inverse on arrays."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hysgen.certify.certificates import certify
from hysgen.codegen import Options, generate
from hysgen.codegen.manifest import c_files
from hysgen.codegen.render import render
from hysgen.codegen.structs import Function, interface_of
from hysgen.errors import BuildError, CertificateError, ModelError
from hysgen.machine.kernel_build import compiler_call
from hysgen.machine.native import INSTALL, Library, Toolchain, build, compiler_version
from hysgen.machine.processes import in_threads
from hysgen.model.model import Model
from hysgen.model.simulate import series
from hysgen.trajectory.inverse import rest_voltage

Words = NDArray[np.uint32]


class Driven:
    """A model's generated C, whose functions a driver calls.

    entries: the functions that step a struct by one sample, by name; channels: auxiliary channels that the model
    listens to; selftested: there is a self-test among the texts; commits: there is a `<name>_commit`. facts: variables
    of the driver's template.
    """

    def __init__(self, name: str, texts: Mapping[str, str]) -> None:
        self.name, self.interface = name, interface_of(name, texts)
        self.entries = {function.name: function for function in self.interface.functions if function.floats}
        self.channels = self.interface.channels
        self.selftested, self.commits = f"{name}_selftest.c" in texts, self.interface.has("commit")
        self.facts = {
            "name": name,
            "structs": self.interface.structs,
            "entries": list(self.entries.values()),
            "channels": self.channels,
            "commits": self.commits,
            "selftested": self.selftested,
            "learns": self.interface.has("learn_init"),
        }

    def layout(self, struct: str) -> dict[str, int]:
        """Word index of every scalar in a struct, by its C path: `y_um`, `inputs.creep.low[2]`, `bank[1].gain[0]`."""
        return {word.path: place for place, word in enumerate(self.interface.struct(struct).words())}


class Host(Driven):
    """A model's generated C, compiled by one toolchain.

    texts: file name -> text, as `generate` returns them. declarations: C prototypes of functions that the texts define
    beside the interface. Raises BuildError if the compiler refuses the texts.
    """

    def __init__(
        self, name: str, texts: Mapping[str, str], toolchain: Toolchain | None = None, *, declarations: str = ""
    ) -> None:
        super().__init__(name, texts)
        driver = render("driver.c.j2", self.facts)
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


LEVELS: Final = ("-O0", "-O2", "-O3")


@dataclass(frozen=True)
class Build:
    """Generated C compiled by one toolchain, run with or without flushing denormal numbers to zero."""

    toolchain: Toolchain
    flush: bool
    host: Host

    def __str__(self) -> str:
        return f"{self.toolchain}{', flush to zero' if self.flush else ''}"


def host_compilers() -> tuple[str, ...]:
    """gcc and clang; where neither is installed the compiler of this machine, too."""
    known = ("gcc", "clang")
    return known if any(map(compiler_call, known)) else (*known, "cc")


def toolchains(compilers: Sequence[str], levels: Sequence[str]) -> tuple[list[Toolchain], list[str]]:
    """Every level of every installed compiler, and one line for each compiler that is not installed.

    levels: compiler flags; one string may hold several flags. Raises BuildError if no compiler is installed.
    """
    installed = [compiler for compiler in compilers if compiler_call(compiler)]
    missing = [f"{name}: not installed, nothing was compared with it" for name in compilers if name not in installed]
    if not installed:
        raise BuildError(f"none of {', '.join(compilers)} is installed; {INSTALL}")
    return [Toolchain(compiler, tuple(level.split())) for compiler in installed for level in levels], missing


def compiled(name: str, texts: Mapping[str, str], chain: Sequence[Toolchain]) -> tuple[list[Build], list[str]]:
    """Every build of the texts, and one line if this machine cannot flush denormal numbers.

    Raises BuildError if a compiler rejects the generated C.
    """
    # The compilers run as processes of their own.
    hosts = list(zip(chain, in_threads(lambda toolchain: Host(name, texts, toolchain), chain), strict=True))
    flushes = all(host.flushes for _, host in hosts)
    modes = (False, True) if flushes else (False,)
    skipped = [] if flushes else ["flush to zero: hysgen knows no control for it on this machine"]
    return [Build(toolchain, flush, host) for toolchain, host in hosts for flush in modes], skipped


def versions(chain: Sequence[Toolchain]) -> list[str]:
    """One line per compiler: its version and its levels."""
    commands = dict.fromkeys(toolchain.command for toolchain in chain)
    return [
        f"{compiler_version(command)} ({', '.join(' '.join(t.flags) for t in chain if t.command == command)})"
        for command in commands
    ]


Floats = NDArray[np.float64]


def inverse(model: Model, reference_um: ArrayLike, y_um: ArrayLike | None = None) -> Floats:
    """Voltage in V, (n - 1,), that takes y(k) to reference(k + 1): Eq. (11) in float32, in the generated C.

    reference_um: (n,) wanted displacement. y_um: (n,) measured displacement; by default the reference itself, which is
    feed-forward. Raises CertificateError for a model without a certified inverse, BuildError without a compiler.
    """
    wanted = series(reference_um, "reference_um")
    measured = wanted if y_um is None else series(y_um, "y_um", wanted.size)
    if not certify(model).inverse_holds:
        raise CertificateError(f"{model.name}: the inverse is not certified; `hysgen describe` says why")
    host = Host(model.name, generate(model, Options(inverse=True)))
    if host.channels:
        raise ModelError(f"{model.name}: its inverse needs the channels {host.channels}; use the C instead")
    instance = host.instance(float(measured[0]), rest_voltage(model, float(measured[0])))
    words = [np.ascontiguousarray(part, dtype=np.float32).view(np.uint32) for part in (measured[:-1], wanted[1:])]
    return host.run("inverse", instance, words)[0].view(np.float32).astype(np.float64)
