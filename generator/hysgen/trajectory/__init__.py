"""From a trajectory to the voltage that follows it: references, exact inverse, limits, learning over repeats."""
