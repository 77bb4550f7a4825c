"""The corner task as a Gymnasium environment, `pipenav/Corner-v0`: thin adapters over `ReachBatch`.

Importing this module registers it: `gymnasium.make("pipenav.env:pipenav/Corner-v0")` does both at once.
"""

from __future__ import annotations

import gymnasium

from pipenav.envs.gymnasium_env import CornerEnv, CornerVectorEnv

__all__ = ["ENV_ID", "CornerEnv", "CornerVectorEnv"]

ENV_ID = "pipenav/Corner-v0"


gymnasium.register(ENV_ID, entry_point=f"{__name__}:CornerEnv", vector_entry_point=f"{__name__}:CornerVectorEnv")
