"""Slow answers that can be trusted: numpy and scipy in float64, never importing shrm.

Conventions are those of cpp/shrm/core.hpp: z up, pixel (i, j) of an H x W picture covers theta in
[i, i+1] pi/H and is centered on phi = pi - 2 pi (j + 1/2) / W; real orthonormal spherical harmonics at index
l(l+1)+m with the Condon-Shortley phase kept. A picture is piecewise constant: an oracle integrates over the
areas of its texels.

Models and measures follow Ramamoorthi & Hanrahan, "Frequency Space Environment Map Rendering", ACM TOG
21(3), 2002 ([RH02]); Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007
([WMLT07]); Lafortune et al., "Non-Linear Approximation of Reflectance Functions", SIGGRAPH 1997; Kajiya &
Kay, "Rendering Fur with Three Dimensional Textures", SIGGRAPH 1989; Kautz et al., "A Unified Approach to
Prefiltered Environment Maps", EGWR 2000 ([KVHS00]); Ashikhmin & Shirley, "An Anisotropic Phong BRDF Model",
JGT 5(2), 2000 ([AS00]).
"""

from collections.abc import Callable
from math import comb

import numpy as np
import numpy.typing as npt
from scipy import special
from scipy.stats import qmc

Array = npt.NDArray[np.float64]
Transfer = Callable[[Array, Array], Array]

# ---- Pictures


def texel_nodes(H: int, W: int, subsamples: int = 1) -> tuple[Array, Array]:
    """Nodes (H, W, k * k, 3) and solid angles (H, W, k * k); each texel's sum to its exact area.

    A product Gauss rule in (theta, phi) with sin(theta) in the weights, scaled to the area.
    """
    x, w = np.polynomial.legendre.leggauss(subsamples)
    theta = np.pi / H * (np.arange(H)[:, None] + (1 + x) / 2)
    phi = np.pi - 2 * np.pi / W * (np.arange(W)[:, None] + (1 + x) / 2)
    edge = np.cos(np.pi / H * np.arange(H + 1))
    ring = w * np.sin(theta)
    ring *= ((edge[:-1] - edge[1:]) * 2 * np.pi / W / ring.sum(axis=1))[:, None]
    t, p = theta[:, None, :, None], phi[None, :, None, :]
    nodes = np.stack(
        np.broadcast_arrays(np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)), axis=-1
    ).reshape(H, W, subsamples**2, 3)
    weights = (ring[:, None, :, None] * (w / 2)[None, None, None, :]) * np.ones((1, W, 1, 1))
    return nodes, weights.reshape(H, W, subsamples**2)


def solid_angles(H: int, W: int) -> Array:
    """Solid angles of texels, (H, W)."""
    edge = np.cos(np.pi / H * np.arange(H + 1))
    return np.repeat((edge[:-1] - edge[1:])[:, None] * 2 * np.pi / W, W, axis=1)


def directions(H: int, W: int) -> Array:
    """Directions of texel centers, (H, W, 3)."""
    return texel_nodes(H, W)[0][:, :, 0]


# ---- Spherical harmonics


def real_harmonics(F: int, w: Array) -> Array:
    """The real basis at unit directions (n, 3), to degree F: (n, (F+1)^2)."""
    theta, phi = np.arccos(np.clip(w[:, 2], -1, 1)), np.arctan2(w[:, 1], w[:, 0])
    Y = np.empty((len(w), (F + 1) ** 2))
    for l in range(F + 1):
        for m in range(l + 1):
            y = special.sph_harm_y(l, m, theta, phi)
            if m == 0:
                Y[:, l * (l + 1)] = y.real
            else:
                Y[:, l * (l + 1) + m] = np.sqrt(2) * y.real
                Y[:, l * (l + 1) - m] = np.sqrt(2) * y.imag
    return Y


