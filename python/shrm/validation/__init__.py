"""Checks at the door, with one form of refusal: NAME must be WHAT, got WHAT IT WAS.

A wrong kind of thing is a TypeError, a wrong value or shape a ValueError. Functions called by what they
return (`number`, `indices`, ...) return the argument in that form; those called `require_...` only check.

    number    positive    fraction    whole_number    number_or_rgb          numbers
    flag    string    one_of    picture_shape    require_instance         other single values
    real_array    float32_array    stored_array    indices                   arrays that are converted
    unit_vectors    rotation                                                 the same, of directions
    require_array    require_stored    require_shape    require_finite       arrays that are taken as they are
    require_rotations
"""

from shrm.validation.arrays import (
    Shape,
    StoredArray,
    float32_array,
    indices,
    real_array,
    require_array,
    require_finite,
    require_rotations,
    require_shape,
    require_stored,
    rotation,
    stored_array,
    unit_vectors,
)
from shrm.validation.values import (
    RGB,
    flag,
    fraction,
    number,
    number_or_rgb,
    one_of,
    picture_shape,
    positive,
    require_instance,
    string,
    whole_number,
)

__all__ = [
    "RGB",
    "Shape",
    "StoredArray",
    "flag",
    "float32_array",
    "fraction",
    "indices",
    "number",
    "number_or_rgb",
    "one_of",
    "picture_shape",
    "positive",
    "real_array",
    "require_array",
    "require_finite",
    "require_instance",
    "require_rotations",
    "require_shape",
    "require_stored",
    "rotation",
    "stored_array",
    "string",
    "unit_vectors",
    "whole_number",
]
