"""Recorded motions: their file, mirrored and reversed (approach II), followed pose by pose."""
