"""shrm: frequency-space environment map rendering."""