def coefficients(pixels: npt.ArrayLike, F: int, subsamples: int = 4) -> Array:
    """Real coefficients ((F+1)^2, C) of a piecewise constant picture (H, W, C)."""
    pixels = np.asarray(pixels, dtype=np.float64)
    H, W, C = pixels.shape
    nodes, weights = texel_nodes(H, W, subsamples)
    result = np.zeros(((F + 1) ** 2, C))
    for i in range(H):
        light = (weights[i, :, :, None] * pixels[i, :, None, :]).reshape(-1, C)
        result += real_harmonics(F, nodes[i].reshape(-1, 3)).T @ light
    return result


def small_d(l: int, m: int, q: int, alpha: npt.ArrayLike) -> Array:
    """d^l_{mq}(alpha) of the z-y-z convention through a Jacobi polynomial; d^1_{10} = -sin/sqrt2."""
    alpha = np.asarray(alpha, dtype=np.float64)
    odd = 1 - 2 * ((m - q) % 2)
    k, a, sign = min((l + q, m - q, odd), (l - q, q - m, 1), (l + m, q - m, 1), (l - m, m - q, odd))
    b = 2 * (l - k) - a
    norm = np.sqrt(comb(2 * l - k, k + a) / comb(k + b, b))
    half = np.sin(alpha / 2) ** a * np.cos(alpha / 2) ** b
    return np.asarray(sign * norm * half * special.eval_jacobi(k, a, b, np.cos(alpha)))


def complex_from_real(real: Array, F: int) -> Array:
    """Coefficients L_lm of a real function from its real-basis coefficients, same index."""
    result = np.zeros(real.shape, dtype=np.complex128)
    for l in range(F + 1):
        c = l * (l + 1)
        result[c] = real[c]
        for m in range(1, l + 1):
            result[c + m] = (real[c + m] - 1j * real[c - m]) / np.sqrt(2)
            result[c - m] = (-1) ** m * np.conj(result[c + m])
    return result


def euler_zyz(R: Array) -> tuple[float, float, float]:
    """Angles with R = R_z(a) R_y(b) R_z(c)."""
    b = np.arctan2(np.hypot(R[0, 2], R[1, 2]), R[2, 2])
    if np.hypot(R[0, 2], R[1, 2]) < 1e-12:
        return float(np.arctan2(-R[0, 1], R[1, 1])), float(b), 0.0
    return float(np.arctan2(R[1, 2], R[0, 2])), float(b), float(np.arctan2(R[2, 1], -R[2, 0]))


def rotated_coefficients(real: Array, R: Array) -> Array:
    """Real coefficients ((F+1)^2, C) of f(R^T w) from those of f(w)."""
    F = int(np.sqrt(len(real))) - 1
    a, b, c = euler_zyz(R)
    f = complex_from_real(real, F)
    result = np.zeros_like(real)
    for l in range(F + 1):
        m = np.arange(-l, l + 1)
        d = np.array([[small_d(l, row, col, b) for col in m] for row in m])
        g = np.exp(-1j * m * a)[:, None] * d * np.exp(-1j * m * c) @ f[l * l : (l + 1) ** 2]
        center = l * (l + 1)
        result[center] = g[l].real
        for k in range(1, l + 1):
            result[center + k] = np.sqrt(2) * g[l + k].real
            result[center - k] = -np.sqrt(2) * g[l + k].imag
    return result


# ---- Frames


def rotations(u: Array) -> Array:
    """Uniform rotations (n, 3, 3) from uniform numbers (n, 3) in [0, 1], by unit quaternions."""
    s, c = np.sqrt(1 - u[:, 0]), np.sqrt(u[:, 0])
    x, y = s * np.sin(2 * np.pi * u[:, 1]), s * np.cos(2 * np.pi * u[:, 1])
    z, w = c * np.sin(2 * np.pi * u[:, 2]), c * np.cos(2 * np.pi * u[:, 2])
    R = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return np.ascontiguousarray(R.transpose(2, 0, 1))


