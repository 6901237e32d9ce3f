"""The float32 reference of the generated C, written in NumPy from the equations, for many instances (lanes) at once.

The package uses no template, and no reduction (sum, dot, BLAS) that NumPy evaluates in an unspecified order.
"""
