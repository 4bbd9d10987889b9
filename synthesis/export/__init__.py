"""A certified controller for a drive: discrete, rounded, proven again. The package can be called: `export(file, …)`."""

import sys
from types import ModuleType

from .exported import Exported, export

__all__ = ["Exported", "export"]


class _Export(ModuleType):
    """The package is its own main function, for `synthesis` hands it on under the folder's name."""

    __call__ = staticmethod(export)


sys.modules[__name__].__class__ = _Export
