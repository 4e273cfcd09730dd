"""Condensation of the elements of a body by a multifrontal method: dissection, fronts, recovery."""
