"""What tests share: oracles, inputs, meshes, the driver of the window."""
