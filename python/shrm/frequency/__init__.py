"""Prefiltering in frequency space [RH02]: analysis, orders, maps, files, relighting."""
