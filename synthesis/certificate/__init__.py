"""Claims and their exact proofs."""
