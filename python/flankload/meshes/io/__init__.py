"""Reading and writing of mesh files.

.msh (gmsh) and .inp (Abaqus) are read here, since meshio drops parts of both formats (entities in
several groups, unnamed groups; plane element types, sets on the keyword line, surfaces). All other
formats are read with meshio.
"""

from flankload.meshes.io.file_mesh import PLANE_CELLS, RawMesh
from flankload.meshes.io.reading import is_mesh_name, read_mesh
from flankload.meshes.io.writing import WRITERS, vtu_of, write_mesh

__all__ = ["PLANE_CELLS", "WRITERS", "RawMesh", "is_mesh_name", "read_mesh", "vtu_of", "write_mesh"]
