"""The tables and figures of [RH02], made again with the paper's own figures beside them.

Each module of this package makes one result: `NAME`, and `make(settings) -> Result`.

References
----------
[RH02] R. Ramamoorthi, P. Hanrahan. Frequency Space Environment Map Rendering. ACM TOG 21(3), 2002.
"""
