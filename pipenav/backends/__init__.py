"""The seams that a simulator or an arm implements, how plugins are found, and what they may use."""
