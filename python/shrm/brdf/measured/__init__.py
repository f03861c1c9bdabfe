"""Measured materials, read from their own files: MERL, RGL/EPFL, Cornell, CUReT, ALTA.

`load` recognises a file by its content and returns a material like any other.

    measured       what all of them are: values, where there are any, and how the rest is filled; start here
    load           which format a file has
    rgl            over tensor_file and spectrum (colors)
    merl           its table
    cornell        over text, spectrum, scattered (splines) and resampled (tables)
    alta           the same of fewer angles
    curet          over koenderink_van_doorn, their basis

References for the formats stand in the modules that read them.
"""

from shrm.brdf.measured.load import load, recognised
from shrm.brdf.measured.measured import Extrapolate, Measured, MeasurementError

__all__ = ["Extrapolate", "Measured", "MeasurementError", "load", "recognised"]
