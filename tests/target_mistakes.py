"""Mistakes that are easy to make in an instruction: wrong operations, and actions turned wrong."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from typing import Any

from hysgen.target.semantics import FLOAT, INTEGER, FloatUnit, signed

RIGHT: Mapping[str, Callable[..., int]] = {**INTEGER, **FLOAT}


def without_flush(mnemonic: str) -> Callable[..., int]:
    """The operation on a unit that keeps denormals."""

    class Keeping(FloatUnit):
        def _flush(self, image: int) -> int:
            return image

    return lambda unit, *images: RIGHT[mnemonic](Keeping(), *images)


def like(other: str, *order: int) -> Callable[..., int]:
    """Another operation, its operands perhaps in another order."""

    def wrong(*images: object) -> int:
        unit = images[:1] if other in FLOAT else ()
        rest = images[len(unit) :]
        return RIGHT[other](*unit, *((rest[i] for i in order) if order else rest))

    return wrong


# For every operation the mistakes that are easy to make.
MISTAKES: Mapping[str, Mapping[str, Callable[..., int]]] = {
    "add": {"subtracts": like("sub")},
    "sub": {"operands swapped": like("sub", 1, 0)},
    "and": {"or": like("or")},
    "or": {"exclusive or": like("xor")},
    "xor": {"or": like("or")},
    "andn": {"inverts the first": like("andn", 1, 0), "and": like("and")},
    "abs": {"wraps at the most negative": lambda a: abs(signed(a)) & 0xFFFF_FFFF},
    "addab": {"scaled": like("addah")},
    "addah": {"not scaled": like("addab"), "scaled by 4": like("addaw")},
    "addaw": {"not scaled": like("addab"), "scaled by 8": like("addad")},
    "addad": {"scaled by 4": like("addaw")},
    "subab": {"adds": like("addab")},
    "subah": {"adds": like("addah"), "not scaled": like("subab")},
    "subaw": {"adds": like("addaw"), "scaled by 2": like("subah")},
    "shl": {
        "counts 5 bits": lambda a, b: a << (b & 31) & 0xFFFF_FFFF,
        "counts all bits": lambda a, b: (a << b) % 2**32,
    },
    "shr": {"fills with zeros": like("shru"), "counts 5 bits": lambda a, b: signed(a) >> (b & 31) & 0xFFFF_FFFF},
    "shru": {"fills with the sign": like("shr"), "counts 5 bits": lambda a, b: a >> (b & 31)},
    "rotl": {"shifts": like("shl"), "rotates right": lambda a, b: RIGHT["rotl"](a, 32 - b)},
    "ext": {"fills with zeros": like("extu"), "fields swapped": like("ext", 0, 2, 1)},
    "extu": {"fills with the sign": like("ext"), "fields swapped": like("extu", 0, 2, 1)},
    "set": {"clears": like("clr"), "fields swapped": like("set", 0, 2, 1)},
    "clr": {"sets": like("set"), "fields swapped": like("clr", 0, 2, 1)},
    "cmpeq": {"not equal": lambda a, b: int(a != b)},
    "cmpgt": {"unsigned": like("cmpgtu"), "or equal": lambda a, b: int(signed(a) >= signed(b))},
    "cmplt": {"unsigned": like("cmpltu"), "or equal": lambda a, b: int(signed(a) <= signed(b))},
    "cmpgtu": {"signed": like("cmpgt"), "or equal": lambda a, b: int(a >= b)},
    "cmpltu": {"signed": like("cmplt"), "or equal": lambda a, b: int(a <= b)},
    "lmbd": {"operands swapped": like("lmbd", 1, 0), "position from below": lambda b, a: 31 - RIGHT["lmbd"](b, a)},
    "mvk": {"no sign": lambda a: a & 0xFFFF},
    "mvkh": {"clears the lower half": lambda a, d: a & 0xFFFF_0000},
    "addk": {"moves": lambda a, d: a},
    "mpy": {"unsigned": like("mpyu")},
    "mpyu": {"signed": like("mpy"), "full words": lambda a, b: a * b & 0xFFFF_FFFF},
    "mpysu": {"signs swapped": like("mpyus")},
    "mpyus": {"signs swapped": like("mpysu")},
    "mpyh": {"low halves": like("mpy"), "unsigned": like("mpyhu")},
    "mpyhu": {"signed": like("mpyh")},
    "mpyhl": {"halves swapped": like("mpylh"), "unsigned": like("mpyhlu")},
    "mpylh": {"halves swapped": like("mpyhl"), "unsigned": like("mpylhu")},
    "mpyhlu": {"halves swapped": like("mpylhu"), "signed": like("mpyhl")},
    "mpylhu": {"halves swapped": like("mpyhlu"), "signed": like("mpylh")},
    "mpy32": {"low halves": like("mpyu")},
    "addsp": {"keeps denormals": without_flush("addsp"), "subtracts": like("subsp")},
    "subsp": {"keeps denormals": without_flush("subsp"), "operands swapped": like("subsp", 1, 0)},
    "mpysp": {"keeps denormals": without_flush("mpysp"), "adds": like("addsp")},
    "abssp": {
        "keeps denormals": without_flush("abssp"),
        "clears the sign of NaN only": lambda unit, a: a & 0x7FFF_FFFF,
    },
    "cmpeqsp": {"compares images": lambda unit, a, b: int(a == b), "keeps denormals": without_flush("cmpeqsp")},
    "cmpgtsp": {"operands swapped": like("cmpltsp"), "keeps denormals": without_flush("cmpgtsp")},
    "cmpltsp": {"operands swapped": like("cmpgtsp"), "keeps denormals": without_flush("cmpltsp")},
    "intsp": {"unsigned": like("intspu")},
    "intspu": {"signed": like("intsp")},
    "spint": {"truncates": like("sptrunc"), "ties away": lambda unit, a: math.floor(unit._read(a) + 0.5) & 0xFFFF_FFFF},
    "sptrunc": {"rounds": like("spint"), "toward minus infinity": lambda unit, a: math.floor(unit._read(a)) % 2**32},
}


def changed(**fields: object) -> Callable[[Any], Any]:
    """An action with other fields."""
    return lambda action: dataclasses.replace(action, **fields)


def sized(by: float) -> Callable[[Any], Any]:
    return lambda action: dataclasses.replace(action, size=int(action.size * by))


def aligned(by: float) -> Callable[[Any], Any]:
    return lambda action: dataclasses.replace(action, alignment=int(action.alignment * by))


def other_sign(action: Any) -> Any:
    return dataclasses.replace(action, signed=not action.signed)


def elsewhere(action: Any) -> Any:
    """A branch or a call that goes one packet too far; a return goes where it should."""
    return dataclasses.replace(action, target=action.target + 4) if isinstance(action.target, int) else action


def in_bytes(action: Any) -> Any:
    return dataclasses.replace(action, memory=dataclasses.replace(action.memory, scaled=False))


def waits(cycles: int) -> Callable[[Any], Any]:
    return lambda action: dataclasses.replace(action, idle=action.idle + cycles)


_HALF, _TWICE = {"half the bytes": sized(0.5)}, {"twice the bytes": sized(2)}
_SIGN, _STRICT, _LOOSE = {"other sign": other_sign}, {"strict": aligned(2)}, {"loose": aligned(0.5)}
_ELEMENTS = {"elements taken for bytes": in_bytes}

# The same for what loads, stores and steers: the action that an instruction is decoded to, turned wrong.
WRONG_ACTIONS: Mapping[str, Mapping[str, Callable[[Any], Any]]] = {
    "ldb": _SIGN | _TWICE | _STRICT,
    "ldbu": _SIGN | _TWICE | _STRICT,
    "ldh": _SIGN | _HALF | _TWICE | _STRICT | _LOOSE,
    "ldhu": _SIGN | _HALF | _TWICE | _STRICT | _LOOSE,
    "ldw": _HALF | _STRICT | _LOOSE,
    "ldnw": _HALF | _STRICT,
    "lddw": _HALF | _STRICT | _LOOSE,
    "ldndw": _HALF | _STRICT | _ELEMENTS,
    "stb": _TWICE | _STRICT,
    "sth": _HALF | _TWICE | _STRICT | _LOOSE,
    "stw": _HALF | _STRICT | _LOOSE,
    "stnw": _HALF | _STRICT,
    "stdw": _HALF | _STRICT | _LOOSE,
    "stndw": _HALF | _STRICT | _ELEMENTS,
    "b": {"a packet too far": elsewhere, "waits": waits(5)},
    "bnop": {"a packet too far": elsewhere, "does not wait": waits(-5)},
    "callp": {"a packet too far": elsewhere, "no way back": changed(link=None), "waits a cycle less": waits(-1)},
    "addkpc": {
        "a packet too far": lambda action: dataclasses.replace(action, address=action.address + 4),
        "waits a cycle less": waits(-1),
        "waits a cycle more": waits(1),
    },
    "nop": {
        "a cycle more": lambda action: dataclasses.replace(action, cycles=action.cycles + 1),
        "a cycle less": lambda action: dataclasses.replace(action, cycles=action.cycles - 1),
    },
}
