from __future__ import annotations
from fractions import Fraction
from .carried import Carried
def carried_over(setting, C, law, claims, progress):
    return tuple(Carried(c["id"], c["form"], c["required"], None if c["margin"] is None else Fraction(c["margin"]), None, "not yet") for c in claims)
