"""From measured frequency responses to a nominal model and a weight that covers every one of them.

from robimp.synthesis.identify import identify, record_of
found = identify([record_of(frd, "sweep 1"), ...], kind="load", beyond="hold")
"""

from .identified import Identified, identify
from .records import read_files, record_of
from .written import specification

__all__ = ["Identified", "identify", "read_files", "record_of", "specification"]
