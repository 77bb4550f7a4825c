"""For tests, ours and strangers': the laws that every backend keeps, and a backend without physics.

A plugin's test of the whole contract:

    @pytest.mark.parametrize("check", [*CONTRACT, *VARIATION_LAWS], ids=lambda check: check.__name__)
    def test_contract(check):
        check(Bench("mybackend"))
"""

from pipenav.testing.bench import Bench, Start, starts
from pipenav.testing.contract import CONTRACT
from pipenav.testing.kinematic import KinematicBackend, KinematicOptions
from pipenav.testing.variation import VARIATION_LAWS

__all__ = ["CONTRACT", "VARIATION_LAWS", "Bench", "KinematicBackend", "KinematicOptions", "Start", "starts"]
