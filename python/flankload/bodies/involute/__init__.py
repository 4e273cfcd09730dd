"""Bodies with involute flanks (gears, rings, splines) and their sector meshes."""
