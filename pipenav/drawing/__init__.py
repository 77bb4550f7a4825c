"""Drawings of pipes and robots: one style, dimensions, corner, route, scene from above."""