def _placed(R: Array, cosine: Array) -> tuple[Array, Array]:
    """The z axes of frames, and directions at that cosine to them in the frames' x-z planes."""
    sine = np.sqrt(np.maximum(0, 1 - cosine**2))
    return R[:, :, 2], sine[:, None] * R[:, :, 0] + cosine[:, None] * R[:, :, 2]


def random_views(n: int, seed: int) -> tuple[Array, Array]:
    """Normals and views (n, 3): frames uniform, cos^2(theta_v) uniform in [0, 1], low discrepancy."""
    u = qmc.Halton(d=4, rng=np.random.default_rng(seed)).random(n)
    return _placed(rotations(u[:, :3]), np.sqrt(u[:, 3]))


def random_hairs(n: int, seed: int) -> tuple[Array, Array, Array]:
    """Tangents, normals square to them, and views uniform on the sphere, each (n, 3)."""
    u = qmc.Halton(d=4, rng=np.random.default_rng(seed)).random(n)
    R = rotations(u[:, :3])
    tangents, views = _placed(R, 2 * u[:, 3] - 1)
    return tangents, np.ascontiguousarray(R[:, :, 1]), views


def important_views(pixels: npt.ArrayLike, n: int, seed: int) -> tuple[Array, Array, Array]:
    """Normals and views (n, 3) for the means of `random_views`, with weights (n,), where much is reflected.

    Radiance has long tails: towards grazing views, and where the reflection meets the sun. A third of the
    views have cos^2(theta_v) uniform, a third cos(theta_v), a third its root; half the reflections are
    uniform and half follow the squared radiance of the picture, blurred to 16 x 32 texels. Weights are one
    over the mixtures' densities.
    """
    u = qmc.Halton(d=6, rng=np.random.default_rng(seed)).random(n)
    square = u[:, 1] ** np.array([1, 2, 4])[np.minimum(3 * u[:, 0], 2).astype(int)]
    density = (1 + 0.5 * square**-0.5 + 0.25 * square**-0.75) / 3
    pixels = np.asarray(pixels, dtype=np.float64)
    H, W, _ = pixels.shape
    energy = (
        (np.sum(pixels**2, axis=2) * solid_angles(H, W)).reshape(16, H // 16, 32, W // 32).sum(axis=(1, 3))
    )
    share = (0.5 * solid_angles(16, 32) / (4 * np.pi) + 0.5 * energy / energy.sum()).ravel()
    cell = np.minimum(np.searchsorted(np.cumsum(share), u[:, 2]), 511)
    edge = np.cos(np.pi * np.arange(17) / 16)
    row, column = cell // 32, cell % 32
    z = edge[row] + u[:, 3] * (edge[row + 1] - edge[row])
    phi = np.pi - 2 * np.pi * (column + u[:, 4]) / 32
    sine = np.sqrt(1 - z**2)
    reflection = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=1)
    density *= share[cell] / solid_angles(16, 32).ravel()[cell] * (4 * np.pi)
    frame = frames(reflection, np.roll(reflection, 1, axis=1) * [1.0, -1.0, 1.0])
    spin = 2 * np.pi * u[:, 5]
    across = np.cos(spin)[:, None] * frame[:, :, 0] + np.sin(spin)[:, None] * frame[:, :, 1]
    cosine, sine_v = np.sqrt(square)[:, None], np.sqrt(1 - square)[:, None]
    normals = cosine * reflection + sine_v * across
    views = 2 * np.sum(normals * reflection, axis=1, keepdims=True) * normals - reflection
    return normals, views / np.linalg.norm(views, axis=1, keepdims=True), 1 / density


def frames(z: Array, towards: Array) -> Array:
    """Right-handed frames (n, 3, 3) with columns x, y, z, x in the plane of z and `towards`."""
    x = towards - np.sum(towards * z, axis=1, keepdims=True) * z
    degenerate = np.linalg.norm(x, axis=1) < 1e-9
    if degenerate.any():
        other = np.eye(3)[np.argmin(np.abs(z[degenerate]), axis=1)]
        x[degenerate] = np.cross(z[degenerate], other)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=-1)


