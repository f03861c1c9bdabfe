"""The C++ core's functions as the modules that wrap them see them."""

import numpy as np
import numpy.typing as npt

I32 = npt.NDArray[np.int32]
I64 = npt.NDArray[np.int64]
Bool = npt.NDArray[np.bool_]
F16 = npt.NDArray[np.float16]
F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]

INSTRUCTION_SET: str
CUBE_BORDER: int
ANGULAR_LANES: int

# grid
def rays(*, layout: str, height: int, width: int, positions: F64) -> tuple[F64, F64]: ...
def positions(*, layout: str, height: int, width: int, directions: F64) -> F64: ...
def solid_angles(*, layout: str, height: int, width: int) -> F64: ...
def convert(
    *, pixels: F32, source: str, target: str, height: int, width: int, rotation: F64
) -> tuple[F32, float]: ...

# sh
def analysis(*, pixels: F32, F: int, areas: bool) -> F64: ...
def synthesis(*, coefficients: F64, H: int, W: int) -> F32: ...
def cube_synthesis(*, coefficients: F64, N: int) -> F32: ...

class Analysis:
    def __init__(self, *, H: int, W: int, channels: int, F: int, areas: bool) -> None: ...
    def run(self, pixels: F32, coefficients: F64, /) -> None: ...

class Synthesis:
    def __init__(self, *, H: int, W: int, channels: int, F: int) -> None: ...
    def run(self, coefficients: F64, rings: F32, /) -> None: ...

class CubeSynthesis:
    def __init__(self, *, N: int, channels: int, F: int) -> None: ...
    def run(self, coefficients: F64, rings: F32, /) -> None: ...

def evaluate(*, coefficients: F64, directions: F64) -> F64: ...
def fejer_weights(*, H: int) -> F64: ...

# wigner
def rotate(*, coefficients: F64, R: F64) -> F64: ...

class Rotation:
    def __init__(self, *, F: int, channels: int) -> None: ...
    def run(self, coefficients: F64, R: F64, rotated: F64, /) -> None: ...

def wigner_d(*, m: int, q: int, F: int, alpha: float) -> F64: ...

# measured
def interpolate_angles(
    *, table: npt.NDArray[np.floating], axes: str, square_root: bool, centers: bool, wi: F64, wo: F64
) -> F64: ...
def nearest_angles(
    *, shape: tuple[int, ...], axes: str, square_root: bool, centers: bool, wi: F64, wo: F64
) -> I64: ...

class AdaptiveParameterization:
    def __init__(self, *, theta_i: F64, vndf: F32, values: F32, ndf: F32, sigma: F32) -> None: ...
    def evaluate(self, *, wi: F64, wo: F64) -> F64: ...
    def samples(self, *, wi: F64, wo: F64) -> F64: ...

# brdf_analysis
def legendre(*, F: int, m: int, theta: F64) -> F64: ...
def directions(*, theta_v: F64, gamma: F64, theta_i: F64, arc: F64, share: F64) -> tuple[F64, F64]: ...
def project(
    *,
    rho_hat: F64,
    theta_i: F64,
    weight_theta: F64,
    arc: F64,
    share: F64,
    weight_share: F64,
    L: int,
    Q: int,
) -> tuple[F64, F64]: ...

# reflection_map, radiance
def local_reflection_map(*, light: F64, rho: F64, H: int, W: int) -> F32: ...
def global_from_local(*, local: F32) -> F32: ...
def global_coefficients(*, light: F64, rho: F64) -> F64: ...

class MapCoefficients:
    def __init__(self, *, F: int, P: int, channels: int, zonal: bool) -> None: ...
    def set_material(self, rho: F64, /) -> None: ...
    def run(self, light: F64, coefficients: F64, /) -> None: ...

def add_radiance(
    *,
    rings: F32 | F16,
    cube: bool,
    zonal: bool,
    center: str,
    gamma: F64,
    axes: F64,
    views: F64,
    bilinear: bool,
    radiance: F32,
) -> None: ...
def look_up(*, rings: F32 | F16, cube: bool, zonal: bool, C: F64, views: F64, bilinear: bool) -> F32: ...
def view_map(*, rings: F32 | F16, cube: bool, zonal: bool, direction: F64, pixels: F32) -> None: ...
def explicit_maps(*, rings: F32, cube: bool, T: int) -> F32: ...
def to_half(rings: F32, halves: F16, /) -> None: ...
def largest_magnitude(rings: F32, /) -> float: ...
def cube_directions(*, N: int) -> F64: ...

