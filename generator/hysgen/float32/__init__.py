"""The float32 reference of the generated C, and every number that C and reference share."""
