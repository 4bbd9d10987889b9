"""What polynomials do not decide: sampling, ranges, tables, sums of three roots, tolerance. See ../README.md.

Loaded only when a certificate has such a claim."""
