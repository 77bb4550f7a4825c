"""What a pipe is: one corner or a route of several, its walls, solids, named sets and JSON keys."""
