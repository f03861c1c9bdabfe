"""Oracles, inputs, meshes and the driver of the window, which tests share."""
