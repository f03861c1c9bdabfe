"""Measured materials, read from their own files: MERL, RGL/EPFL, Cornell, CUReT, ALTA.

`load` recognises a file by its content and returns a material like any other.

    material       what all of them are: values, where there are any, and how the rest is filled; start here
    load           which format a file has
    rgl            over tensor_file
    cornell        over text, spectrum (colours), scattered (splines) and resampled (tables)

References for the formats stand in the modules that read them.
"""

from shrm.brdf.measured.load import load, recognised
from shrm.brdf.measured.material import Extrapolate, Measured, MeasurementError

__all__ = ["Extrapolate", "Measured", "MeasurementError", "load", "recognised"]
