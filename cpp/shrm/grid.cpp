// Picture layouts, solid angles, area-exact conversion.
