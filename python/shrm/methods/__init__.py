"""What prefiltering costs by each method, and which is the cheapest."""
