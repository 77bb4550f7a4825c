"""The PyBullet backend: many robots in a few worlds, divided among one process per core."""

from pipenav_pybullet.backend import PybulletBackend

__all__ = ["PybulletBackend"]
