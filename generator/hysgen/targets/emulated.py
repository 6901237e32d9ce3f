"""Other processors under qemu: equality of bits."""

from hysgen.checking.proof.emulated import PLATFORMS, EmulationSettings, equality
from hysgen.model.model import Model
from hysgen.targets import Equality, Extent, Progress, Target, Texts

SAMPLES = 20_000


def verify(model: Model, texts: Texts, extent: Extent, progress: Progress) -> Equality:
    """Compare the bits of emulated processors with those of the reference."""
    samples = SAMPLES if extent.samples is None else extent.samples
    platforms = [platform for platform in PLATFORMS if not extent.machines or platform.name in extent.machines]
    return equality(model, texts, EmulationSettings(samples, platforms, seed=extent.seed), progress)


TARGET = Target(
    "emulated",
    about="on other processors under qemu, every one whose compiler is installed",
    verify=verify,
    verify_options=("machines",),
)
