"""Several gear meshes in one contact problem: what stages and trains have in common."""
