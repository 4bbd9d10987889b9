"""A certified controller for a drive: discrete, rounded, proven again, as C, JSON, `control` objects or parameters."""

from .exported import Exported, export

__all__ = ["Exported", "export"]
