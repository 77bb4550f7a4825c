"""The MuJoCo backend: many robots in one `mujoco.batch.Batch`, walls as mocap bodies."""

from pipenav_mujoco.backend import MujocoBackend

__all__ = ["MujocoBackend"]
