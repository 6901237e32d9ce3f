"""Arithmetic of each C674x operation on 32-bit register images: the specification of the compiled engine.

Sources: TMS320C674x DSP CPU and Instruction Set (SPRUFE8), one page per instruction. Rounding is to nearest, ties to
even (the reset state of FADCR and FMCR; no program here changes it).
"""

import math
import struct
from collections.abc import Callable, Mapping

MASK = 0xFFFF_FFFF
NAN_OUT = 0x7FFF_FFFF
_SIGN, _EXPONENT, _FRACTION = 0x8000_0000, 0x7F80_0000, 0x007F_FFFF
_INT_MAX, _INT_MIN = 0x7FFF_FFFF, -0x8000_0000


def signed(image: int, bits: int = 32) -> int:
    """The two's complement value of the lowest `bits` bits."""
    image &= (1 << bits) - 1
    return image - (1 << bits) if image >> (bits - 1) else image


def to_image(value: float) -> int:
    """IEEE 754 single-precision bits of `value`, rounded to nearest; infinity if too large, NaN_out for NaN."""
    if math.isnan(value):
        return NAN_OUT
    try:
        return int.from_bytes(struct.pack("<f", value), "little")
    except OverflowError:
        return _EXPONENT | (_SIGN if value < 0 else 0)


def from_image(image: int) -> float:
    """The value of single-precision bits."""
    return float(struct.unpack("<f", image.to_bytes(4, "little"))[0])


class FloatUnit:
    """Single-precision arithmetic without denormals: a denormal operand or result becomes zero of the same sign.

    Every operation is computed in float64 and rounded to float32. The double rounding changes no result: products of
    two 24-bit significands are exact in 53 bits, and for sums 53 >= 2 * 24 + 2 (Figueroa, 1995). denormals, nans:
    numbers of flushed denormals and of NaN results. Equality with another processor is guaranteed only while both are
    0.
    """

    def __init__(self) -> None:
        self.denormals = 0
        self.nans = 0

    def _flush(self, image: int) -> int:
        if image & _EXPONENT == 0 and image & _FRACTION:
            self.denormals += 1
            return image & _SIGN
        return image

    def read(self, image: int) -> float:
        """The value of an operand; a denormal number is read as zero and counted."""
        return from_image(self._flush(image))

    def _write(self, value: float) -> int:
        image = to_image(value)
        if image == NAN_OUT:
            self.nans += 1
        return self._flush(image)

    def addsp(self, a: int, b: int) -> int:
        """a + b"""
        return self._write(self.read(a) + self.read(b))

    def subsp(self, a: int, b: int) -> int:
        """a - b"""
        return self._write(self.read(a) - self.read(b))

    def mpysp(self, a: int, b: int) -> int:
        """a b"""
        return self._write(self.read(a) * self.read(b))

    def abssp(self, a: int) -> int:
        """|a|; a denormal gives +0, a NaN gives NaN_out"""
        return self._write(abs(self.read(a)))

    def cmpeqsp(self, a: int, b: int) -> int:
        """1 if a = b else 0; with a NaN 0, as for the other comparisons"""
        return int(self.read(a) == self.read(b))

    def cmpgtsp(self, a: int, b: int) -> int:
        """1 if a > b else 0"""
        return int(self.read(a) > self.read(b))

    def cmpltsp(self, a: int, b: int) -> int:
        """1 if a < b else 0"""
        return int(self.read(a) < self.read(b))

    def intsp(self, a: int) -> int:
        """Signed integer to float"""
        return self._write(float(signed(a)))

    def intspu(self, a: int) -> int:
        """Unsigned integer to float"""
        return self._write(float(a))

    def spint(self, a: int) -> int:
        """Float to integer, ties to even, saturated. Raises ValueError for NaN, which is not modelled."""
        return self._to_integer(a, round)

    def sptrunc(self, a: int) -> int:
        """Float to integer, toward zero, saturated. Raises ValueError for NaN, which is not modelled."""
        return self._to_integer(a, math.trunc)

    def _to_integer(self, a: int, rounded: Callable[[float], int]) -> int:
        value = self.read(a)
        if math.isinf(value):
            return _INT_MAX if value > 0 else _INT_MIN & MASK
        return max(_INT_MIN, min(_INT_MAX, rounded(value))) & MASK


def _shl(a: int, b: int) -> int:
    return a << (b & 63) & MASK


