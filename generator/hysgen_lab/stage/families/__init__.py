"""Test stages of five families of hysteresis, none of them made of play operators or of Duhem states.

    preisach            continuous Preisach density that is no product, integrated on a mesh of the Preisach plane
    relays              Preisach operator of single relays finer than the noise, with random thresholds and weights
    bouc-wen            Bouc-Wen with an exponent of 1 to 2, rising after every turn
    jiles-atherton      Jiles-Atherton with a Langevin curve and a susceptibility that is never negative
    thermal             hysterons that thermal activation switches, the one family that depends on the rate

The rest of a stage is the compiled plant of `hysgen_lab.stage`: exact in continuous time.
"""

from hysgen_lab.stage.families.base import Family
from hysgen_lab.stage.families.laws import JilesAtherton, MeshPreisach, RandomRelays, RisingBoucWen, ThermalHysterons
from hysgen_lab.stage.families.plants import FAMILIES, SCENARIOS, Plant, plant, records

__all__ = [
    "FAMILIES",
    "SCENARIOS",
    "Family",
    "JilesAtherton",
    "MeshPreisach",
    "Plant",
    "RandomRelays",
    "RisingBoucWen",
    "ThermalHysterons",
    "plant",
    "records",
]
