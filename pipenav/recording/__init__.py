"""One episode of one robot, recorded and shown: picture, film, live window."""
