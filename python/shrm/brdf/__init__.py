"""BRDF models."""
