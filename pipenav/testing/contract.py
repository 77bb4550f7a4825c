"""The contract of every backend: its laws in one list."""

from __future__ import annotations

from pipenav.testing import motion, readings, repeatability
from pipenav.testing.laws import Law
from pipenav.testing.pulling import PULL_LAWS
from pipenav.testing.variation import VARIATION_LAWS

CONTRACT: list[Law] = [
    repeatability.check_same_seed_same_trajectory,
    repeatability.check_reset_forgets_the_past,
    repeatability.check_reset_touches_only_named_robots,
    repeatability.check_no_shared_memory,
    repeatability.check_closes_twice,
    readings.check_readings_finite_and_shaped,
    readings.check_reset_reads_what_read_reads,
    readings.check_nothing_constant,
    readings.check_resets_differ,
    readings.check_time_counts,
    readings.check_tip_and_ranges_fit_the_pose,
    readings.check_contact_force_is_the_largest_of_the_links,
    motion.check_limits_respected,
    motion.check_commands_move_the_right_way,
    motion.check_left_and_right_mirror,
    motion.check_too_many_walls_refused,
]
"""Laws of every backend."""

ALL_LAWS: list[Law] = [*CONTRACT, *VARIATION_LAWS, *PULL_LAWS]
"""Laws of every backend, and those of simulators that can vary their robots or let forces pull on them."""
