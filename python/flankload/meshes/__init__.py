"""Plane finite-element meshes: blocks, defects, report; `io`: reading and writing of files."""
