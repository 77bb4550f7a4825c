"""Tasks: observation, action, reward and outcome over n robots, one folder for each task."""
