"""Module that policy files of pipenav 0.1 name for the learning rate; Stable-Baselines3's `PPO.load` looks here."""

from pipenav.learning.schedule import LearningRate

__all__ = ["LearningRate"]
