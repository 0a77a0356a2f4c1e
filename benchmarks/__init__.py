"""Time whole workloads against baselines in the same run: ``python -m benchmarks``."""
