"""Independent checker of certificates: standard library only, shares no formula with the producer. See README.md."""

from .reader import canonical_json
from .verdict import Verdict, check_bytes, check_file

__all__ = ["Verdict", "canonical_json", "check_bytes", "check_file"]
