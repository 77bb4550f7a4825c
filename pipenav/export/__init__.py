"""Pipes as folders for simulators, printers and people: STL, MJCF, URDF, SDF, drawing, JSON."""
