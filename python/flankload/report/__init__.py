"""A report: one HTML file of a scene and its results, for readers without flankload."""

from __future__ import annotations

from flankload.report.document import report_html, scene_of_report, write_report

__all__ = ["report_html", "scene_of_report", "write_report"]
