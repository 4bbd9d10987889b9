"""Where two specifications differ, in words."""

from __future__ import annotations

import json
from typing import Any


def first_difference(asked: Any, certified: Any, key: str = "") -> str | None:
    """The first difference of two canonical specifications, in the order of the file; None when there is none.

    `plant.inertia is 3/100 in the certificate, 31/1000 in the specification`.
    """
    if isinstance(asked, dict) and isinstance(certified, dict):
        for name in dict.fromkeys([*asked, *certified]):
            inner = first_difference(asked.get(name), certified.get(name), f"{key}.{name}" if key else name)
            if inner is not None:
                return inner
        return None
    if asked == certified:
        return None
    return f"{key} is {_readable(certified)} in the certificate, {_readable(asked)} in the specification"


def _readable(value: Any) -> str:
    if value is None:
        return "absent"
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
