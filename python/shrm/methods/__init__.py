"""The cost of prefiltering by each method, and the cheapest."""
