"""The report: one HTML file that explains a certificate offline. `write_report({name: bytes}, path)`."""

from .write import write_report

__all__ = ["write_report"]
