"""Tests by room (`unit`), of physics, hard cases, the project; `support` is what they share."""
