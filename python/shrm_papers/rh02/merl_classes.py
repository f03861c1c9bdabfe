"""Classes of the materials of the MERL database, by their names."""

from __future__ import annotations

from collections.abc import Mapping

CLASSES: Mapping[str, tuple[str, ...]] = {
    "fabric, felt": (
        *("beige-fabric", "black-fabric", "blue-fabric", "dark-specular-fabric", "green-fabric"),
        *("light-brown-fabric", "pink-fabric", "pink-fabric2", "pink-felt", "red-fabric", "red-fabric2"),
        *("white-fabric", "white-fabric2"),
    ),
    "rubber, latex, foam": (
        *("blue-rubber", "green-latex", "neoprene-rubber", "polyurethane-foam", "pure-rubber"),
        "violet-rubber",
    ),
    "paint": (
        *("dark-blue-paint", "dark-red-paint", "light-red-paint", "orange-paint", "purple-paint"),
        *("white-paint", "yellow-paint"),
    ),
    "metallic paint": (
        *("blue-metallic-paint", "blue-metallic-paint2", "color-changing-paint1", "color-changing-paint2"),
        *("color-changing-paint3", "gold-metallic-paint", "gold-metallic-paint2", "gold-metallic-paint3"),
        *("gold-paint", "green-metallic-paint", "green-metallic-paint2", "pearl-paint", "red-metallic-paint"),
        *("silver-metallic-paint", "silver-metallic-paint2", "silver-paint", "two-layer-gold"),
        "two-layer-silver",
    ),
    "plastic": (
        *("black-soft-plastic", "blue-acrylic", "delrin", "gray-plastic", "green-acrylic", "green-plastic"),
        *("maroon-plastic", "nylon", "pink-plastic", "polyethylene", "pvc", "red-plastic"),
        *("red-specular-plastic", "teflon", "violet-acrylic", "white-acrylic", "white-diffuse-bball"),
        *("yellow-matte-plastic", "yellow-plastic"),
    ),
    "phenolic": (
        *("black-phenolic", "red-phenolic", "specular-black-phenolic", "specular-blue-phenolic"),
        *("specular-green-phenolic", "specular-maroon-phenolic", "specular-orange-phenolic"),
        *("specular-red-phenolic", "specular-violet-phenolic", "specular-white-phenolic"),
        *("specular-yellow-phenolic", "yellow-phenolic"),
    ),
    "wood": (
        *("cherry-235", "colonial-maple-223", "fruitwood-241", "ipswich-pine-221", "natural-209"),
        *("pickled-oak-260", "special-walnut-224"),
    ),
    "stone, ceramic": (
        *("alumina-oxide", "aventurnine", "black-obsidian", "pink-jasper", "silicon-nitrade"),
        "white-marble",
    ),
    "metal, ore": (
        *("alum-bronze", "aluminium", "black-oxidized-steel", "brass", "chrome", "chrome-steel"),
        *("grease-covered-steel", "hematite", "nickel", "ss440", "steel", "tungsten-carbide"),
    ),
}
"""The 100 names by class, classes from matt to mirror-like."""


def class_of(name: str) -> str:
    """Return the class of a material, or "" if its name is not MERL's."""
    return next((label for label, names in CLASSES.items() if name in names), "")
