"""Scripted controllers to compare a policy with."""
