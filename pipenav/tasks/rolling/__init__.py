"""The traverse task in space.

A policy of the plane takes the robot through each corner; in between it rolls into the next one's plane, decided from
its own sensors alone.
"""
