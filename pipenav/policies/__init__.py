"""Controllers: trained policies and their files, and baselines to compare them with."""

from pipenav.policies.controller import AnyController, Controller, PrivilegedController
from pipenav.policies.header import PolicyHeader
from pipenav.policies.named import BASELINES, PolicyController, RandomController, open_controller
from pipenav.policies.policy import Policy, PolicyFileError, load_policy, policy_names, save_policy

__all__ = [
    "BASELINES",
    "AnyController",
    "Controller",
    "Policy",
    "PolicyController",
    "PolicyFileError",
    "PolicyHeader",
    "PrivilegedController",
    "RandomController",
    "load_policy",
    "open_controller",
    "policy_names",
    "save_policy",
]
