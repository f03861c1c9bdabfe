"""The C++ core's functions as the modules that wrap them see them."""

import numpy as np
import numpy.typing as npt

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
def evaluate(*, coefficients: F64, directions: F64) -> F64: ...
def evaluate_float(*, coefficients: F64, directions: F64) -> F32: ...
def fejer_weights(*, H: int) -> F64: ...

# wigner
def rotate(*, coefficients: F64, R: F64) -> F64: ...
def wigner_d(*, m: int, q: int, F: int, alpha: float) -> F64: ...

# brdf_analysis
def legendre(*, F: int, m: int, theta: F64) -> F64: ...
def project(
    *, rho_hat: F64, theta_i: F64, weight_theta: F64, phi: F64, weight_phi: F64, L: int, Q: int
) -> tuple[F64, F64]: ...

# reflection_map, radiance
def local_reflection_map(*, light: F64, rho: F64, H: int, W: int) -> F32: ...
def global_from_local(*, local: F32) -> F32: ...
def global_coefficients(*, light: F64, rho: F64) -> F64: ...
def add_radiance(
    *,
    rings: F32,
    cube: bool,
    zonal: bool,
    centre: str,
    gamma: F64,
    axes: F64,
    views: F64,
    bilinear: bool,
    radiance: F32,
) -> None: ...
def view_map(*, rings: F32, cube: bool, zonal: bool, direction: F64) -> F32: ...
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
    centres: F64,
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
) -> F32: ...
def angular_zonal(
    *, planes: F32, subsamples: int, profiles: F32, bands: F64, axes: F64, theta_o: F64
) -> F32: ...
def angular_isotropic(
    *, planes: F32, subsamples: int, envelope: F32, ratio: F32, caps: F64, normals: F64, views: F64
) -> F32: ...
