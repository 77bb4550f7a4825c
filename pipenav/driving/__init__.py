"""Driving by hand: what a person asks for, what the robot is told, and who drove each step."""
