"""Scheduled kernels leave the words of their C for every input: their packets, executed with symbols for numbers.

The packets are those of the linked program. What a register or a word of memory holds is an operation of the graph in
which the C was executed, and the words that both leave are compared as those of C and reference are: equal operations
of equal operands, or equal by a solver. `checker.Execution` shows beside that no register is read or written while
a result for it is on its way, so that one order of the results counts. Together with the proof of the C, a kernel has
the bits of the reference. Assumed are indices inside their arrays, as there, and pointers to objects that are apart.
"""

import importlib.util
import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.proof.translation import PREFIX, FunctionProof, Translation, state_ranges
from hysgen.checking.symbolic.dataflow import Graph, Op
from hysgen.checking.symbolic.equivalence import SAMPLES, Sweep
from hysgen.checking.symbolic.from_c import Outcome, element, outcome, replaced
from hysgen.checking.symbolic.memory import WORD, Place, size_of
from hysgen.checking.symbolic.semantics import MASK
from hysgen.checking.symbolic.solver import SOLVER
from hysgen.checking.symbolic.source import KernelRefusalError, Source
from hysgen.codegen.manifest import MANIFEST
from hysgen.codegen.operations.text import Array, Pointer
from hysgen.codegen.structs import interface_of
from hysgen.errors import BuildError
from hysgen.model.model import Model
from hysgen.model.structs import Word
from hysgen_c674x import toolchain
from hysgen_c674x.cycles import c_texts
from hysgen_c674x.decode import Access
from hysgen_c674x.elf import ProgramImage
from hysgen_c674x.schedule.checker import Execution, function_packets

_RESULT: Final = 4
_SCALED: Final[Mapping[str, int]] = {"addk": 1, "addab": 1, "addah": 2, "addaw": 4, "addad": 8}


def kernel_proofs(model: Model, texts: Mapping[str, str], only: Sequence[str] = ()) -> Translation:
    """The proofs of all kernels of a folder, or of `only` these. Without the compiler none of them is proved."""
    made = json.loads(texts[MANIFEST]).get("kernels", {}).get("cycles", {})
    chosen = [function for function in made if function in (only or made)]
    try:
        program = toolchain.compile(c_texts(texts))
    except BuildError as missing:
        return Translation(model.name, True, tuple(FunctionProof(name, refused=str(missing)) for name in chosen))
    structs = {
        struct.name: list(struct.words(PREFIX.get(struct.name.removeprefix(f"{model.name}_"), "")))
        for struct in interface_of(model.name, texts).structs
    }
    words = _Words(structs, state_ranges(model, "learn" if model.learner else "predict"))
    proofs = tuple(_proof(Source(model.name, texts), words, program, function) for function in chosen)
    return Translation(model.name, importlib.util.find_spec(SOLVER) is not None, proofs)


def _proof(source: Source, known: "_Words", program: toolchain.Firmware, function: str) -> FunctionProof:
    """The proof of one kernel, named without the model's prefix."""
    begun, graph, name = time.monotonic(), Graph(), f"{source.name}_{function}"
    packets = function_packets(program.image, program.packets, name)
    parameters = source.functions[name].decl.type.args.params
    given: dict[str, Op | list[Op]] = {}
    for place, parameter in enumerate(parameters):
        paths = known.behind(source, parameter)
        given[parameter.name] = [graph.symbol(path) for path in paths] or graph.param(place)
    try:
        in_c = outcome(source, graph, name, list(given.values()))
        run = _Run(graph, given, in_c=in_c, source=source, image=program.image)
        broken = run.run(packets)
        if broken:
            return FunctionProof(function, refused=str(broken[0]))
        before = {name: words for name, words in given.items() if isinstance(words, list)}
        pairs = [
            (word.name, run.memory[parameter, WORD * k], in_c.structs[parameter][k])
            for parameter, words in before.items()
            for k, word in enumerate(words)
        ]
        if in_c.result is not None:
            pairs.append(("result", run.registers[_RESULT], in_c.result))
        sweep = Sweep(known.drawn)
        made = sweep.pairs([pair[:0:-1] for pair in pairs])
    except KernelRefusalError as refusal:
        return FunctionProof(function, seconds=time.monotonic() - begun, refused=str(refusal))
    unequal = {path: pair for (path, _, _), pair in zip(pairs, made, strict=True) if pair[0] is not pair[1]}
    difference = ""
    for path, pair in unequal.items():
        wrong = np.flatnonzero(np.not_equal(*map(sweep.values, pair)))
        if wrong.size and not difference:
            c, kernel = (f"{int(sweep.values(op)[wrong[0]]):#010x}" for op in pair)
            drawn = [f"{int(known.drawn(op)[wrong[0]]):#010x}" for op in given.values() if isinstance(op, Op)]
            difference = f"{path}: {kernel} in the kernel, {c} in C, for arguments {', '.join(drawn)}"
    solved = sweep.decided.total(), time.monotonic() - begun, difference, "", 1, dict(sweep.decided), sweep.solver_s
    return FunctionProof(function, len(pairs), tuple(unequal), *solved)


