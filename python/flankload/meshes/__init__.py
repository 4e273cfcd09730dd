"""Plane finite-element meshes: blocks, defects, report; `io` reads and writes files."""
