"""Search for better settings of a training: many short trainings, of which each tells where to look next."""
