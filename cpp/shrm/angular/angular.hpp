// angular: prefiltering by direct integration over the texels of a picture, the way it was
// done before frequency space [RH02 sections 6 and 7.4, appendix D]. It is the rival and the
// judge of the spherical harmonic reflection map, and shares nothing with it but Gauss's nodes.
//
// A picture is piecewise constant: reflected light is the sum over texels of the radiance times
// the integral of the transfer function rho_hat over the texel. That integral is a product
// Gauss rule of subsamples x subsamples nodes in (theta, phi), its weights scaled so that
// they sum to the texel's exact solid angle; one node is the texel's center.
//
// A BRDF comes as a table, in coordinates in which it is smooth and its horizon is an edge:
//   radial      u(theta), theta the angle between the light and a center
//   half angle  u(theta_h) where N.L > 0, theta_h the angle between N and the half vector H
//   zonal       u(theta_i, theta_o), both from an axis: per query a profile of theta_i
//   isotropic   rho_hat(theta_v, L) = E(theta_h) * ratio(theta_v, theta_l, phi): E, the
//               envelope, carries a sharp highlight exactly where it is sharp, over the half
//               angle; the ratio is smooth on a box whose edge theta_l = pi/2 is the horizon,
//               so that nothing is ever interpolated across it.
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "shrm/core.hpp"

namespace shrm::angular {

// Radiance times the texel's solid angle in planes [channel][H][row_length(W)]. Column j of a row holds
// texel j mod W, so that any arc of columns is one contiguous run, readable in whole groups of lanes.
inline constexpr int most_lanes = 16;
constexpr int row_length(int W) {
    return 2 * W + most_lanes;
}

struct Picture {
    std::span<const float> planes;
    int H;
    int W;
    int subsamples;
};

// Directions at an angle in [inner, outer] from a center; the rest is left out.
struct Band {
    double inner;
    double outer;
};

// u as cubics of z = 1 + scale sin^2(theta/2) >= 1, which needs no root and whose logarithm spends segments
// where a lobe is sharp: values [channel][4][segments], coefficients of z^0 ... z^3; if there are more than
// 32 segments, of x instead of z, which goes from 1 to 2 along each, lest large terms cancel. The segment of
// z is (bits of z as float) >> shift modulo segments, a power of two: some to each octave. The last segment
// is 0, and so is u beyond the angle `support`, where it begins. Channels 1 or 3.
struct RadialProfile {
    std::span<const float> values;
    int channels;
    int segments;
    int shift;
    double scale;
    double support;
};

// Profiles u(theta_i) at theta_o = k pi / (rows - 1), over s = sin(theta_i/2), node k at s = k / intervals:
// values [row][channel][intervals + 2], the last node repeated; and one band for each row.
struct ZonalProfiles {
    std::span<const float> values;
    std::span<const Band> bands;
    int rows;
    int channels;
    int intervals;
};

// For views at equal places in 1 - sqrt(1 - theta_v 2/pi): the lobe's center as an angle from the normal,
// away from the view, and the angle about it that is integrated.
struct Cap {
    double center;
    double outer;
};

// envelope  E at tan(theta_h / 2) = k / envelope_intervals: [envelope_intervals + 2]
// ratio     rho_hat / E: [view][channel][light_intervals + 2][azimuth_intervals + 2]
//           view: 1 - sqrt(1 - theta_v 2/pi), light: sqrt(1 - sqrt(N.L)), uniform in [0, 1]
//           azimuth of the light from the view: (1 - x / (|x| + |y|)) / 2 uniform in [0, 1]
// caps      for each view node
struct IsotropicTable {
    std::span<const float> envelope;
    std::span<const float> ratio;
    std::span<const Cap> caps;
    int channels;
    int envelope_intervals;
    int view_intervals;
    int light_intervals;
    int azimuth_intervals;
};

// Reflected radiance for each center, a unit vector: out [query][3]. Only lights within `outer` of it, in
// radians, are visited.
void integrate_radial(const Picture& picture, const RadialProfile& profile, double outer,
                      std::span<const glm::dvec3> centers, std::span<float> out);

// The same for every texel center of a lat-long map of map_H x map_W, out [map_H][map_W][3]. The
// kernel between a row of the map and a row of the picture depends only on the difference in
// azimuth: with symmetry it is evaluated once for a row of the map and slid along it, without it angle and
// profile are evaluated for every pair of texels.
void integrate_radial_map(const Picture& picture, const RadialProfile& profile, double outer, int map_H,
                          int map_W, bool symmetry, std::span<float> out);

// Reflected radiance for each axis, the view at theta_o, in radians, from it: out [query][3].
void integrate_zonal(const Picture& picture, const ZonalProfiles& profiles, std::span<const glm::dvec3> axes,
                     std::span<const double> theta_o, std::span<float> out);

// Reflected radiance for each normal and view, the view above the normal's horizon: out [query][3]. A profile
// of one channel. Queries of the first one's view may share its half vectors; without `share` each finds its
// own for every texel.
void integrate_half_angle(const Picture& picture, const RadialProfile& profile, std::span<const Cap> caps,
                          std::span<const glm::dvec3> normals, std::span<const glm::dvec3> views, bool share,
                          std::span<float> out);

// The same for any isotropic table.
void integrate_isotropic(const Picture& picture, const IsotropicTable& table,
                         std::span<const glm::dvec3> normals, std::span<const glm::dvec3> views,
                         std::span<float> out);

}  // namespace shrm::angular
