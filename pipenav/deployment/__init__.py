"""Missions of the real arm: plan, control loop, session, telemetry and its replay."""
