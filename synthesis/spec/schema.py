"""The specification format as a JSON Schema, for editors: names, ranges, units; `load_spec` has the last word."""

from __future__ import annotations

from .schema_demands import constraints, controller, objective
from .schema_joint import actuator, impedance, plant, sampling, uncertainty
from .schema_terms import Schema, section, words


def json_schema() -> Schema:
    """JSON Schema (2020-12) of a specification file, format version 1."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "robimp specification, format 1",
        **section(
            "One robot joint, its uncertainty, the impedance it should render, and what must be proven.",
            {
                "robimp": {"const": 1, "description": "format version"},
                "name": {
                    "type": ["string", "integer"],
                    "pattern": "^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$",
                    "description": "names the output folder",
                },
                "motion": words("a rotary joint (N·m, rad) or a linear one (N, m)", "rotary", "linear"),
                "plant": plant(),
                "uncertainty": uncertainty(),
                "actuator": actuator(),
                "impedance": impedance(),
                "controller": controller(),
                "objective": objective(),
                "constraints": constraints(),
            },
            {"sampling": sampling()},
        ),
    }
