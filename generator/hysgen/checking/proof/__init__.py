"""What can be shown of the generated C without the target: other processors, warnings, rules, proofs."""
