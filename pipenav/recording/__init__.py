"""Episodes of a single robot, recorded and shown: picture, film, live window."""
