"""The two models that the paper prints, appendices A and B: the sources of the shipped models of these names.

Source: P. Li et al., "A simple fuzzy system for modelling of both rate-independent and rate-dependent hysteresis in
piezoelectric actuators", Mechanical Systems and Signal Processing (2013), doi 10.1016/j.ymssp.2012.10.004, appendices.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from hysgen.certify.certificates import certify
from hysgen.model.model import Grid, Model

PRINTED_CENTRES_UM = {
    "appendix_a": (0.6608, 1.2758, 1.8909, 2.5059, 3.1209, 3.7359),
    "appendix_b": (0.4831, 0.9365, 1.3900, 1.8434, 2.2968, 2.7502),
}
PRINTED_SIGMA_UM = {"appendix_a": 0.6150, "appendix_b": 0.4534}
PRINTED_CONSEQUENTS = {
    "appendix_a": (
        (0.6121, 0.0016, -0.2550),
        (0.0696, 0.0017, 1.1151),
        (0.6007, 0.0015, 1.1611),
        (1.0324, 0.0017, -0.1756),
        (0.8326, 0.0014, 0.3284),
        (0.8733, 0.0021, 0.4491),
    ),
    "appendix_b": (
        (0.8108, -0.0015, -0.1025),
        (0.0226, 0.0047, 0.4549),
        (-0.0123, -0.0014, 1.6880),
        (0.7710, 0.0037, 0.6780),
        (1.4337, -0.0005, -0.9060),
        (1.1658, 0.0029, -0.8047),
    ),
}
ACTUATOR_RANGE_V = (-20.0, 120.0)
PAPER_TS_S = 2e-5


def appendix(name: str) -> Model:
    """Appendix A (rate-independent, section 4.1) or B (rate-dependent, section 4.2) of the paper, from its tables.

    The partition lies between the outermost printed centres. Input range: the actuator's; sampling period: 20 us.
    """
    centres = PRINTED_CENTRES_UM[name]
    bare = Model(
        name=name,
        Ts_s=PAPER_TS_S,
        grid=Grid(centres[0], centres[-1], len(centres)),
        consequents=np.array(PRINTED_CONSEQUENTS[name]),
        u_min_V=ACTUATOR_RANGE_V[0],
        u_max_V=ACTUATOR_RANGE_V[1],
        history={"source": f"Li et al. (2013), doi 10.1016/j.ymssp.2012.10.004, {name.replace('_', ' ').title()}"},
    )
    return dataclasses.replace(bare, certificates=certify(bare).to_json())