# ---- Reflected radiance


def reflected(
    pixels: npt.ArrayLike,
    transfer: Transfer,
    normals: Array,
    views: Array,
    tangents: Array | None = None,
    *,
    frame: str = "normal",
    subsamples: int = 1,
    hemisphere: bool = True,
    chunk: int = 16384,
) -> Array:
    """B = sum over texels of L * rho_hat(wi, wo) * solid angle, (n, 3).

    transfer(wi (m, 3), wo (1, 3)) -> (m,) or (m, 3) in a local frame: z = normal and x = tangent (towards the
    view where no tangents are given), or z = tangent and x towards the view for frame="tangent". With
    `hemisphere` only light above the normal is visited: say False for models that are not zero below it.
    """
    pixels = np.asarray(pixels, dtype=np.float64)
    H, W, _ = pixels.shape
    nodes, weights = texel_nodes(H, W, subsamples)
    nodes = nodes.reshape(-1, 3)
    power = (weights[..., None] * pixels[:, :, None, :]).reshape(-1, 3)
    # Black texels reflect nothing.
    lit = np.any(power != 0, axis=1)
    nodes, power = np.ascontiguousarray(nodes[lit]), np.ascontiguousarray(power[lit])
    if frame == "tangent":
        assert tangents is not None
        local = frames(tangents, views)
    else:
        local = frames(normals, views if tangents is None else tangents)
    result = np.zeros((len(normals), 3))
    for start in range(0, len(nodes), chunk):
        w, p = nodes[start : start + chunk], power[start : start + chunk]
        above = w @ normals.T > 0 if hemisphere else None
        for k in range(len(normals)):
            seen, light = (w, p) if above is None else (w[above[:, k]], p[above[:, k]])
            if len(seen) == 0:
                continue
            rho = transfer(seen @ local[k], (views[k] @ local[k])[None, :])
            result[k] += rho @ light if rho.ndim == 1 else np.sum(rho * light, axis=0)
    return result


def albedo(transfer: Transfer, wo: Array, n_theta: int = 400, n_phi: int = 400) -> Array:
    """Integral of rho_hat over all light for a view (3,): Gauss in theta, midpoints in phi."""
    x, w = np.polynomial.legendre.leggauss(n_theta // 2)
    theta = np.concatenate([(1 + x) * np.pi / 4, (3 + x) * np.pi / 4])
    weight = np.concatenate([w, w]) * np.pi / 4 * np.sin(theta) * 2 * np.pi / n_phi
    phi = (np.arange(n_phi) + 0.5) * 2 * np.pi / n_phi
    t, p = theta[:, None], phi[None, :]
    wi = np.stack(np.broadcast_arrays(np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)), axis=-1)
    rho = transfer(wi.reshape(-1, 3), np.asarray(wo)[None, :])
    return np.tensordot(np.repeat(weight, n_phi), rho, axes=1)


def relative_rms(actual: npt.ArrayLike, expected: npt.ArrayLike, weights: npt.ArrayLike = 1.0) -> float:
    """Relative root mean square difference, all channels pooled; weights (n,) of the rows."""
    a, e = np.asarray(actual, dtype=np.float64), np.asarray(expected, dtype=np.float64)
    w = np.asarray(weights, dtype=np.float64)
    w = w.reshape(w.shape + (1,) * (a.ndim - w.ndim)) if w.ndim else w
    return float(np.sqrt(np.sum(w * (a - e) ** 2) / np.sum(w * e**2)))


# ---- Models: transfer functions rho_hat(wi, wo), the cosine included


def _half(wi: Array, wo: Array) -> Array:
    h = wi + wo
    return h / np.maximum(np.linalg.norm(h, axis=1, keepdims=True), 1e-300)


