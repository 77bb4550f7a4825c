"""The traverse task in space.

A policy of the plane takes the robot through each corner. In between the robot rolls into the plane of the next corner,
decided from its own sensors alone.
"""
