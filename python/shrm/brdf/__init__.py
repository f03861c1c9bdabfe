"""BRDF models: materials that reflect an environment.

A material (`BRDF`) is a sum of lobes, each a transfer function about its own central direction; it
can be evaluated on arrays of directions, added to others and scaled. Adding a model is writing one
function of (wi, wo).

    lobe          transfer functions about a center; start here
    material      their sums: `BRDF`, what all models are
    value         what makes them equal, hashable and picklable
    half_vector   the half vector of a pair of directions, for microfacet models
    cosine_power  powers of cosines that keep their digits, for sharp lobes
    peaks         the widths of peaks too narrow for ordinary nodes
    parameters    bounds on parameters, and how names write them
    angle_table   regular tables over three angles, for measurements
    models/       one file each, and `function`, from any Python function
        lambert                                                    about the normal
        phong                                                      about the reflection
        microfacet    lafortune    ggx    beckmann    tabulated    about the lobe center
        abc_model    sgd                                           the same: those of published fits
        miller_heidrich                                            about normal and reflection
        kajiya_kay    banks                                        about the tangent
        ashikhmin_shirley    anisotropic_ggx                       anisotropic: for matrix radiance transfer
    fits/         published fits to measured materials, by name
    measured/     from files of measurements
    parse         materials from text, for the command line
    albedo        directional albedo by quadrature
"""

from shrm.brdf import fits
from shrm.brdf.albedo import directional_albedo
from shrm.brdf.lobe import AnisotropicLobe, Center, IsotropicLobe, Lobe, RadialLobe, ZonalLobe
from shrm.brdf.material import BRDF, Material, require_brdf
from shrm.brdf.measured import Measured, MeasurementError, load
from shrm.brdf.models.abc_model import ABC
from shrm.brdf.models.anisotropic_ggx import AnisotropicGGX
from shrm.brdf.models.ashikhmin_shirley import AshikhminShirley
from shrm.brdf.models.banks import Banks
from shrm.brdf.models.beckmann import Beckmann
from shrm.brdf.models.function import from_function
from shrm.brdf.models.ggx import GGX
from shrm.brdf.models.kajiya_kay import KajiyaKay
from shrm.brdf.models.lafortune import Lafortune
from shrm.brdf.models.lambert import Lambert
from shrm.brdf.models.microfacet import Microfacet
from shrm.brdf.models.miller_heidrich import MillerHeidrich
from shrm.brdf.models.phong import Phong
from shrm.brdf.models.sgd import SGD
from shrm.brdf.models.tabulated import Tabulated
from shrm.brdf.parse import filled, parse

__all__ = [
    "ABC",
    "BRDF",
    "GGX",
    "SGD",
    "AnisotropicGGX",
    "AnisotropicLobe",
    "AshikhminShirley",
    "Banks",
    "Beckmann",
    "Center",
    "IsotropicLobe",
    "KajiyaKay",
    "Lafortune",
    "Lambert",
    "Lobe",
    "Material",
    "Measured",
    "MeasurementError",
    "Microfacet",
    "MillerHeidrich",
    "Phong",
    "RadialLobe",
    "Tabulated",
    "ZonalLobe",
    "directional_albedo",
    "filled",
    "fits",
    "from_function",
    "load",
    "parse",
    "require_brdf",
]
