"""Many runs: plans, tolerance control, accuracy studies and verification."""
