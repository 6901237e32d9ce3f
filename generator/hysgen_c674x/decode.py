"""Decoding of an instruction to one of nine actions, and the delay slots of every modelled instruction.

Interpreter, compiled engine and static cycle counts use the same actions.

The result of an instruction issued in cycle t with d delay slots is read by instructions issued in cycle t + d + 1 and
later; until then the register holds its old value. The pipeline has no interlocks: the compiler must schedule for it.
Source: SPRUFE8, section 4 (pipeline phases per instruction type).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from hysgen.checking.symbolic.semantics import FLOAT, INTEGER, MASK, READS_DESTINATION
from hysgen.errors import TargetError
from hysgen_c674x.assembly import Instruction, Label, MemoryOperand, Operand, Pair, Register

BRANCH_DELAY = 5
LOAD_DELAY = 4

_SINGLE_CYCLE = (
    "add sub and or xor andn abs addab addah addaw addad subab subah subaw shl shr shru ext extu set clr "
    "cmpeq cmpgt cmplt cmpgtu cmpltu lmbd mvk mvkh addk abssp cmpeqsp cmpgtsp cmpltsp"
)
_TWO_CYCLE = "rotl mpy mpyu mpysu mpyus mpyh mpyhu mpyhl mpylh mpyhlu mpylhu"
_FOUR_CYCLE = "mpy32 addsp subsp mpysp intsp intspu spint sptrunc"

DELAY_SLOTS: Mapping[str, int] = {
    **dict.fromkeys(_SINGLE_CYCLE.split(), 0),
    **dict.fromkeys(_TWO_CYCLE.split(), 1),
    **dict.fromkeys(_FOUR_CYCLE.split(), 3),
    **dict.fromkeys(["ldb", "ldbu", "ldh", "ldhu", "ldw", "lddw", "ldnw", "ldndw"], LOAD_DELAY),
}


Source = Register | int


@dataclass(frozen=True)
class Compute:
    """destination := operation(sources), readable after `delay` further cycles."""

    mnemonic: str
    sources: tuple[Source, ...]
    destination: Register
    delay: int


@dataclass(frozen=True)
class Access:
    """Common part of loads and stores: `size` bytes at address `memory`, a multiple of `alignment`.

    registers: the register of the low word, then, for 64 bits, the register of the high word.
    """

    memory: MemoryOperand
    size: int
    alignment: int
    registers: tuple[Register, ...]


@dataclass(frozen=True)
class Load(Access):
    """registers := memory, sign-extended if `signed`, else zero-extended; readable after `delay` further cycles."""

    signed: bool
    delay: int


@dataclass(frozen=True)
class Store(Access):
    """memory := registers; loads of later packets read the new value."""


@dataclass(frozen=True)
class Jump:
    """Jump to `target` after the delay slots. link: register for the address of the next packet, in a call.

    idle: cycles without instructions after the packet.
    """

    target: Register | int
    link: Register | None
    idle: int


@dataclass(frozen=True)
class LoadAddress:
    """destination := a code address known at link time; then `idle` cycles without instructions."""

    destination: Register
    address: int
    idle: int


@dataclass(frozen=True)
class Idle:
    """`cycles` cycles without instructions after the packet's own cycle."""

    cycles: int


@dataclass(frozen=True)
class ReadControl:
    """destination := a control register, by its number in CONTROL."""

    control: int
    destination: Register


@dataclass(frozen=True)
class WriteControl:
    """A control register, by its number in CONTROL, := source."""

    control: int
    source: Register


@dataclass(frozen=True)
class Return:
    """Return from an interrupt to the address in IRP or NRP, by its number in CONTROL, after the delay slots."""

    control: int


Action = Compute | Load | Store | Jump | LoadAddress | Idle | ReadControl | WriteControl | Return

CONTROL = ("amr", "csr", "ifr", "isr", "icr", "ier", "istp", "irp", "nrp", "tscl", "fadcr", "fmcr", "tsr")
"""Control registers that are modelled; numbers as in engine/state.h."""

