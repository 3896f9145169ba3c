"""From the model to what the board holds: formats, integers, proofs."""
