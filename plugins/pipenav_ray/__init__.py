"""Ray as a place where jobs run: all cores of a cluster, or of this machine."""

import os

# Ray reads these once, when it is imported or when its processes start.
os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # nobody is told that pipenav is used
os.environ.setdefault("RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER", "0")  # with 1 a cluster on the loopback takes no nodes
os.environ.setdefault("RAY_DISABLE_IMPORT_WARNING", "1")
os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")

from pipenav_ray.place import RayPlace

__all__ = ["RayPlace"]
