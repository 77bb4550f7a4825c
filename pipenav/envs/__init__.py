"""Tasks as environments of Gymnasium and Stable-Baselines3."""

from typing import TYPE_CHECKING, Any

from pipenav.envs.gymnasium_env import CornerEnv, TraverseEnv
from pipenav.envs.vector_env import CornerVectorEnv, TraverseVectorEnv

if TYPE_CHECKING:
    from pipenav.envs.sb3_env import TaskVecEnv

__all__ = ["CornerEnv", "CornerVectorEnv", "TaskVecEnv", "TraverseEnv", "TraverseVectorEnv"]


def __getattr__(name: str) -> Any:
    """Import `TaskVecEnv` when it is first used: Stable-Baselines3 takes seconds to import."""
    if name == "TaskVecEnv":
        from pipenav.envs.sb3_env import TaskVecEnv

        return TaskVecEnv
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
