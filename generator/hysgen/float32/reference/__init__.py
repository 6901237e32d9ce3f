"""The float32 reference: what the generated C computes, written again from the equations in NumPy, over many lanes.

Nothing here is rendered from the templates, and no reduction is used whose order NumPy does not fix (sum, dot, BLAS).
"""
