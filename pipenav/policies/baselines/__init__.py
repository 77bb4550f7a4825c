"""Scripted controllers to compare policies with."""
