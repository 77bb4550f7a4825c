"""Processes of pipenav: what they may import, how they are started, how they end, and what they leave behind."""
