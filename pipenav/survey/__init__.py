"""Surveys: which part of a network a robot can inspect, from where, and what stops it."""
