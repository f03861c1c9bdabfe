// Reading reflection maps: the radiance of a surface point.
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "shrm/reflection/reflection_map.hpp"

namespace shrm {

enum class Center { reflection, normal, tangent, lobe };

// radiance (n, 3) += sum_pq B~_pq(C) Y_pq(V)   [RH02] eq. 7, or sum_p B_p0(C) Y_p0(C.V), eq. 6, if zonal.
//
// C is the reflection 2 (N.V) N - V, N or the tangent itself; about the lobe, with gamma(theta_v) uniform
// over [0, pi/2],  C = cos(gamma) N - sin(gamma) (V - (N.V) N) / |V - (N.V) N|. Interpolated normals can turn
// away from the eye: the reflection is used as it is; about the lobe and the normal the view is brought back
// to the horizon, where the fit over the views ends.
//   axes   the normals, or the tangents of a lobe about the tangent
//   views  n directions, or one for all
// Interpolation is by the four-point Lagrange polynomial in both directions, across the poles, or bilinear.
void add_radiance(const ReflectionMapView& map, Center center, std::span<const double> gamma,
                  std::span<const glm::dvec3> axes, std::span<const glm::dvec3> views, bool bilinear,
                  std::span<float> radiance);

// The same at central directions C themselves.
void add_looked_up(const ReflectionMapView& map, std::span<const glm::dvec3> C,
                   std::span<const glm::dvec3> views, bool bilinear, std::span<float> radiance);

}  // namespace shrm
