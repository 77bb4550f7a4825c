"""Certificates: whether a robot passes a pipe by geometry alone, with a proof or a motion that shows it."""
