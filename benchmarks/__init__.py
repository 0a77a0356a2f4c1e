"""Whole workloads, each timed against a baseline in one run: ``python -m benchmarks``."""
