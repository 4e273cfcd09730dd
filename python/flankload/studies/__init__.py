"""Studies with many runs: plans, tolerance control, accuracy studies and verification."""
