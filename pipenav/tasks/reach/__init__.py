"""The corner task: bring the tip to a target around the corner. Pure functions over (n, ...) arrays.

Everything here lives in the canonical frame: the robot's frame (rear end of the first link at rest, x along the first
leg) with every turn a left turn. Right turns are mirrored into it, and actions back out of it.
"""
