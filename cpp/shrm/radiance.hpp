// Reading reflection maps: the radiance of a surface point.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

namespace shrm {

enum class Centre { reflection, normal, tangent, lobe };
enum class MapLayout {
    latlong,  // rings (H, maps, 3, W), the grid of core.hpp; W even
    cube  // rings (6 (N + 4), maps, 3, N + 4): faces +X -X +Y -Y +Z -Z, each with a border of two texels that
          // continues its own plane, so that no interpolation looks across an edge
};
inline constexpr int cube_border = 2;

struct ReflectionMapView {
    MapLayout layout;
    int H, W;   // of the rings: cube maps include their borders
    int pitch;  // values from one row of W to the next; more than W where rows begin at multiples of 16 bytes
    int P;
    bool zonal;  // P + 1 maps of a series in Y_p0(angle between C and V), else (P+1)^2 in Y_pq(V)
    std::span<const float> rings;
    std::span<const std::uint16_t> halves;  // IEEE half floats in place of rings

    int maps() const { return zonal ? P + 1 : (P + 1) * (P + 1); }
};

// The direction of a point of a cube face, s and t in [-1, 1] to the right and downwards. Faces and their
// orientation are OpenGL's, in the axes of the layout `strip`: +Z front (+x of the world), +X right (-y), +Y
// up (+z).
glm::dvec3 cube_direction(int face, double s, double t);

// radiance (n, 3) += sum_pq B~_pq(C) Y_pq(V)   [RH02] eq. 7, or sum_p B_p0(C) Y_p0(C.V), eq. 6, if zonal.
//
// C is the reflection 2 (N.V) N - V, N or the tangent itself; about the lobe, with gamma(theta_v) uniform
// over [0, pi/2],  C = cos(gamma) N - sin(gamma) (V - (N.V) N) / |V - (N.V) N|. Interpolated normals can turn
// away from the eye: the reflection is used as it is; about the lobe and the normal the view is brought back
// to the horizon, where the fit over the views ends.
//   axes   the normals, or the tangents of a lobe about the tangent
//   views  n directions, or one for all
// Interpolation is by the four-point Lagrange polynomial in both directions, across the poles, or bilinear.
void add_radiance(const ReflectionMapView& map, Centre centre, std::span<const double> gamma,
                  std::span<const glm::dvec3> axes, std::span<const glm::dvec3> views, bool bilinear,
                  std::span<float> radiance);

}  // namespace shrm
