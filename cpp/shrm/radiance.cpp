#include "shrm/radiance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

#include "shrm/core.hpp"
#include "shrm/view_harmonics.hpp"

namespace shrm {
namespace {

// Weights of the samples at -1, 0, 1, 2 for a point at t in [0, 1).
std::array<float, 4> interpolation_weights(double t, bool bilinear) {
    const auto w = bilinear
                       ? std::array<double, 4>{0, 1 - t, t, 0}
                       : std::array<double, 4>{-t * (t - 1) * (t - 2) / 6, (t + 1) * (t - 1) * (t - 2) / 2,
                                               -(t + 1) * t * (t - 2) / 2, (t + 1) * t * (t - 1) / 6};
    return {float(w[0]), float(w[1]), float(w[2]), float(w[3])};
}

// Four rows and, in each, four columns of the rings, with their weights.
struct Stencil {
    std::array<int, 4> rows;
    std::array<std::array<int, 4>, 4> columns;
    std::array<float, 4> row_weights, column_weights;
};

Stencil latlong_stencil(int H, int W, const glm::dvec3& direction, bool bilinear) {
    const double theta = std::atan2(std::hypot(direction.x, direction.y), direction.z);
    const double row = theta / pi * H - 0.5,
                 column = (pi - std::atan2(direction.y, direction.x)) / (2 * pi) * W - 0.5;
    const int i = static_cast<int>(std::floor(row)), j = static_cast<int>(std::floor(column));
    Stencil s;
    s.row_weights = interpolation_weights(row - i, bilinear);
    s.column_weights = interpolation_weights(column - j, bilinear);
    for (int a = 0; a < 4; ++a) {
        int r = i - 1 + a, half_turn = 0;
        if (r < 0)
            r = -1 - r, half_turn = W / 2;  // beyond the pole: the same ring system, half a turn on
        else if (r >= H)
            r = 2 * H - 1 - r, half_turn = W / 2;
        s.rows[size(a)] = std::clamp(r, 0, H - 1);
        for (int b = 0; b < 4; ++b) s.columns[size(a)][size(b)] = (j - 1 + b + half_turn + 2 * W) % W;
    }
    return s;
}

Stencil cube_stencil(int padded, const glm::dvec3& direction, bool bilinear) {
    const int N = padded - 2 * cube_border;
    const glm::dvec3 d{-direction.y, direction.z, direction.x};  // in the cube's axes
    const glm::dvec3 a = glm::abs(d);
    int face;
    double s, t, major;
    if (a.x >= a.y && a.x >= a.z)
        face = d.x > 0 ? 0 : 1, major = a.x, s = d.x > 0 ? -d.z : d.z, t = -d.y;
    else if (a.y >= a.z)
        face = d.y > 0 ? 2 : 3, major = a.y, s = d.x, t = d.y > 0 ? d.z : -d.z;
    else
        face = d.z > 0 ? 4 : 5, major = a.z, s = d.z > 0 ? d.x : -d.x, t = -d.y;
    const double row = (t / major + 1) / 2 * N - 0.5, column = (s / major + 1) / 2 * N - 0.5;
    const int i = static_cast<int>(std::floor(row)), j = static_cast<int>(std::floor(column));
    Stencil stencil;
    stencil.row_weights = interpolation_weights(row - i, bilinear);
    stencil.column_weights = interpolation_weights(column - j, bilinear);
    for (int u = 0; u < 4; ++u) {
        stencil.rows[size(u)] = face * padded + std::clamp(i - 1 + u + cube_border, 0, padded - 1);
        for (int v = 0; v < 4; ++v)
            stencil.columns[size(u)][size(v)] = std::clamp(j - 1 + v + cube_border, 0, padded - 1);
    }
    return stencil;
}

// result (3) += sum over the maps of weight times the interpolated map: the sum of [RH02] eq. 7 or,
// if zonal, eq. 6, the weights being Y_pq of the view.
void interpolate(const ReflectionMapView& map, const Stencil& s, const double* weights, float* result) {
    const std::size_t width = size(map.W), ring = size(map.maps()) * 3 * width;
    double sum[3] = {};
    for (std::size_t a = 0; a < 4; ++a) {
        const float* row = map.rings.data() + size(s.rows[a]) * ring;
        const auto [c0, c1, c2, c3] = s.columns[a];
        const auto [w0, w1, w2, w3] = s.column_weights;
        double of_row[3] = {};
        for (int z = 0; z < map.maps(); ++z)
            for (std::size_t c = 0; c < 3; ++c, row += width)
                of_row[c] += weights[z] * double(w0 * row[c0] + w1 * row[c1] + (w2 * row[c2] + w3 * row[c3]));
        for (std::size_t c = 0; c < 3; ++c) sum[c] += double(s.row_weights[a]) * of_row[c];
    }
    for (std::size_t c = 0; c < 3; ++c) result[c] += static_cast<float>(sum[c]);
}

}  // namespace

glm::dvec3 cube_direction(int face, double s, double t) {
    const std::array<glm::dvec3, 6> in_cube{
        {{1, -t, -s}, {-1, -t, s}, {s, 1, t}, {s, -1, -t}, {s, -t, 1}, {-s, -t, -1}}};
    const glm::dvec3 c = in_cube[size(face)];
    return {c.z, -c.x, c.y};
}

glm::dvec3 central_direction(Centre centre, std::span<const double> gamma, const glm::dvec3& axis,
                             glm::dvec3& view) {
    if (centre == Centre::tangent) return axis;
    const double cosine = glm::dot(axis, view);
    if (centre == Centre::reflection) return 2 * cosine * axis - view;
    const glm::dvec3 across = view - cosine * axis;
    const double sine = glm::length(across);
    if (sine < 1e-12) return axis;
    if (cosine < 0) view = across / sine;
    if (centre == Centre::normal) return axis;
    const double theta_v = std::min(std::atan2(sine, cosine), pi / 2);
    const double at = theta_v / (pi / 2) * static_cast<double>(gamma.size() - 1);
    const std::size_t i = std::min(static_cast<std::size_t>(at), gamma.size() - 2);
    const double t = at - static_cast<double>(i), angle = (1 - t) * gamma[i] + t * gamma[i + 1];
    return std::cos(angle) * axis - std::sin(angle) / sine * across;
}

void add_radiance(const ReflectionMapView& map, Centre centre, std::span<const double> gamma,
                  std::span<const glm::dvec3> axes, std::span<const glm::dvec3> views, bool bilinear,
                  std::span<float> radiance) {
    const auto n = static_cast<std::ptrdiff_t>(axes.size());
#pragma omp parallel
    {
        std::vector<double> Y(basis_size(map.P));
#pragma omp for schedule(static)
        for (std::ptrdiff_t i = 0; i < n; ++i) {
            const auto at = static_cast<std::size_t>(i);
            glm::dvec3 view = views[views.size() == 1 ? 0 : at];
            const glm::dvec3 C = central_direction(centre, gamma, axes[at], view);
            if (map.zonal)
                zonal_harmonics(map.P, glm::dot(C, view), Y.data());
            else
                real_harmonics(map.P, view, Y.data());
            const Stencil stencil = map.layout == MapLayout::cube
                                        ? cube_stencil(map.W, C, bilinear)
                                        : latlong_stencil(map.H, map.W, C, bilinear);
            interpolate(map, stencil, Y.data(), &radiance[3 * at]);
        }
    }
}

}  // namespace shrm
