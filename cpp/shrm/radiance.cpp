#include "shrm/radiance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

#include "shrm/core.hpp"
#include "shrm/layouts.hpp"
#include "shrm/legendre.hpp"

namespace shrm {
namespace {

// Y_pq(direction), real basis, for all p <= P.
void real_harmonics(const LegendreRecurrence& recurrence, int P, const glm::dvec3& direction, double* Y) {
    const double sine = std::hypot(direction.x, direction.y);
    const double cos1 = sine > 0 ? direction.x / sine : 1, sin1 = sine > 0 ? direction.y / sine : 0;
    double cosine_q = std::numbers::sqrt2, sine_q = 0;
    for (int q = 0; q <= P; ++q) {
        double f = recurrence.start(q) * power(sine, q), previous = 0;
        for (int p = q; p <= P; ++p) {
            Y[lm(p, q)] = q ? f * cosine_q : f;
            if (q) Y[lm(p, -q)] = f * sine_q;
            const auto [a, b] = recurrence.steps(q)[p - q];
            const double next = a * direction.z * f - b * previous;
            previous = f;
            f = next;
        }
        const double turned = cosine_q * cos1 - sine_q * sin1;
        sine_q = sine_q * cos1 + cosine_q * sin1;
        cosine_q = turned;
    }
}

// Y_p0 at the angle between C and V.
void zonal_harmonics(const LegendreRecurrence& recurrence, int P, double cosine, double* Y) {
    double f = recurrence.start(0), previous = 0;
    for (int p = 0; p <= P; ++p) {
        Y[p] = f;
        const auto [a, b] = recurrence.steps(0)[p];
        const double next = a * cosine * f - b * previous;
        previous = f;
        f = next;
    }
}

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

glm::dvec3 texel_direction(const ReflectionMapView& map, int row, int column) {
    if (map.layout == MapLayout::latlong)
        return LatLong(map.H, map.W, 0).ray(column + 0.5, row + 0.5).direction;
    const int N = map.W - 2 * cube_border;
    const auto centred = [N](int i) { return (2 * (i - cube_border) + 1.0) / N - 1; };
    return glm::normalize(cube_direction(row / map.W, centred(column), centred(row % map.W)));
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
    const LegendreRecurrence recurrence(map.P);
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
                zonal_harmonics(recurrence, map.P, glm::dot(C, view), Y.data());
            else
                real_harmonics(recurrence, map.P, view, Y.data());
            const Stencil stencil = map.layout == MapLayout::cube
                                        ? cube_stencil(map.W, C, bilinear)
                                        : latlong_stencil(map.H, map.W, C, bilinear);
            interpolate(map, stencil, Y.data(), &radiance[3 * at]);
        }
    }
}

// One row of the sum over the maps [RH02] eq. 12: a product of functions of C and of V as in eq. 4.
static void view_ring(const ReflectionMapView& map, int row, const float* weights, float* sums,
                      float* pixels) {
    const std::size_t width = size(map.W), maps = size(map.maps());
    const float* ring = map.rings.data() + size(row) * maps * 3 * width;
    const std::size_t stride = map.zonal ? width : 0;  // a weight per texel, or one for all
    std::fill_n(sums, 3 * width, 0.f);
    for (std::size_t z = 0; z < maps; ++z)
        for (std::size_t c = 0; c < 3; ++c, ring += width) {
            float* sum = sums + c * width;
            if (stride == 0) {
                const float w = weights[z];
                for (std::size_t j = 0; j < width; ++j) sum[j] += w * ring[j];
            } else {
                const float* w = weights + z * stride;
                for (std::size_t j = 0; j < width; ++j) sum[j] += w[j] * ring[j];
            }
        }
    for (std::size_t j = 0; j < width; ++j)
        for (std::size_t c = 0; c < 3; ++c) pixels[3 * j + c] = sums[c * width + j];
}

void view_map(const ReflectionMapView& map, const glm::dvec3& view, std::span<float> pixels) {
    const LegendreRecurrence recurrence(map.P);
    std::vector<double> Y(basis_size(map.P));
    real_harmonics(recurrence, map.P, view, Y.data());
    const std::vector<float> of_view(Y.begin(), Y.end());
    const std::size_t width = size(map.W);
#pragma omp parallel
    {
        std::vector<float> sums(3 * width), of_texels(map.zonal ? size(map.P + 1) * width : 0);
        std::vector<double> zonal(size(map.P + 1));
#pragma omp for schedule(static)
        for (int row = 0; row < map.H; ++row) {
            for (int j = 0; map.zonal && j < map.W; ++j) {
                zonal_harmonics(recurrence, map.P, glm::dot(texel_direction(map, row, j), view),
                                zonal.data());
                for (std::size_t p = 0; p < zonal.size(); ++p)
                    of_texels[p * width + size(j)] = static_cast<float>(zonal[p]);
            }
            view_ring(map, row, map.zonal ? of_texels.data() : of_view.data(), sums.data(),
                      &pixels[size(row) * width * 3]);
        }
    }
}

}  // namespace shrm
