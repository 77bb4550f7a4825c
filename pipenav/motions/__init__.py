"""Recorded motions: their file, their mirror image in reverse (approach II), and robots that follow them."""
