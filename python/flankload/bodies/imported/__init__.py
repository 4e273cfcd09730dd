"""Bodies imported from files: finite-element meshes, modal and nodal compliances."""