def lambert(color: npt.ArrayLike = 1.0) -> Transfer:
    c = np.asarray(color, dtype=np.float64)

    def transfer(wi: Array, wo: Array) -> Array:
        cosine = np.maximum(wi[:, 2], 0) / np.pi
        return cosine * c if c.ndim == 0 else cosine[:, None] * c

    return transfer


def phong(s: float) -> Transfer:
    def transfer(wi: Array, wo: Array) -> Array:
        r = wo * np.array([-1.0, -1.0, 1.0])
        return (s + 1) / (2 * np.pi) * np.maximum(np.sum(wi * r, axis=1), 0) ** s

    return transfer


def microfacet(sigma: float) -> Transfer:
    """[RH02] eq. 11, cut at the horizon."""

    def transfer(wi: Array, wo: Array) -> Array:
        h = _half(wi, wo)
        theta_h = np.arctan2(np.hypot(h[:, 0], h[:, 1]), h[:, 2])
        value = np.exp(-((theta_h / sigma) ** 2)) / (4 * np.pi * sigma**2)
        return np.where(wi[:, 2] > 0, value, 0.0)

    return transfer


def _facets(D: Callable[[Array], Array], G1: Callable[[Array], Array], f0: npt.ArrayLike) -> Transfer:
    """D G1 G1 F / (4 N.V) above the horizon, with Schlick's Fresnel term; [WMLT07] eq. 20 times N.L."""
    f = np.asarray(f0, dtype=np.float64)

    def transfer(wi: Array, wo: Array) -> Array:
        wo = np.broadcast_to(wo, wi.shape)
        valid = (wi[:, 2] > 0) & (wo[:, 2] > 0)
        h = _half(wi, wo)
        with np.errstate(all="ignore"):
            tan2 = (h[:, 0] ** 2 + h[:, 1] ** 2) / h[:, 2] ** 2
            value = D(tan2) / h[:, 2] ** 4 * G1(wi) * G1(wo) / (4 * wo[:, 2])
        value = np.where(valid, value, 0.0)
        grazing = (1 - np.clip(np.sum(wi * h, axis=1), 0, 1)) ** 5
        if f.ndim:
            return value[:, None] * (f + (1 - f) * grazing[:, None])
        return value * (f + (1 - f) * grazing)

    return transfer


def _tan(w: Array) -> Array:
    return np.hypot(w[:, 0], w[:, 1]) / w[:, 2]


def ggx(alpha: float, f0: npt.ArrayLike = 1.0) -> Transfer:
    """[WMLT07] eqs. 33 and 34."""
    return _facets(
        lambda tan2: alpha**2 / (np.pi * (alpha**2 + tan2) ** 2),
        lambda w: 2 / (1 + np.sqrt(1 + (alpha * _tan(w)) ** 2)),
        f0,
    )


def beckmann(alpha: float, f0: npt.ArrayLike = 1.0) -> Transfer:
    """[WMLT07] eqs. 25 and 26, the exact masking term."""

    def G1(w: Array) -> Array:
        a = 1 / np.maximum(alpha * _tan(w), 1e-12)
        return 2 / (1 + special.erf(a) + np.exp(-np.minimum(a * a, 700)) / (a * np.sqrt(np.pi)))

    return _facets(lambda tan2: np.exp(-tan2 / alpha**2) / (np.pi * alpha**2), G1, f0)


def anisotropic_ggx(alpha_x: float, alpha_y: float) -> Transfer:
    """[WMLT07] eqs. 33 and 34 with alpha^2 of the azimuth, f0 = 1: Heitz, JCGT 3(2), 2014."""

    def G1(w: Array) -> Array:
        phi = np.arctan2(w[:, 1], w[:, 0])
        alpha2 = (alpha_x * np.cos(phi)) ** 2 + (alpha_y * np.sin(phi)) ** 2
        return 2 / (1 + np.sqrt(1 + alpha2 * _tan(w) ** 2))

    def transfer(wi: Array, wo: Array) -> Array:
        wo = np.broadcast_to(wo, wi.shape)
        h = _half(wi, wo)
        phi = np.arctan2(h[:, 1], h[:, 0])
        slopes2 = _tan(h) ** 2 * ((np.cos(phi) / alpha_x) ** 2 + (np.sin(phi) / alpha_y) ** 2)
        D = 1 / (np.pi * alpha_x * alpha_y * h[:, 2] ** 4 * (1 + slopes2) ** 2)
        return np.where((wi[:, 2] > 0) & (wo[:, 2] > 0), D * G1(wi) * G1(wo) / (4 * np.abs(wo[:, 2])), 0.0)

    return transfer


