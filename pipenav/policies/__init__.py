"""Who decides: a trained policy and its file, and what a person may name instead."""
