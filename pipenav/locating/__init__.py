"""Approach I: the robot finds a target around the corner from its own laser."""
