"""The traverse task: the whole robot goes through a corner or a route. Pure functions over (n, ...) arrays.

Observations and actions of a policy live in the canonical frame, in which every turn is a left turn: right turns are
mirrored on the way in and out, as in `pipenav.tasks.reach`. In a route, the turn of the corner that the robot is in
counts. Only rewards and outcomes know where the robot is in the pipe.
"""