# mnemonic -> bytes, alignment, sign extension
_LOADS = {
    "ldb": (1, 1, True),
    "ldbu": (1, 1, False),
    "ldh": (2, 2, True),
    "ldhu": (2, 2, False),
    "ldw": (4, 4, False),
    "lddw": (8, 8, False),
    "ldnw": (4, 1, False),
    "ldndw": (8, 1, False),
}
_STORES = {"stb": (1, 1), "sth": (2, 2), "stw": (4, 4), "stdw": (8, 8), "stnw": (4, 1), "stndw": (8, 1)}
_CONSTANT_FORM_ONLY = frozenset({"ext", "extu", "set", "clr"})


def action(instruction: Instruction) -> Action:
    """The action of an instruction.

    Raises TargetError with address and text if the instruction, or this form of it, is not modelled.
    """
    try:
        decoded = _action(instruction)
    except (ValueError, IndexError):
        decoded = None
    if decoded is None:
        raise TargetError(f"{instruction}: not modelled by the simulator; change the C, or use the host")
    return decoded


def _action(instruction: Instruction) -> Action | None:
    mnemonic, operands = instruction.mnemonic, instruction.operands
    if mnemonic in INTEGER or mnemonic in FLOAT:
        return _compute(mnemonic, operands)
    if mnemonic in _LOADS:
        memory, data = operands
        size, alignment, signed = _LOADS[mnemonic]
        return Load(_memory(memory), size, alignment, _data(data, size), signed, DELAY_SLOTS[mnemonic])
    if mnemonic in _STORES:
        data, memory = operands
        size, alignment = _STORES[mnemonic]
        return Store(_memory(memory), size, alignment, _data(data, size))
    if mnemonic in _CONTROL:
        return _CONTROL[mnemonic](operands)
    return None


def _compute(mnemonic: str, operands: tuple[Operand, ...]) -> Compute | None:
    *printed, last = operands
    destination = _register(last)
    sources = tuple(_source(operand) for operand in printed)
    if mnemonic in READS_DESTINATION:
        sources = (*sources, destination)
    if mnemonic in _CONSTANT_FORM_ONLY and len(sources) != 3:
        return None
    return Compute(mnemonic, sources, destination, DELAY_SLOTS[mnemonic])


def _source(operand: Operand) -> Source:
    return operand if isinstance(operand, Register) else _constant(operand) & MASK


def _constant(operand: Operand) -> int:
    if not isinstance(operand, int):
        raise ValueError(operand)
    return operand


def _register(operand: Operand) -> Register:
    if not isinstance(operand, Register):
        raise ValueError(operand)
    return operand


def _label(operand: Operand) -> int:
    if not isinstance(operand, Label):
        raise ValueError(operand)
    return operand.address


def _branch(operand: Operand) -> Jump | Return:
    return Return(CONTROL.index(operand)) if operand in ("irp", "nrp") else Jump(_target(operand), None, 0)


def _control(source: Operand, destination: Operand) -> ReadControl | WriteControl:
    if isinstance(source, str):
        return ReadControl(CONTROL.index(source), _register(destination))
    if not isinstance(destination, str):
        raise ValueError(destination)
    return WriteControl(CONTROL.index(destination), _register(source))


def _target(operand: Operand) -> Register | int:
    return operand if isinstance(operand, Register) else _label(operand)


_CONTROL: Mapping[str, Callable[[tuple[Operand, ...]], Action]] = {
    "b": lambda operands: _branch(operands[0]),
    "mvc": lambda operands: _control(*operands),
    "bnop": lambda operands: Jump(_target(operands[0]), None, _constant(operands[1])),
    "callp": lambda operands: Jump(_target(operands[0]), _register(operands[1]), 5),
    "addkpc": lambda operands: LoadAddress(_register(operands[1]), _label(operands[0]), _constant(operands[2])),
    "nop": lambda operands: Idle((_constant(operands[0]) if operands else 1) - 1),
}

MODELLED = frozenset({*INTEGER, *FLOAT, *_LOADS, *_STORES, *_CONTROL} - {"mvc"})
"""Mnemonics of all modelled instructions of functions. Code that owns the processor may use `mvc` with the registers of
CONTROL, too; every other instruction is refused."""


def _memory(operand: Operand) -> MemoryOperand:
    if not isinstance(operand, MemoryOperand):
        raise ValueError(operand)
    return operand


def _data(operand: Operand, size: int) -> tuple[Register, ...]:
    if size == 8:
        if not isinstance(operand, Pair):
            raise ValueError(operand)
        return operand.low, operand.high
    return (_register(operand),)
