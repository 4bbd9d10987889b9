"""Attacks on a certified joint in the time domain: they look for the worst, and do not know what was proven."""
