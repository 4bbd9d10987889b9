"""The command line: one file per command. Heavy libraries load inside the commands that use them."""

from .entry import main

__all__ = ["main"]