@dataclass(frozen=True)
class _Words:
    """What is known of the words of the structs: by the name of the struct, and their ranges by path."""

    structs: Mapping[str, Sequence[Word]]
    ranges: Mapping[str, tuple[float, float]]

    def behind(self, source: Source, parameter: Any) -> list[str]:
        """Names of the words behind a pointer; none of an argument that is a word."""
        kind = source.types.of(parameter.type)
        if not isinstance(kind, Pointer | Array):
            return []
        names = getattr(getattr(parameter.type.type, "type", None), "names", [""])
        if names[0] in self.structs:
            return [word.path for word in self.structs[names[0]]]
        words = size_of(kind.to if isinstance(kind, Pointer) else kind) // WORD
        return [f"{parameter.name}[{k}]" for k in range(words)]

    def drawn(self, op: Op) -> NDArray[np.uint32]:
        """Samples of an argument or a word: in its range; without one, any bits and numbers of moderate size."""
        rng = np.random.default_rng(list((op.name or f"argument {op.number}").encode()))
        if any(word.path == op.name and word.type != "float" for words in self.structs.values() for word in words):
            least, most = self.ranges.get(op.name, (0, MASK))
            return rng.integers(int(least), int(most), SAMPLES, dtype=np.uint32, endpoint=True)
        floats = rng.uniform(*self.ranges.get(op.name, (-2.0, 2.0)), SAMPLES).astype(np.float32).view(np.uint32)
        any_bits = rng.integers(0, 1 << 32, SAMPLES, dtype=np.uint32)
        return floats if op.name in self.ranges else np.where(np.arange(SAMPLES) % 2, floats, any_bits)


@dataclass(kw_only=True)
class _Run(Execution):
    """The execution of a kernel in the words and tables of its C."""

    in_c: Outcome
    source: Source
    image: ProgramImage

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, (_, words) in self.source.tables.items():
            self.memory |= {(name, WORD * k): self.graph.const(word) for k, word in enumerate(words)}

    def _untraced(self, text: str) -> Op:
        raise KernelRefusalError(text)

    def _place(self, action: Access, word: int) -> tuple[str, int, Op | None]:
        name, number, rest = super()._place(action, word)
        return (name, number, rest) if name else (*self._table(number, bool(rest)), rest)

    def _table(self, address: int, indexed: bool) -> tuple[str, int]:
        """Object and byte offset of a constant address: the table whose words are there, if it is indexed."""
        if not indexed:
            self.memory["", address] = self.graph.const(self._stored(address))
            return "", address
        for (name, offset), array in self.in_c.arrays.items():
            if name in self.source.tables:
                words = self.source.tables[name][1][array.low // WORD : array.high // WORD]
                start = address - offset + array.low
                if [self._stored(start + WORD * k) for k in range(len(words))] == list(words):
                    return name, offset
        raise KernelRefusalError(f"{address:#x}: no table of the C is there")

    def _stored(self, address: int) -> int:
        """The word of the linked program at an address."""
        for section in self.image.sections:
            start = address - section.address
            if not section.writable and 0 <= start <= len(section.content) - WORD:
                return int.from_bytes(section.content[start : start + WORD], "little")
        raise KernelRefusalError(f"{address:#x}: no constant is there")

    def _read(self, name: str, offset: int, distance: Op | None) -> Op:
        if distance is None:
            return self.memory.setdefault((name, offset), self.graph.symbol(f"unknown {name}{offset:+}"))
        array = self._array(name, offset)
        words = [self.memory[name, at] for at in range(array.low, array.high, WORD)]
        return element(self.graph, words, distance, offset - array.low)

    def _store(self, name: str, offset: int, distance: Op | None, chosen: Callable[[Op], Op]) -> None:
        if not name:
            raise KernelRefusalError(f"{offset:#x}: a store to a constant address")
        if distance is None:
            super()._store(name, offset, None, chosen)
            return
        array = self._array(name, offset)
        places = [(name, at) for at in range(array.low, array.high, WORD)]
        words = [self.memory[place] for place in places]
        shift = offset - array.low
        value = chosen(element(self.graph, words, distance, shift))
        self.memory |= zip(places, replaced(self.graph, words, distance, value, shift, array.stride), strict=True)

    def _array(self, name: str, offset: int) -> Place:
        """The array of the C that has an element at an index that depends on data there."""
        if (name, offset) not in self.in_c.arrays:
            raise KernelRefusalError(f"{name}{offset:+}: no array of the C is indexed there")
        return self.in_c.arrays[name, offset]
