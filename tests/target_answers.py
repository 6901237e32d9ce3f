"""Known answers: for every modelled operation, operands and results worked out by hand from TI's description (SPRUFE8).

Sources are in printed order; `bits(x)` is the single-precision image of x. Constants of instructions that only take
constants stand where the register operands do. Each row is there to tell the operation from a likely mistake.
"""

from __future__ import annotations

from dataclasses import dataclass

from target_packets import bits

INF, NAN, NAN_OUT = 0x7F80_0000, 0x7FC0_0001, 0x7FFF_FFFF
TINY, LARGEST = 0x0080_0000, 0x7F7F_FFFF  # smallest normal, largest finite
DENORMAL, MINUS_DENORMAL, MINUS_ZERO = 0x007F_FFFF, 0x8000_0001, 0x8000_0000

ANSWERS: dict[str, list[tuple[tuple[int, ...], int]]] = {
    "add": [((5, 3), 8), ((0xFFFF_FFFF, 2), 1)],
    "sub": [((5, 3), 2), ((3, 5), 0xFFFF_FFFE)],
    "and": [((0b1100, 0b1010), 0b1000)],
    "or": [((0b1100, 0b1010), 0b1110)],
    "xor": [((0b1100, 0b1010), 0b0110)],
    "andn": [((0b1100, 0b1010), 0b0100)],
    "abs": [((5,), 5), ((0xFFFF_FFFB,), 5), ((0x8000_0000,), 0x7FFF_FFFF)],
    "addab": [((100, 3), 103)],
    "addah": [((100, 3), 106)],
    "addaw": [((100, 3), 112)],
    "addad": [((100, 3), 124)],
    "subab": [((100, 3), 97)],
    "subah": [((100, 3), 94)],
    "subaw": [((100, 3), 88)],
    "shl": [((0x8000_0001, 1), 2), ((1, 31), 0x8000_0000), ((1, 32), 0), ((1, 64), 1)],
    "shr": [((0x8000_0000, 4), 0xF800_0000), ((0x4000_0000, 4), 0x0400_0000), ((0x8000_0000, 40), 0xFFFF_FFFF)],
    "shru": [((0x8000_0000, 4), 0x0800_0000), ((0x8000_0000, 32), 0), ((0x8000_0000, 64), 0x8000_0000)],
    "rotl": [((0x8000_0001, 4), 0x0000_0018), ((0x1234_5678, 0), 0x1234_5678)],
    "ext": [((0x0000_0F80, 20, 24), 0xFFFF_FFF8), ((0x0000_0780, 20, 24), 0x0000_0078)],
    "extu": [((0x0000_0F80, 20, 24), 0x0000_00F8)],
    "set": [((0, 4, 7), 0xF0), ((1, 31, 31), 0x8000_0001), ((1, 7, 4), 1)],
    "clr": [((0xFFFF_FFFF, 4, 7), 0xFFFF_FF0F), ((0xFFFF_FFFF, 0, 31), 0), ((0xFF, 7, 4), 0xFF)],
    "cmpeq": [((7, 7), 1), ((7, 8), 0)],
    "cmpgt": [((1, 0xFFFF_FFFF), 1), ((0xFFFF_FFFF, 1), 0), ((1, 1), 0)],
    "cmplt": [((1, 0xFFFF_FFFF), 0), ((0xFFFF_FFFF, 1), 1), ((1, 1), 0)],
    "cmpgtu": [((1, 0xFFFF_FFFF), 0), ((0xFFFF_FFFF, 1), 1), ((1, 1), 0)],
    "cmpltu": [((1, 0xFFFF_FFFF), 1), ((0xFFFF_FFFF, 1), 0), ((1, 1), 0)],
    "lmbd": [((1, 0x009E_3A81), 8), ((0, 0x009E_3A81), 0), ((0, 0xFFFF_FFFF), 32), ((1, 0), 32), ((0, 0xF000_0000), 4)],
    "mvk": [((0xFFFF_FFF6,), 0xFFFF_FFF6)],
    "mvkh": [((0x1234_0000, 0xAAAA_5678), 0x1234_5678)],
    "addk": [((0xFFFF_FFFF, 10), 9)],
    "mpy": [((0x0001_FFFF, 0x0001_0002), 0xFFFF_FFFE), ((0x8000, 0x8000), 0x4000_0000)],
    "mpyu": [((0x0001_FFFF, 0x0001_FFFF), 0xFFFE_0001)],
    "mpysu": [((0xFFFF, 0xFFFF), 0xFFFF_0001), ((2, 0xFFFF), 0x1_FFFE)],
    "mpyus": [((0xFFFF, 0xFFFF), 0xFFFF_0001), ((0xFFFF, 2), 0x1_FFFE)],
    "mpyh": [((0xFFFF_0007, 0x0002_0009), 0xFFFF_FFFE)],
    "mpyhu": [((0xFFFF_0007, 0x0002_0009), 0x0001_FFFE)],
    "mpyhl": [((0xFFFF_0007, 0x0002_0009), 0xFFFF_FFF7)],
    "mpylh": [((0x0002_FFFF, 0x0003_0009), 0xFFFF_FFFD)],
    "mpyhlu": [((0xFFFF_0007, 0x0002_0009), 0x0008_FFF7)],
    "mpylhu": [((0x0002_FFFF, 0x0003_0009), 0x0002_FFFD)],
    "mpy32": [((0x0001_0001, 0x0001_0001), 0x0002_0001), ((0xFFFF_FFFF, 3), 0xFFFF_FFFD)],
    "addsp": [
        ((bits(1.5), bits(-0.25)), bits(1.25)),
        ((bits(1.0), bits(2.0**-24)), bits(1.0)),  # a tie, to even
        ((bits(1.0), bits(2.0**-24 + 2.0**-30)), 0x3F80_0001),  # just above the tie
        ((bits(1.0), bits(-1.0)), 0),
        ((TINY, DENORMAL), TINY),  # a denormal operand counts as zero
        ((0x0080_0001, 0x8080_0000), 0),  # a denormal result becomes zero
        ((0x8080_0001, TINY), MINUS_ZERO),  # of its sign
        ((MINUS_DENORMAL, MINUS_DENORMAL), MINUS_ZERO),
        ((LARGEST, LARGEST), INF),
        ((INF, 0xFF80_0000), NAN_OUT),
        ((NAN, bits(1.0)), NAN_OUT),
    ],
    "subsp": [
        ((bits(1.5), bits(0.25)), bits(1.25)),
        ((bits(0.25), bits(1.5)), bits(-1.25)),
        ((bits(1.0), bits(1.0)), 0),
        ((TINY, DENORMAL), TINY),
        ((0x0080_0001, TINY), 0),
        ((TINY, 0x0080_0001), MINUS_ZERO),
        ((0xFF7F_FFFF, LARGEST), 0xFF80_0000),
        ((INF, INF), NAN_OUT),
    ],
    "mpysp": [
        ((bits(1.5), bits(-0.5)), bits(-0.75)),
        ((0x3F80_0001, 0x3F80_0001), 0x3F80_0002),  # (1 + e)^2 = 1 + 2 e + e^2, rounded down
        ((TINY, bits(0.5)), 0),
        ((TINY, bits(-0.5)), MINUS_ZERO),
        ((DENORMAL, bits(2.0**30)), 0),
        ((MINUS_DENORMAL, bits(2.0**30)), MINUS_ZERO),
        ((LARGEST, bits(2.0)), INF),
        ((INF, DENORMAL), NAN_OUT),  # infinity times zero
    ],
    "abssp": [
        ((bits(-2.5),), bits(2.5)),
        ((bits(2.5),), bits(2.5)),
        ((MINUS_DENORMAL,), 0),
        ((0xFF80_0000,), INF),
        ((NAN,), NAN_OUT),
    ],
    "cmpeqsp": [
        ((bits(1.0), bits(1.0)), 1),
        ((bits(1.0), bits(2.0)), 0),
        ((0, MINUS_ZERO), 1),
        ((DENORMAL, MINUS_DENORMAL), 1),
        ((NAN, NAN), 0),
    ],
    "cmpgtsp": [
        ((bits(2.0), bits(1.0)), 1),
        ((bits(-2.0), bits(-1.0)), 0),
        ((bits(1.0), bits(1.0)), 0),
        ((DENORMAL, 0), 0),
        ((NAN, bits(1.0)), 0),
    ],
    "cmpltsp": [
        ((bits(1.0), bits(2.0)), 1),
        ((bits(-1.0), bits(-2.0)), 0),
        ((bits(1.0), bits(1.0)), 0),
        ((MINUS_DENORMAL, 0), 0),
        ((NAN, bits(1.0)), 0),
    ],
    "intsp": [((0xFFFF_FFFF,), bits(-1.0)), ((16777217,), bits(16777216.0)), ((16777219,), bits(16777220.0))],
    "intspu": [((0xFFFF_FFFF,), bits(4294967296.0)), ((16777219,), bits(16777220.0))],
    "spint": [
        ((bits(2.5),), 2),
        ((bits(3.5),), 4),
        ((bits(-2.5),), 0xFFFF_FFFE),
        ((bits(-0.75),), 0xFFFF_FFFF),
        ((bits(3e9),), 0x7FFF_FFFF),
        ((bits(-3e9),), 0x8000_0000),
        ((INF,), 0x7FFF_FFFF),
        ((0xFF80_0000,), 0x8000_0000),
        ((DENORMAL,), 0),
    ],
    "sptrunc": [
        ((bits(2.75),), 2),
        ((bits(-2.75),), 0xFFFF_FFFE),
        ((bits(3e9),), 0x7FFF_FFFF),
        ((bits(-3e9),), 0x8000_0000),
        ((0xFF80_0000,), 0x8000_0000),
    ],
}