def _shr(a: int, b: int) -> int:
    return signed(a) >> (b & 63) & MASK


def _shru(a: int, b: int) -> int:
    return a >> (b & 63)


def _rotl(a: int, b: int) -> int:
    return (a << (b & 31) | a >> (32 - (b & 31))) & MASK


def _field(first: int, last: int) -> int:
    """Bits first..last set; none if first > last."""
    return ((2 << last) - 1) & ~((1 << first) - 1) & MASK


def _ext(a: int, left: int, right: int) -> int:
    return signed(a << left) >> right & MASK


def _extu(a: int, left: int, right: int) -> int:
    return (a << left & MASK) >> right


def _lmbd(bit: int, a: int) -> int:
    """Distance of the leftmost bit equal to `bit` from the top; 32 if there is none."""
    sought = a if bit & 1 else ~a & MASK
    return 32 - sought.bit_length()


def _low(a: int) -> int:
    return a & 0xFFFF


def _high(a: int) -> int:
    return a >> 16


def _s(half: int) -> int:
    return signed(half, 16)


# mnemonic -> function of the source images in printed order. Constants come as 32-bit images too.
INTEGER: Mapping[str, Callable[..., int]] = {
    "add": lambda a, b: a + b & MASK,
    "sub": lambda a, b: a - b & MASK,
    "and": lambda a, b: a & b,
    "or": lambda a, b: a | b,
    "xor": lambda a, b: a ^ b,
    "andn": lambda a, b: a & ~b & MASK,
    "abs": lambda a: min(abs(signed(a)), _INT_MAX),
    "addab": lambda a, b: a + b & MASK,
    "addah": lambda a, b: a + 2 * b & MASK,
    "addaw": lambda a, b: a + 4 * b & MASK,
    "addad": lambda a, b: a + 8 * b & MASK,
    "subab": lambda a, b: a - b & MASK,
    "subah": lambda a, b: a - 2 * b & MASK,
    "subaw": lambda a, b: a - 4 * b & MASK,
    "shl": _shl,
    "shr": _shr,
    "shru": _shru,
    "rotl": _rotl,
    "ext": _ext,
    "extu": _extu,
    "set": lambda a, first, last: a | _field(first, last),
    "clr": lambda a, first, last: a & ~_field(first, last) & MASK,
    "cmpeq": lambda a, b: int(a == b),
    "cmpgt": lambda a, b: int(signed(a) > signed(b)),
    "cmplt": lambda a, b: int(signed(a) < signed(b)),
    "cmpgtu": lambda a, b: int(a > b),
    "cmpltu": lambda a, b: int(a < b),
    "lmbd": _lmbd,
    "mvk": lambda a: a,
    "mvkh": lambda a, d: a & 0xFFFF_0000 | _low(d),
    "addk": lambda a, d: a + d & MASK,
    "mpy": lambda a, b: _s(_low(a)) * _s(_low(b)) & MASK,
    "mpyu": lambda a, b: _low(a) * _low(b),
    "mpysu": lambda a, b: _s(_low(a)) * _low(b) & MASK,
    "mpyus": lambda a, b: _low(a) * _s(_low(b)) & MASK,
    "mpyh": lambda a, b: _s(_high(a)) * _s(_high(b)) & MASK,
    "mpyhu": lambda a, b: _high(a) * _high(b),
    "mpyhl": lambda a, b: _s(_high(a)) * _s(_low(b)) & MASK,
    "mpylh": lambda a, b: _s(_low(a)) * _s(_high(b)) & MASK,
    "mpyhlu": lambda a, b: _high(a) * _low(b),
    "mpylhu": lambda a, b: _low(a) * _high(b),
    "mpy32": lambda a, b: a * b & MASK,
}

FLOAT: Mapping[str, Callable[..., int]] = {
    "addsp": FloatUnit.addsp,
    "subsp": FloatUnit.subsp,
    "mpysp": FloatUnit.mpysp,
    "abssp": FloatUnit.abssp,
    "cmpeqsp": FloatUnit.cmpeqsp,
    "cmpgtsp": FloatUnit.cmpgtsp,
    "cmpltsp": FloatUnit.cmpltsp,
    "intsp": FloatUnit.intsp,
    "intspu": FloatUnit.intspu,
    "spint": FloatUnit.spint,
    "sptrunc": FloatUnit.sptrunc,
}

# Instructions that modify their destination: its old value is their last source.
READS_DESTINATION = frozenset({"mvkh", "addk"})