def ashikhmin_shirley(nu: float, nv: float, Rs: float = 1.0, Rd: float = 0.0) -> Transfer:
    """[AS00] eqs. 4 to 6, the exponent by the azimuth of H, times N.L."""

    def transfer(wi: Array, wo: Array) -> Array:
        wo = np.broadcast_to(wo, wi.shape)
        l, v = np.maximum(wi[:, 2], 0), np.maximum(wo[:, 2], 0)
        h = _half(wi, wo)
        phi = np.arctan2(h[:, 1], h[:, 0])
        exponent = nu * np.cos(phi) ** 2 + nv * np.sin(phi) ** 2
        h_l = np.sum(wi * h, axis=1)
        F = Rs + (1 - Rs) * (1 - h_l) ** 5
        norm = np.sqrt((nu + 1) * (nv + 1)) / (8 * np.pi)
        glossy = norm * np.maximum(h[:, 2], 0) ** exponent / (h_l * np.maximum(np.maximum(l, v), 1e-300)) * F
        diffuse = 28 * Rd / (23 * np.pi) * (1 - Rs) * (1 - (1 - l / 2) ** 5) * (1 - (1 - v / 2) ** 5)
        return np.where((wi[:, 2] > 0) & (wo[:, 2] > 0), (glossy + diffuse) * l, 0.0)

    return transfer


def lafortune(xy: Array, z: Array, exponent: Array) -> Transfer:
    """N.L sum_k max(0, Cxy (LxVx + LyVy) + Cz LzVz)^n; each parameter (lobes, 3 channels)."""
    xy, z, exponent = (np.atleast_2d(np.asarray(p, dtype=np.float64)) for p in (xy, z, exponent))

    def transfer(wi: Array, wo: Array) -> Array:
        flat = wi[:, 0] * wo[:, 0] + wi[:, 1] * wo[:, 1]
        up = wi[:, 2] * wo[:, 2]
        total = np.zeros((len(wi), xy.shape[1]))
        for a, c, n in zip(xy, z, exponent, strict=True):
            total += np.maximum(0, a * flat[:, None] + c * up[:, None]) ** n
        return np.maximum(wi[:, 2], 0)[:, None] * total

    return transfer


def _angle(w: Array) -> Array:
    return np.arctan2(np.hypot(w[:, 0], w[:, 1]), w[:, 2])


def kajiya_kay(s: float, cone: str = "paper") -> Transfer:
    """Frame z = tangent. "paper": max(0, cos(theta_i - theta_o))^s; "mirror": cos(theta_i + theta_o - pi)."""

    def transfer(wi: Array, wo: Array) -> Array:
        ti, to = _angle(wi), _angle(wo)
        return np.maximum(0, np.cos(ti - to if cone == "paper" else ti + to - np.pi)) ** s

    return transfer


def banks(s: float) -> Transfer:
    """Frame z = tangent. [KVHS00] section 5.3, with 0 <= s < 1 the base of the cut lobe."""

    def transfer(wi: Array, wo: Array) -> Array:
        l, v = wi[:, 2], wo[:, 2]
        value = np.sqrt(np.maximum(0, 1 - l * l)) * np.sqrt(np.maximum(0, 1 - v * v)) - l * v - s
        return np.maximum(0, value) / (1 - s) ** 2

    return transfer
