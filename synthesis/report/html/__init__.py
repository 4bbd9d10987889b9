"""The report: one HTML file that explains certificates, or a map, offline."""

from .files import report_files
from .write import write_report

__all__ = ["report_files", "write_report"]
