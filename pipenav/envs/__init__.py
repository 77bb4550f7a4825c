"""The tasks as other people's environments: Gymnasium, its vector env, Stable-Baselines3."""
