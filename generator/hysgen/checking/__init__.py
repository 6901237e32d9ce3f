"""Whether generated C is right: builds on the host, equality of bits, static proofs, endurance runs."""
