"""Matrix radiance transfer: objects that shadow and light themselves, under light that turns [LK03].

References
----------
[LK03]  J. Lehtinen, J. Kautz. Matrix Radiance Transfer. I3D 2003.
"""
