"""The TI C674x as a target of the verbs: what the product finds of this package, by the entry point `hysgen.targets`.

The functions import their machinery when they are called: the help of a verb lists the targets.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from hysgen.codegen.operations import C674X
from hysgen.model.model import Model
from hysgen.targets import Equality, Extent, Kernels, Progress, Say, Target, TargetCost, Texts

SAMPLES = 4000


def verify(model: Model, texts: Texts, extent: Extent, progress: Progress) -> Equality:
    """Compare the bits of the simulated C674x with those of the host."""
    from hysgen_c674x.equality import verify_on_target

    samples = SAMPLES if extent.samples is None else extent.samples
    return verify_on_target(model, texts, samples, extent.seed, progress, extent.updates)


def cost(model: Model, texts: Texts) -> TargetCost:
    """Cycles, code and stack of every function, and the kernels beside their bounds."""
    from hysgen_c674x.cycles import footprint
    from hysgen_c674x.schedule.limits import kernel_costs, kernel_table

    figures, scheduled = footprint(model.name, texts), kernel_costs(model.name, texts)
    if not scheduled:
        return TargetCost(figures)
    return TargetCost(figures, [kernel_table(scheduled)], {"kernels": [vars(cost) for cost in scheduled]})


def schedule(name: str, texts: Texts, assembler: str) -> tuple[dict[str, str], Mapping[str, str]]:
    """The folder with its kernels, in the syntax of TI's assembler too if `assembler` is "ti"."""
    from hysgen_c674x.schedule.folder import kernels, with_kernels, with_ti_assembly

    made = kernels(name, texts)
    texts = with_kernels(name, texts, made)
    return with_ti_assembly(name, texts) if assembler == "ti" else texts, made.refused


def prove(model: Model, texts: Texts, functions: Sequence[str]) -> Equality:
    """Whether the kernels of a folder are equal to their C for every input."""
    from hysgen_c674x.schedule.proof import kernel_proofs

    return kernel_proofs(model, texts, functions)


def assembler_of(name: str, texts: Texts) -> str | None:
    """The assembler of the kernels of a folder, None without kernels."""
    from hysgen_c674x.schedule.folder import assembly_file, ti_file

    if assembly_file(name) not in texts:
        return None
    return "ti" if ti_file(name) in texts else "gnu"


def firmware(model: Model, texts: Texts, samples: int, say: Say, warn: Say) -> dict[str, Any]:
    """Sizes and cycles of the firmware's image."""
    from hysgen_c674x.firmware.timing import image_cost

    return image_cost(model, texts, samples, say, warn)


TARGET = Target(
    "c674x",
    about="run the C as its compiler makes it on the instruction-set simulator instead",
    weights=C674X,
    cost=cost,
    verify=verify,
    verify_options=("updates",),
    kernels=Kernels(("gnu", "ti"), schedule, assembler_of, prove),
    firmware=firmware,
)
