"""What goes wrong on a real arm: ranges, and a backend that errs by them (the TOML files stay here)."""
