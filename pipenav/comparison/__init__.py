"""Two simulators side by side: `pipenav compare-backends`."""
