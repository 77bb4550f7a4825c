"""Train, evaluate and deploy controllers that take a pipe-inspection robot around sharp pipe corners."""

__version__ = "0.1.0"
