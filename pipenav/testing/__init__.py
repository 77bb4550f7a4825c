"""For tests of backends, pipenav's own and others': the laws that every backend keeps, and a simulator without physics.

A plugin tests itself against the whole contract in three lines:

    @pytest.mark.parametrize("law", ALL_LAWS, ids=lambda law: law.__name__)
    def test_contract(law):
        law(Bench("mybackend"))

`Bench` takes the name of an installed backend or a class, and if need be another robot, another number of robots or
settings of the backend. A law raises AssertionError, in words, where the backend breaks it. Laws about abilities that a
backend lacks hold trivially.
"""

from pipenav.testing.bench import Bench, Start, starts
from pipenav.testing.contract import ALL_LAWS, CONTRACT
from pipenav.testing.kinematic import KinematicBackend, KinematicOptions
from pipenav.testing.laws import Law
from pipenav.testing.variation import VARIATION_LAWS

__all__ = [
    "ALL_LAWS",
    "CONTRACT",
    "VARIATION_LAWS",
    "Bench",
    "KinematicBackend",
    "KinematicOptions",
    "Law",
    "Start",
    "starts",
]