@dataclass(frozen=True)
class AccessAnswer:
    """A load or store at an offset, as printed, from where PATTERN starts, and what it leaves.

    refused: an offset in bytes at which it is misaligned, None if there is none.
    left: registers a10 and a11 after a load, or the sixteen bytes of memory after a store.
    """

    offset: str
    refused: int | None
    left: tuple[int, ...] | bytes


# Where loads and stores look: sixteen bytes that tell each other's place. What stores put there is a11:a10.
PATTERN = bytes.fromhex("91a2b3c4d5e6f708192a3b4c5d6e7f80")
STORED = (0x5566_7788, 0x1122_3344)
UNTOUCHED = 0x0BAD_0BAD
ACCESSES: dict[str, list[AccessAnswer]] = {
    "ldb": [AccessAnswer("(3)", None, (0xFFFF_FFC4, UNTOUCHED)), AccessAnswer("(7)", None, (8, UNTOUCHED))],
    "ldbu": [AccessAnswer("(3)", None, (0x0000_00C4, UNTOUCHED))],
    "ldh": [AccessAnswer("(2)", 3, (0xFFFF_C4B3, UNTOUCHED)), AccessAnswer("(6)", 1, (0x0000_08F7, UNTOUCHED))],
    "ldhu": [AccessAnswer("(2)", 3, (0x0000_C4B3, UNTOUCHED))],
    "ldw": [AccessAnswer("(4)", 2, (0x08F7_E6D5, UNTOUCHED))],
    "ldnw": [AccessAnswer("(3)", None, (0xF7E6_D5C4, UNTOUCHED))],
    "lddw": [AccessAnswer("(8)", 4, (0x4C3B_2A19, 0x807F_6E5D))],
    "ldndw": [
        AccessAnswer("(3)", None, (0xF7E6_D5C4, 0x3B2A_1908)),
        AccessAnswer("[1]", None, (0x4C3B_2A19, 0x807F_6E5D)),
    ],
    "stb": [AccessAnswer("(3)", None, bytes.fromhex("91a2b388d5e6f708192a3b4c5d6e7f80"))],
    "sth": [AccessAnswer("(2)", 3, bytes.fromhex("91a28877d5e6f708192a3b4c5d6e7f80"))],
    "stw": [AccessAnswer("(4)", 2, bytes.fromhex("91a2b3c488776655192a3b4c5d6e7f80"))],
    "stnw": [AccessAnswer("(3)", None, bytes.fromhex("91a2b38877665508192a3b4c5d6e7f80"))],
    "stdw": [AccessAnswer("(8)", 4, bytes.fromhex("91a2b3c4d5e6f7088877665544332211"))],
    "stndw": [
        AccessAnswer("(3)", None, bytes.fromhex("91a2b388776655443322114c5d6e7f80")),
        AccessAnswer("[1]", None, bytes.fromhex("91a2b3c4d5e6f7088877665544332211")),
    ],
}
