"""The words of `<name>_t` between `active` and the banks, from which C struct and mirror are built."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from hysgen.float32.struct_words import COUNTERS_OF, INPUTS_OF, TERMS_OF, Floats32, StructWords, Words, integer, number
from hysgen.model.disturbances import Mirror
from hysgen.model.path.chain import ChainMirror
from hysgen.model.status import COUNTERS
from hysgen.model.structs import Counter


class InstanceWords(StructWords):
    """State of `lanes` instances; every scalar word is an array (lanes,)."""

    COUNTERS: ClassVar[Mapping[str, Counter]] = COUNTERS

    y_um: Annotated[Floats32, number("last output of the model", unit="um", remark=", from which a free run continues")]
    u_V: Annotated[Floats32, number("last accepted input", unit="V")]
    low_V: Annotated[Floats32, number("lowest voltage that may be put out", unit="V")]
    high_V: Annotated[Floats32, number("highest voltage that may be put out", unit="V")]
    step_V: Annotated[Floats32, number("largest change of the voltage per sample", unit="V")]
    status: Annotated[Words, integer("bits {NAME}_STATUS_..., set by events and cleared by the caller")]
    counters: Annotated[dict[str, Words], COUNTERS_OF]
    inputs: Annotated[ChainMirror, INPUTS_OF]
    terms: Annotated[list[Mirror], TERMS_OF]
