"""Kinds of drive: flank pairs, belts and chains."""
