"""Random C functions that give the same on every machine with IEEE floats: wrapping integers, tame floats, no traps."""

from __future__ import annotations

import random

_PRELUDE = """#include <stdint.h>
typedef union { float value; uint32_t bits; } image_t;
static uint32_t bits_of(float value) { image_t image; image.value = value; return image.bits; }
"""
_ARGUMENTS = "(uint32_t a, uint32_t b, float x, float y)"


def random_program(seed: int, functions: int) -> tuple[str, list[str], str]:
    """C text, the names of its functions, and their declarations. Same seed, same text."""
    draw = random.Random(seed)
    names = [f"f{i}" for i in range(functions)]
    declarations = "\n".join(f"uint32_t {name}{_ARGUMENTS};" for name in names)
    bodies = [_function(name, draw) for name in names]
    return "\n".join([_PRELUDE, declarations, *bodies]), names, declarations


def _function(name: str, draw: random.Random) -> str:
    lines = [
        f"uint32_t {name}{_ARGUMENTS}",
        "{",
        "    uint32_t t[8] = {a, b, 1u, 77u, a ^ b, 5u, 0u, 9u};",
        "    uint32_t i;",
    ]
    for _ in range(draw.randint(4, 12)):
        lines.append("    " + _statement(draw))
    lines.append(f"    for (i = 0; i < {draw.randint(2, 8)}u; i++) {{")
    for _ in range(draw.randint(1, 3)):
        lines.append("        " + _statement(draw))
    lines += ["        t[i] = t[i] + a;", "    }"]
    for _ in range(draw.randint(1, 4)):
        lines.append("    " + _statement(draw))
    mixed = " ^ ".join(f"t[{i}] * {2 * i + 3}u" for i in range(8))
    return "\n".join([*lines, f"    return a ^ (b << 1) ^ bits_of(x) ^ (bits_of(y) >> 3) ^ {mixed};", "}"])


def _statement(draw: random.Random) -> str:
    target = draw.choice(["a", "b", f"t[{draw.randrange(8)}]", "t[a & 7u]"])
    kind = draw.random()
    if kind < 0.4:
        return f"{target} = {_integer(draw, 3)};"
    if kind < 0.7:
        # Weighted means keep floats within their first magnitude: no overflow, no denormals.
        first, second = draw.sample(["x", "y", "0.75f", f"(float)(int32_t)({_integer(draw, 1)} & 1023u)"], 2)
        weight = draw.choice(["0.5f", "0.25f", "0.3f", "0.8f"])
        return f"{draw.choice('xy')} = {first} * {weight} {draw.choice('+-')} {second} * (1.0f - {weight});"
    if kind < 0.85:
        return (
            f"if ({_condition(draw)}) {target} = {_integer(draw, 2)}; else {draw.choice('xy')} = x * 0.5f + y * 0.5f;"
        )
    return f"{target} = (uint32_t)(int32_t)(x * {draw.choice(['3.0f', '100.0f'])}) + {_integer(draw, 1)};"


def _integer(draw: random.Random, depth: int) -> str:
    if depth == 0 or draw.random() < 0.2:
        return draw.choice(
            ["a", "b", "t[1]", "t[3]", "t[b & 7u]", f"{draw.randrange(2**16)}u", f"{draw.randrange(2**32)}u"]
        )
    left, right = _integer(draw, depth - 1), _integer(draw, depth - 1)
    shift = draw.choice([f"{draw.randrange(32)}", f"({right} & 31u)"])
    return draw.choice(
        [
            f"({left} {draw.choice('+-*&|^')} {right})",
            f"({left} {draw.choice(['<<', '>>'])} {shift})",
            f"(uint32_t)((int32_t){left} >> {shift})",
            f"(uint32_t)(int32_t)(int16_t){left}",
            f"(uint32_t)(uint8_t)({left} >> {draw.randrange(25)})",
            f"(uint32_t)({left} {draw.choice(['<', '>', '==', '<='])} {right})",
            f"(uint32_t)((int32_t){left} {draw.choice(['<', '>'])} (int32_t){right})",
            f"(uint32_t)((int32_t)(int16_t){left} * (int32_t)(int16_t){right})",
            f"((uint32_t)(uint16_t){left} * (uint32_t)(uint16_t){right})",
            f"(~{left} & {right})",
            f"(({left} >> 3) & 0x1FFFu)",
        ]
    )


def _condition(draw: random.Random) -> str:
    return draw.choice(
        [
            f"{_integer(draw, 1)} {draw.choice(['<', '>', '==', '!='])} {_integer(draw, 1)}",
            f"x {draw.choice(['<', '>', '<=', '>=', '=='])} y",
            f"(int32_t){_integer(draw, 1)} {draw.choice(['<', '>='])} {draw.randrange(100)}",
        ]
    )
