"""The update of tests/target/learn.c in other shapes, same operations in the same order: which shape suits the C674x.

`python tests/target_learn_shapes.py` prints cycles and code bytes of each, for several compiler flags.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from hysgen.target import toolchain

SOURCE = (Path(__file__).parent / "target" / "learn.c").read_text(encoding="utf-8")
N = 18
BLOCK = 6
# gcc's first scheduling pass and its expression forwarding undo an order that is written down on purpose.
AS_WRITTEN = '__attribute__((optimize("no-schedule-insns", "no-tree-ter")))'
PHASE = '__asm__ volatile("" ::: "memory");'
FLAGS = {"FLAGS": (), "-fno-sched-pressure": ("-fno-sched-pressure",), "and -O3": ("-O3", "-fno-sched-pressure")}


def place(i: int, j: int) -> str:
    """Element of U above the diagonal."""
    return f"self->u[{j * (j - 1) // 2 + i}]"


def blocks(count: int) -> Iterator[range]:
    for first in range(0, count, BLOCK):
        yield range(first, min(count, first + BLOCK))


def function(body: list[str], attribute: str = "") -> str:
    """learn.c with another body of `learn`."""
    head, _, _ = SOURCE.partition("void learn(learner_t *self, const float *phi, float error)\n{")
    signature = "void learn(learner_t *self, const float *phi, float error)"
    return "\n".join([head, attribute, signature, "{", *(f"    {line}" for line in body), "}", ""])


def loops() -> str:
    return SOURCE


def unrolled_by_the_compiler() -> str:
    return SOURCE.replace("    for (", f'    _Pragma("GCC unroll {N}") for (')


def in_loop_order() -> str:
    """Every pass of every loop written out, one after the other."""
    body = []
    for j in range(N):
        body.append(f"float f{j} = phi[{j}];")
        body += [f"f{j} = f{j} + {place(i, j)} * phi[{i}];" for i in range(j)]
        body.append(f"float g{j} = self->d[{j}] * f{j};")
    body.append("float a = FORGETTING, r = FORGETTING_INVERSE, x;")
    for j in range(N):
        body.append(f"float n{j} = a + f{j} * g{j}, m{j} = reciprocal(n{j}), s{j} = -f{j} * r;")
        body.append(f"self->d[{j}] = self->d[{j}] * (a * m{j}) * FORGETTING_INVERSE;")
        for i in range(j):
            body.append(f"x = {place(i, j)}; {place(i, j)} = x + k{i} * s{j}; k{i} = k{i} + g{j} * x;")
        body.append(f"float k{j} = g{j}; a = n{j}; r = m{j};")
    body += [f"self->theta[{i}] = self->theta[{i}] + k{i} * (error * r);" for i in range(N)]
    return function(body)


def in_blocks(attribute: str = "") -> str:
    """Six independent elements side by side: their loads, their products, their sums; the phases kept apart."""
    body = [f"float f[{N}], g[{N}], a[{N + 1}], r[{N + 1}], s[{N}];"]
    for columns in blocks(N):
        body.append("{")
        body += [f"float f{j} = phi[{j}];" for j in columns]
        for i in range(columns[-1]):
            right = [j for j in columns if j > i]
            body.append(f"{{ const float p = phi[{i}]; {' '.join(f'float x{j} = {place(i, j)};' for j in right)}")
            body.append(" ".join(f"x{j} = x{j} * p;" for j in right))
            body.append(" ".join(f"f{j} = f{j} + x{j};" for j in right) + " }")
        body += [f"f[{j}] = f{j}; g[{j}] = self->d[{j}] * f{j};" for j in columns]
        body.append("}")
    body += [PHASE, "a[0] = FORGETTING; r[0] = FORGETTING_INVERSE;"]
    for columns in blocks(N):
        body += ["{", f"float a{columns[0]} = a[{columns[0]}];", "image_t w;"]
        body += [f"float p{j} = f[{j}] * g[{j}];" for j in columns]
        body += [f"float a{j + 1} = a{j} + p{j};" for j in columns]
        body += [f"w.value = a{j + 1}; w.bits = 0x7EF311C7u - w.bits; float r{j} = w.value;" for j in columns]
        for _ in range(3):
            body += [f"p{j} = a{j + 1} * r{j};" for j in columns]
            body += [f"p{j} = 2.0f - p{j};" for j in columns]
            body += [f"r{j} = r{j} * p{j};" for j in columns]
        body += [f"a[{j + 1}] = a{j + 1}; r[{j + 1}] = r{j}; s[{j}] = -f[{j}] * r[{j}];" for j in columns]
        body += [f"p{j} = a[{j}] * r{j};" for j in columns]
        body += [f"p{j} = self->d[{j}] * p{j};" for j in columns]
        body += [f"self->d[{j}] = p{j} * FORGETTING_INVERSE;" for j in columns]
        body.append("}")
    body.append(PHASE)
    for j in range(N):
        body += [f"float k{j} = g[{j}];", f"{{ const float l = s[{j}], h = k{j};"]
        for rows in blocks(j):
            body.append("{ " + " ".join(f"float x{i} = {place(i, j)};" for i in rows))
            body.append(" ".join(f"float p{i} = k{i} * l;" for i in rows))
            body.append(" ".join(f"float q{i} = h * x{i};" for i in rows))
            body.append(" ".join(f"p{i} = x{i} + p{i};" for i in rows))
            body.append(" ".join(f"k{i} = k{i} + q{i};" for i in rows))
            body.append(" ".join(f"{place(i, j)} = p{i};" for i in rows) + " }")
        body.append("}")
    body += [PHASE, f"const float step = error * r[{N}];"]
    body += [f"self->theta[{i}] = self->theta[{i}] + k{i} * step;" for i in range(N)]
    return function(body, attribute)


SHAPES: dict[str, Callable[[], str]] = {
    "loops of constant length": loops,
    "the same, unrolled by pragma": unrolled_by_the_compiler,
    "written out in loop order": in_loop_order,
    "written out in blocks of six": in_blocks,
    "blocks of six, scheduled as written": lambda: in_blocks(AS_WRITTEN),
}


def measured(text: str, flags: tuple[str, ...] = ()) -> tuple[int, int, bytes]:
    """Cycles of one update, code bytes, and the state after three updates."""
    firmware = toolchain.compile([("learn.c", text)], ("-Wno-unused", *flags))
    machine = firmware.machine()
    words = 2 * N + N * (N - 1) // 2
    self, phi = machine.allocate(words), machine.allocate(N)
    machine.write(self, np.concatenate([np.zeros(N), np.full(N, 100.0), np.zeros(words - 2 * N)]).astype(np.float32))
    for k in range(3):
        machine.write(phi, np.cos(np.arange(N) * (k + 1)).astype(np.float32))
        outcome = machine.call("learn", self, phi, 0.5)
    return outcome.cycles, firmware.section_bytes[".text"], machine.read(self, words).tobytes()


def main() -> None:
    print(f"{N} parameters{'':32}" + "".join(f"{flags:>24}" for flags in FLAGS))
    for name, text in SHAPES.items():
        results = [measured(text(), flags) for flags in FLAGS.values()]
        print(f"{name:45}" + "".join(f"{cycles:8} cycles {code:6} B" for cycles, code, _ in results))


if __name__ == "__main__":
    main()
