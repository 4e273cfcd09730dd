"""Benchmarks: reported by `./dev bench`, asserted nowhere."""
