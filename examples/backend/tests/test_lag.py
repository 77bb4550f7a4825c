"""The whole contract over the installed plugin, found by its name as the command line finds it."""

from collections.abc import Callable

import pytest

from pipenav.backends import load_backend
from pipenav.errors import PipenavError
from pipenav.robots import load_robot
from pipenav.testing import ALL_LAWS, Bench


@pytest.mark.parametrize("robot", ["basic", "real-setup"])
@pytest.mark.parametrize("law", ALL_LAWS, ids=lambda law: law.__name__)
def test_contract(law: Callable[[Bench], None], robot: str) -> None:
    law(Bench("lag", load_robot(robot)))


def test_a_robot_on_wheels_is_refused() -> None:
    kind = load_backend("lag")
    with pytest.raises(PipenavError, match="knows no wheels"):
        kind(load_robot("pirate"), 1, kind.Options())
