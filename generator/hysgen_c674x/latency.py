"""Latencies: delay slots of every modelled instruction.

The result of an instruction issued in cycle t with d delay slots is read by instructions issued in cycle t + d + 1 and
later; until then the register holds its old value. The pipeline has no interlocks: the compiler must schedule for it.
Source: SPRUFE8, section 4 (pipeline phases per instruction type).
"""

from collections.abc import Mapping

BRANCH_DELAY = 5
LOAD_DELAY = 4

_SINGLE_CYCLE = (
    "add sub and or xor andn abs addab addah addaw addad subab subah subaw shl shr shru ext extu set clr "
    "cmpeq cmpgt cmplt cmpgtu cmpltu lmbd mvk mvkh addk abssp cmpeqsp cmpgtsp cmpltsp"
)
_TWO_CYCLE = "rotl mpy mpyu mpysu mpyus mpyh mpyhu mpyhl mpylh mpyhlu mpylhu"
_FOUR_CYCLE = "mpy32 addsp subsp mpysp intsp intspu spint sptrunc"
_LOADS = "ldb ldbu ldh ldhu ldw lddw ldnw ldndw"

DELAY_SLOTS: Mapping[str, int] = {
    **dict.fromkeys(_SINGLE_CYCLE.split(), 0),
    **dict.fromkeys(_TWO_CYCLE.split(), 1),
    **dict.fromkeys(_FOUR_CYCLE.split(), 3),
    **dict.fromkeys(_LOADS.split(), LOAD_DELAY),
}
