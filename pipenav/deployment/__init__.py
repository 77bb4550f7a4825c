"""The real arm: mission, control loop, session, telemetry and its replay."""
