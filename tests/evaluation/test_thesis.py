"""The thesis's figures."""

from __future__ import annotations

from pipenav.evaluation.thesis import ANGLES_DEG, is_thesis_set, thesis_best, thesis_rows


def test_thesis_tables() -> None:
    assert len(thesis_rows()) == 18
    assert thesis_best("torque") == {120: 100, 110: 99, 100: 98, 90: 89}
    assert thesis_best("position") == {120: 99, 110: 98, 100: 98, 90: 92}
    assert thesis_best("position", "high-fidelity") == {120: 98, 110: 95, 100: 98, 90: 78}
    assert thesis_best("position", "high-fidelity", "rear") == dict.fromkeys((120.0, 110.0, 100.0, 90.0), 100)
    assert thesis_best("torque", "real-setup") == {}
    assert is_thesis_set(ANGLES_DEG)
    assert len(ANGLES_DEG) == 15
