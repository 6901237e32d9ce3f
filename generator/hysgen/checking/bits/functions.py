"""The compared structs: instance and learner, the generated functions that step them, and their float32 references."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.bits.inputs import CHUNK
from hysgen.checking.host import Host
from hysgen.float32.learner_status import LEARNER_COUNTERS
from hysgen.float32.reference.instance import Instance
from hysgen.float32.reference.learner import Learner
from hysgen.model.model import Model
from hysgen.model.status import COUNTERS

Words = NDArray[np.uint32]
Floats32 = NDArray[np.float32]

START_UM: Final = np.float32(0.0)
START_V: Final = np.float32(0.0)
NEARLY_FULL: Final = 0xFFFFFF00
"""A counter value close to the saturation of uint32."""
QUIET_NAN: Final = 0x7FC00000


class Lanes(Protocol):
    """A reference that steps many independent states at once; its methods bear the names of the C functions."""

    def words(self) -> Mapping[str, Words]:
        """Every compared word of the struct by name, in the order of the C, (lanes,) each."""
        ...

    def restore(self, words: Sequence[Words]) -> None:
        """Set all states from their words in the same order, (lanes,) each."""
        ...


@dataclass(frozen=True)
class ComparedStruct:
    """A generated struct and the functions that step it.

    type_suffix: its C type without the model's name. functions: the quantity of each float argument (see `inputs`), by
    function. first_word: C path of the first compared word; the reference's `words` give their number.
    create: a new struct initialised by the C. reference: the same initial state in NumPy, one lane.
    wear: writes the state of a struct after months of operation: counters near saturation.
    has_channels: whether its functions read the model's auxiliary channels. chunk: samples recorded at once; smaller
    for a large state.
    """

    type_suffix: str
    functions: Mapping[str, tuple[str, ...]]
    first_word: str
    create: Callable[[Host], Any]
    reference: Callable[[Model], Lanes]
    wear: Callable[[Host, Any], None]
    has_channels: bool
    chunk: int = CHUNK

    def quantities(self, function: str, host: Host) -> list[str]:
        """The quantity of each argument of `function`, then "channel" for each auxiliary channel of the model."""
        return [*self.functions[function], *(["channel"] * host.channels if self.has_channels else [])]


def _instance(model: Model) -> Lanes:
    return Instance(model, np.full(1, START_UM), np.full(1, START_V))


def _wear_instance(host: Host, struct: Any) -> None:
    """Counters near saturation, the second bank active, the first bank full of NaN; limits of the inverse that act."""
    words, layout = host.words_of(struct), host.layout(f"{host.name}_t")
    for name in COUNTERS:
        words[layout[name]] = NEARLY_FULL
    for path, place in layout.items():
        if path.startswith("bank[0]"):
            words[place] = QUIET_NAN
    words[layout["active"]] = 1
    low, high = (words[layout[name] :].view(np.float32)[0] for name in ("low_V", "high_V"))
    quarter = np.float32(0.25) * (high - low)
    limits = np.array([low + quarter, high - quarter, quarter / np.float32(16.0)], np.float32)
    for name, limit in zip(("low_V", "high_V", "step_V"), limits.view(np.uint32), strict=True):
        words[layout[name]] = limit


def _new_learner(host: Host) -> Any:
    learner = host.struct(f"{host.name}_learner_t")
    host.call("learn_init", learner, host.instance(float(START_UM), float(START_V)))
    return learner


def _learner(model: Model) -> Lanes:
    return Learner(model, Instance(model, np.full(1, START_UM), np.full(1, START_V)))


def _wear_learner(host: Host, struct: Any) -> None:
    """Counters and the age of the shadow near saturation."""
    words, layout = host.words_of(struct), host.layout(f"{host.name}_learner_t")
    for name in (*LEARNER_COUNTERS, "age"):
        words[layout[name]] = NEARLY_FULL


MODEL: Final = ComparedStruct(
    type_suffix="t",
    functions={
        "init": ("displacement", "voltage"),
        "predict": ("displacement", "voltage"),
        "simulate": ("voltage",),
        "limits": ("voltage", "voltage", "voltage"),
        "inverse": ("displacement", "reference"),
    },
    first_word="y_um",
    create=lambda host: host.instance(float(START_UM), float(START_V)),
    reference=_instance,
    wear=_wear_instance,
    has_channels=True,
)

LEARNER: Final = ComparedStruct(
    type_suffix="learner_t",
    functions={"learn": ("measured", "voltage")},
    first_word="d[0]",
    create=_new_learner,
    reference=_learner,
    wear=_wear_learner,
    has_channels=False,
    chunk=1 << 12,
)

COMPARED_STRUCTS: Final[list[ComparedStruct]] = [MODEL, LEARNER]
"""Every compared struct; functions that the generated header does not declare are skipped."""
