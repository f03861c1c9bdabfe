"""What each kernel must do at least: floating-point operations and bytes, counted plainly.

A product and its sum are two operations. Only the products of the method itself are counted, after its
symmetries are used: no padding, no recurrences, no shuffles, no additions of folding. Bytes are those of the
arrays that go in and come out, each once; for look-ups, those of every texel that is touched.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Work:
    """Operations and bytes of one kernel.

    `held` is what its arrays take in memory, which says the level they are read from, if that is not `bytes`.
    """

    flops: float
    bytes: float
    double: bool = False
    held: float | None = None


def ring_products(H: int, W: int, channels: int, F: int) -> float:
    """Operations of the Fourier transforms of all rings, a quarter of the circle for each of 2F+1 modes."""
    return 2.0 * channels * H * (W / 4) * (2 * F + 1)


def legendre_products(H: int, channels: int, F: int) -> float:
    """Operations of all Legendre sums, over the northern rings for even and odd degrees apart."""
    return 2.0 * channels * (H / 2) * (F + 1) ** 2


def analysis(H: int, W: int, F: int, channels: int = 3) -> Work:
    """Picture to coefficients."""
    return Work(
        ring_products(H, W, channels, F) + legendre_products(H, channels, F),
        4.0 * H * W * channels + 8.0 * (F + 1) ** 2 * channels,
    )


def synthesis(H: int, W: int, channels: int, F: int) -> Work:
    """Coefficients to lat-long maps."""
    return Work(
        ring_products(H, W, channels, F) + legendre_products(H, channels, F),
        4.0 * H * W * channels + 8.0 * (F + 1) ** 2 * channels,
    )


def cube_synthesis(N: int, channels: int, F: int) -> Work:
    """Coefficients to a cube with borders of two texels: each term at the texels of an octant."""
    texels = 6 * (N + 4) ** 2
    return Work(
        2.0 * (F + 1) ** 2 * channels * texels / 8, 4.0 * texels * channels + 8.0 * (F + 1) ** 2 * channels
    )


def map_coefficients(F: int, P: int, channels: int = 3) -> Work:
    """Light and material to the coefficients of the maps, in float64: five operations for each coupling.

    One complex number takes the product of shape and coupling, and two products with sums.
    """
    couplings = 0
    for j in range(F + P + 1):
        for p in range(max(0, j - F), P + 1):
            for l in range(abs(j - p), min(F, j + p) + 1, 2):
                for q in range(p + 1):
                    couplings += max(0, min(j, l - q) - max(-j, -l - q) + 1)
    coefficients = (F + P + 1) ** 2 * (P + 1) ** 2
    return Work(5.0 * couplings * channels, 8.0 * (coefficients * channels + couplings), double=True)


def view(maps: int, N: int, half: bool) -> Work:
    """The sum over the maps of a cube, [RH02] eq. 12."""
    texels = 6 * N * N * 3
    return Work(2.0 * maps * texels, texels * (maps * (2 if half else 4) + 4.0))


def radiance(points: int, maps: int, taps: int, texels: int) -> Work:
    """Look-ups in maps of so many texels, and the sum over the view's harmonics."""
    queries = points * (8.0 * 6 + 4 * 3)
    return Work(
        2.0 * points * maps * 3 * (taps + 1),
        points * 4.0 * maps * 3 * taps + queries,
        held=4.0 * maps * 3 * texels + queries,
    )


# ---- Lighting an object: n^2 terms, one channel of the material for three of light

SURFACE = 4 * (3 + 9 + 3)
"""Bytes of a vertex's position, frame and radiance."""


def _scattered(run: int) -> float:
    """Bytes that memory gives, in whole lines of 64, for a run of so many that begins at any float."""
    return 64 * (1 + (run - 4) / 64)


def lit_by_tents(V: int, M: int, terms: int, size: int) -> Work:
    """Four rows of each vertex's matrix, in two runs, and their sum times light."""
    return Work(
        2.0 * V * (4 + 3) * terms,
        V * (SURFACE + 2 * _scattered(2 * terms * size)),
        held=1.0 * V * M * M * terms * size,
    )


def lit_by_components(V: int, K: int, M: int, terms: int, size: int) -> Work:
    """Components times light; then four tents' rows of K for each vertex and channel, and their sum."""
    return Work(2.0 * 3 * K * (M * M * terms + V * (4 + 1)), V * (SURFACE + K * size))


def lit_by_transfer(V: int, terms: int, size: int, bands: int) -> Work:
    """A row times a rotation, if there is one, times a matrix, times light."""
    return Work(
        2.0 * V * (4 * terms + bands + terms**2 + 3 * terms), V * (SURFACE + 4 * bands + size * terms**2)
    )


def lit_without_shadows(V: int, terms: int, bands: int) -> Work:
    """A row times a rotation, if there is one, times light."""
    return Work(2.0 * V * (bands + 4 * terms), V * (SURFACE + 4.0 * bands))


def lit_by_fixed_tents(V: int) -> Work:
    """Four tents' radiance, in two runs."""
    return Work(2.0 * V * 4 * 3, V * (SURFACE + 2 * _scattered(24)), held=V * 121 * 12)


def lit_by_rows(V: int, terms: int) -> Work:
    """A row times light."""
    return Work(2.0 * V * 3 * terms, 4.0 * V * (terms + 3))
