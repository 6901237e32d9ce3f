"""The float32 reference of the generated C, and the float32 numbers that both compute with."""
