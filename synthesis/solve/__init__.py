"""The bound, the structured controller, the counterexample loop, rounding."""
