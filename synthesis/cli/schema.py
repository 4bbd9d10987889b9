"""`robimp schema`: the JSON schema of specification files."""

from __future__ import annotations

from .common import dumped, say


def schema() -> None:
    """Print the JSON schema of specification files, for editors."""
    from ..spec import json_schema

    say(dumped(json_schema()))
