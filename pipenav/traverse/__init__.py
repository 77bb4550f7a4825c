"""The traverse task: the whole robot goes from the first leg to the second. Pure functions over (n, ...) arrays.

What a policy sees and does lives in the canonical frame, in which every turn is a left turn: right turns are mirrored
on the way in and out, as in `pipenav.task`. Where the robot is in the pipe only rewards and verdicts know.
"""
