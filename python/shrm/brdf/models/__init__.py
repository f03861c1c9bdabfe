"""BRDF models: each file is one model, or one way to make a material from a function or a table."""
