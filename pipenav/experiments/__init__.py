"""The thesis's experiments (a)-(f): definitions as TOML, the runner, and the report that sets them beside ours."""
