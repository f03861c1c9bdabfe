"""Transfer matrices: the product of BRDF, rotation and transfer, and how accurate its orders make it."""
