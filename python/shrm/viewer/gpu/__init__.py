"""The renderer on the GPU: contexts, programs, textures, geometry, maps and filters."""
