"""Integrators: sums over the light, which use nothing of frequency space and so can judge it."""
