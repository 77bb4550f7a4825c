"""Comparison of two simulators, side by side: `pipenav compare-backends`."""