# angular
def angular_radial(
    *,
    planes: F32,
    subsamples: int,
    profile: F32,
    shift: int,
    scale: float,
    support: float,
    outer: float,
    centers: F64,
) -> F32: ...
def angular_radial_map(
    *,
    planes: F32,
    subsamples: int,
    profile: F32,
    shift: int,
    scale: float,
    support: float,
    outer: float,
    height: int,
    width: int,
    symmetry: bool,
) -> F32: ...
def angular_half_angle(
    *,
    planes: F32,
    subsamples: int,
    profile: F32,
    shift: int,
    scale: float,
    support: float,
    caps: F64,
    normals: F64,
    views: F64,
    share: bool,
) -> F32: ...
def angular_zonal(
    *, planes: F32, subsamples: int, profiles: F32, bands: F64, axes: F64, theta_o: F64
) -> F32: ...
def angular_isotropic(
    *, planes: F32, subsamples: int, envelope: F32, ratio: F32, caps: F64, normals: F64, views: F64
) -> F32: ...

# hierarchical
HIERARCHICAL_BLOCK: int

class Pyramid:
    def __init__(self, pixels: F32, /) -> None: ...
    @property
    def levels(self) -> int: ...

def hierarchical_radial(
    *,
    pyramid: Pyramid,
    profile: F32,
    shift: int,
    scale: float,
    support: float,
    outer: float,
    threshold: float,
    integral: float,
    finest: float,
    centers: F64,
) -> tuple[F32, float]: ...
def hierarchical_zonal(
    *,
    pyramid: Pyramid,
    profiles: F32,
    bands: F64,
    supports: F64,
    threshold: float,
    integral: float,
    finest: float,
    axes: F64,
    theta_o: F64,
) -> tuple[F32, float]: ...
def hierarchical_isotropic(
    *,
    pyramid: Pyramid,
    envelope: F32,
    ratio: F32,
    caps: F64,
    threshold: float,
    integral: float,
    finest: float,
    normals: F64,
    views: F64,
    above: float = ...,
    below: float = ...,
) -> tuple[F32, float]: ...

# directional_basis
def hemisphere_from_square(*, positions: F64) -> F64: ...
def tents(*, directions: F64, M: int) -> tuple[I64, F64]: ...
def evaluate_tents(*, coefficients: F64, directions: F64, M: int) -> F64: ...
def accumulate_tents(*, values: F64, directions: F64, M: int) -> F64: ...

# transfer_products
def sum_over_visible(*, rays: F32, harmonics: F32, visible: Bool, rotations: F32 | None = None) -> F32: ...

# transfer_lighting
class TransferSurface:
    def __init__(self, *, vertices: F32, frames: F32) -> None: ...

def light_tents(
    *, surface: TransferSurface, matrices: F32 | F16, light: F32, eye: F32, distant: bool, radiance: F32
) -> None: ...
def light_fixed_tents(
    *, surface: TransferSurface, coefficients: F32, eye: F32, distant: bool, radiance: F32
) -> None: ...
def light_rows(*, rows: F32 | F16, light: F32, radiance: F32) -> None: ...

class CompressedTransfer:
    def __init__(self, *, weights: F32 | F16, components: F32, clusters: I32 | None, K: int) -> None: ...
    def run(
        self, *, surface: TransferSurface, light: F32, eye: F32, distant: bool, radiance: F32
    ) -> None: ...

def light_projected(
    *,
    surface: TransferSurface,
    samples: F32,
    parabolic: bool,
    rotations: F32 | None,
    transfer: F32 | F16 | None,
    light: F32,
    eye: F32,
    distant: bool,
    radiance: F32,
) -> None: ...
def light_convolved(
    *,
    surface: TransferSurface,
    kernel: F32,
    about_normal: bool,
    transfer: F32 | F16 | None,
    light: F32,
    eye: F32,
    distant: bool,
    radiance: F32,
) -> None: ...
