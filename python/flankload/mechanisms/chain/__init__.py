"""A chain on its sprocket."""
