"""Mesh files, in and out: the only room that knows file formats and meshio.

gmsh's .msh and Abaqus' .inp have readers of their own, since meshio loses parts of both (groups of
entities that are in several, unnamed groups; plane element types, sets on the keyword line,
surfaces). Everything else (.vtu and its kin) is read with meshio.
"""

from flankload.meshes.io.parts import PLANE_CELLS, RawMesh
from flankload.meshes.io.reading import is_mesh_name, read_mesh
from flankload.meshes.io.writing import WRITERS, write_mesh

__all__ = ["PLANE_CELLS", "WRITERS", "RawMesh", "is_mesh_name", "read_mesh", "write_mesh"]
