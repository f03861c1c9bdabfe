"""Principal components of transfer matrices, of a whole object or in clusters."""
