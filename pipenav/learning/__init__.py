"""PPO on a task: configuration and presets, learner, callback, checkpoint, training folder."""
