"""Tests by room (`unit`), of physics, hard cases and the project; `support` has shared modules."""
