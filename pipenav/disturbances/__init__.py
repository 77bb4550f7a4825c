"""Faults of a real arm, as ranges in TOML files, and a simulator that shows them."""
