"""For tests, ours and strangers': the laws that every backend keeps, and a backend without physics.

A plugin's test of the whole contract:

    @pytest.mark.parametrize("check", CONTRACT, ids=lambda check: check.__name__)
    def test_contract(check):
        check(Bench("mybackend"))
"""

from pipenav.testing.bench import Bench, Start, starts
from pipenav.testing.contract import CONTRACT
from pipenav.testing.kinematic import KinematicBackend, KinematicOptions

__all__ = ["CONTRACT", "Bench", "KinematicBackend", "KinematicOptions", "Start", "starts"]
