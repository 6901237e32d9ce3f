"""Proofs of the generated C without the target: other processors, compiler warnings, MISRA rules, Frama-C."""
