"""Independent checker of certificates: standard library only, shares no formula with the producer. See README.md."""

import sys
from pathlib import Path
from types import ModuleType

from .reader import canonical_json
from .verdict import Verdict, check_bytes, check_file

__all__ = ["Verdict", "canonical_json", "check_bytes", "check_file"]


class _Check(ModuleType):
    """The package is its own main function: `check(path)` is `check_file(path)`, and its submodules stay importable."""

    def __call__(self, path: str | Path, *, time_limit: float = 60.0) -> Verdict:
        """Prove every claim of a certificate's file again, within a time [s].

        Every file gets a verdict, so that a list of them can be gone through: one that is absent or no certificate
        has `exit_code` 2 and a `message` that says why, where `load` of a specification raises InputError.

        >>> from robimp.synthesis import check
        >>> check("certificate.json")
        <Verdict PROVEN, ω_B ≥ 8.87571 rad/s, 10 claims>
        >>> check("nope.json").exit_code
        2
        """
        return check_file(path, time_limit=time_limit)


sys.modules[__name__].__class__ = _Check
