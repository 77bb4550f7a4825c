"""For tests of backends, pipenav's own and others': the laws that every backend keeps, and a simulator without physics.

A plugin tests itself against the whole contract in three lines:

    @pytest.mark.parametrize("law", ALL_LAWS, ids=lambda law: law.__name__)
    def test_contract(law):
        law(Bench("mybackend"))

`Bench` takes the name of an installed backend or a class, and if need be another robot, another number of robots or
settings of the backend. A law raises AssertionError, in words, where the backend breaks it. Laws about abilities that a
backend lacks hold trivially. A simulator that moves robots in space keeps `SPACE_LAWS` too, on a `SpaceBench`.
"""

from pipenav.testing.bench import Bench, Start, starts
from pipenav.testing.contract import ALL_LAWS, CONTRACT
from pipenav.testing.haulage import Haulage
from pipenav.testing.kinematic import KinematicBackend, KinematicOptions
from pipenav.testing.kinematic_space import KinematicSpace
from pipenav.testing.laws import Law
from pipenav.testing.pulling import PULL_LAWS
from pipenav.testing.space_bench import SpaceBench, SpaceStart, clamped, space_starts
from pipenav.testing.space_laws import SPACE_LAWS, SpaceLaw
from pipenav.testing.variation import VARIATION_LAWS

__all__ = [
    "ALL_LAWS",
    "CONTRACT",
    "PULL_LAWS",
    "SPACE_LAWS",
    "VARIATION_LAWS",
    "Bench",
    "Haulage",
    "KinematicBackend",
    "KinematicOptions",
    "KinematicSpace",
    "Law",
    "SpaceBench",
    "SpaceLaw",
    "SpaceStart",
    "Start",
    "clamped",
    "space_starts",
    "starts",
]
