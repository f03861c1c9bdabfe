"""Rays from the vertices of a mesh: directions, hits, visibility and bounces, kept on disk."""
