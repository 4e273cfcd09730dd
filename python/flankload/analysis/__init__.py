"""One run: states at all positions, tangent stiffness and error estimates."""
