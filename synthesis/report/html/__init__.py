"""The report: one HTML file that explains certificates, or a map, offline."""

from .map_page import write_map_report
from .write import write_report

__all__ = ["write_map_report", "write_report"]
