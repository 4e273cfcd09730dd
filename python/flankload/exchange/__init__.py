"""Models of other programs as scenes: one package per format."""
