"""What a robot is asked to do: observation, action, reward, outcome over n robots, one folder a task."""
