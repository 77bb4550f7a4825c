"""The traverse task: the whole robot goes through a corner, or a run of them. Pure functions over (n, ...) arrays.

What a policy sees and does lives in the canonical frame, in which every turn is a left turn: right turns are mirrored
on the way in and out, as in `pipenav.tasks.reach`; in a run, the corner that the robot is in says which way. Where the robot
is in the pipe only rewards and verdicts know.
"""
