"""Pictures in and out: the one package that knows OpenImageIO.

Reading gives linear Rec. 709 as (H, W, 3) float32, top row first, or an `ImageError` of one line that
names the file and the fault. What was changed on the way (alpha dropped, sRGB decoded, ...) is said
by an `ImageWarning`. Writing gives a whole file or none: it is written beside and then renamed.

image -> source, holes, stated_layout -> reading; image -> target -> writing; both -> parts; text; tables
"""

from shrm.image_io.image import (
    DEFAULT_MAX_BYTES,
    Image,
    ImageError,
    ImageWarning,
    Metadata,
    Part,
)
from shrm.image_io.parts import read_metadata, read_parts, write_parts
from shrm.image_io.reading import read_image
from shrm.image_io.stated_layout import layout_metadata
from shrm.image_io.tables import table_parts, table_values
from shrm.image_io.text import draw_text
from shrm.image_io.writing import write_image

__all__ = [
    "DEFAULT_MAX_BYTES",
    "Image",
    "ImageError",
    "ImageWarning",
    "Metadata",
    "Part",
    "draw_text",
    "layout_metadata",
    "read_image",
    "read_metadata",
    "read_parts",
    "table_parts",
    "table_values",
    "write_image",
    "write_parts",
]
