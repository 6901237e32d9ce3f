"""What is compared: a generated struct, the functions that step it, and the float32 reference of both."""

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


class Lanes(Protocol):
    """A reference that steps many independent states at once; its functions are methods of the C functions' names."""

    def words(self) -> Mapping[str, Words]:
        """Every word of the struct that is compared, by name, in the order of the C, (lanes,) each."""
        ...

    def restore(self, words: Sequence[Words]) -> None:
        """Take over the states whose words are given in that order, (lanes,) each."""
        ...


@dataclass(frozen=True)
class Subject:
    """A struct and what steps it.

    struct: its C type behind the model's name; functions: by name, the quantity of each float argument (see `inputs`).
    first: C path of the first word that is compared; as many follow as the reference has `words`.
    start: a new struct, initialised by the C, and the same start in NumPy, one lane.
    wear: put a struct into a state that only months of use would reach.
    listens: its functions are driven with the auxiliary channels of the model.
    piece: samples that are recorded at once; less where the state is large.
    """

    struct: str
    functions: Mapping[str, tuple[str, ...]]
    first: str
    start: Callable[[Host], Any]
    reference: Callable[[Model], Lanes]
    wear: Callable[[Host, Any], None]
    listens: bool
    piece: int = CHUNK


def _instance(model: Model) -> Lanes:
    return Instance(model, np.full(1, START_UM), np.full(1, START_V))


def _wear(host: Host, struct: Any) -> None:
    """Counters about to reach their end; the second bank in use and the first one full of NaN."""
    words, layout = host.words_of(struct), host.layout(f"{host.name}_t")
    for name in COUNTERS:
        words[layout[name]] = 0xFFFFFF00
    for path, place in layout.items():
        if path.startswith("bank[0]"):
            words[place] = 0x7FC00000
    words[layout["active"]] = 1


def _new_learner(host: Host) -> Any:
    learner = host.struct(f"{host.name}_learner_t")
    host.call("learn_init", learner, host.instance(float(START_UM), float(START_V)))
    return learner


def _learner(model: Model) -> Lanes:
    return Learner(model, Instance(model, np.full(1, START_UM), np.full(1, START_V)))


def _wear_learner(host: Host, struct: Any) -> None:
    """Counters and age about to reach their end, the prior of the last parameter about to be put back."""
    words, layout = host.words_of(struct), host.layout(f"{host.name}_learner_t")
    for name in LEARNER_COUNTERS:
        words[layout[name]] = 0xFFFFFF00
    words[layout["age"]] = 0xFFFFFF00


MODEL: Final = Subject(
    struct="t",
    functions={
        "init": ("displacement", "voltage"),
        "predict": ("displacement", "voltage"),
        "simulate": ("voltage",),
        "inverse": ("displacement", "reference"),
    },
    first="y_um",
    start=lambda host: host.instance(float(START_UM), float(START_V)),
    reference=_instance,
    wear=_wear,
    listens=True,
)

LEARNER: Final = Subject(
    struct="learner_t",
    functions={"learn": ("measured", "voltage")},
    first="d[0]",
    start=_new_learner,
    reference=_learner,
    wear=_wear_learner,
    listens=False,
    piece=1 << 12,
)

SUBJECTS: Final[list[Subject]] = [MODEL, LEARNER]
"""Every struct that is compared; a subject whose functions the header does not declare is passed over."""
