"""Lighting an object at run time: [LK03]'s method, those before it and special cases, with one call.

    Tents        four rows of a matrix for each vertex                            [LK03 eq. 9]
    Compressed   the same from principal components, without making the matrices  [LK03 eq. 13]
    Projection   the row of any material times rotated, transferred light         [KSS02]
    Convolution  the same for lobes about the reflection or the normal            [SKS02]
    Diffuse      one product for each vertex                                      [SKS02]
    FixedLight, FixedView   what remains of tents if one of the two stays         [LK03 section 3.3]

`Lighting.radiance` takes the light's coefficients in global coordinates, order n, and an eye. Without shadows
`Projection` and `Convolution` need frames alone.
"""

from shrm.transfer.lighting.earlier import Convolution, Diffuse, Projection, parabolic_map, zonal_kernel
from shrm.transfer.lighting.surface import Lighting
from shrm.transfer.lighting.tents import Compressed, FixedLight, FixedView, Tents

__all__ = [
    "Compressed",
    "Convolution",
    "Diffuse",
    "FixedLight",
    "FixedView",
    "Lighting",
    "Projection",
    "Tents",
    "parabolic_map",
    "zonal_kernel",
]
