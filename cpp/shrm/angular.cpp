#include "angular.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <vector>

#include <glm/geometric.hpp>

#include "angular_texels.hpp"

#define SHRM_INLINE inline __attribute__((always_inline))

namespace shrm::angular {
namespace {

// ---- Sums in lanes: the same additions in the same order on every instruction set

typedef float Lanes __attribute__((vector_size(lanes * sizeof(float))));

SHRM_INLINE void load(Lanes& v, const float* p) {
    std::memcpy(&v, p, sizeof v);
}

SHRM_INLINE double sum_of(const Lanes& v) {
    double sum = 0;
    for (int k = 0; k < lanes; ++k) sum += static_cast<double>(v[k]);
    return sum;
}

// out[c] += sum_j weight[c][j] plane[c][j], n of them; single precision within a row only.
SHRM_INLINE void accumulate(const float* const weight[3], const float* const plane[3], int n, double out[3]) {
    Lanes sum[3] = {};
    int j = 0;
    for (; j + lanes <= n; j += lanes)
        for (int c = 0; c < 3; ++c) {
            Lanes w, light;
            load(w, weight[c] + j);
            load(light, plane[c] + j);
            sum[c] += w * light;
        }
    for (; j < n; ++j)
        for (int c = 0; c < 3; ++c) sum[c][j % lanes] += weight[c][j] * plane[c][j];
    for (int c = 0; c < 3; ++c) out[c] += sum_of(sum[c]);
}

struct Planes {
    std::size_t length, stride;
    const float* first;

    explicit Planes(const Picture& picture)
        : length(size(row_length(picture.W))),
          stride(length * size(picture.H)),
          first(picture.planes.data()) {}
    SHRM_INLINE const float* at(int channel, int row, int column) const {
        return first + size(channel) * stride + size(row) * length + size(column);
    }
};

// ---- Radial lobes

// weight[j] += solid_angle u(theta_j), with sin^2(theta_j / 2) = ring + span azimuth[j].
SHRM_INLINE void add_radial(float* __restrict weight, const float* __restrict azimuth, int n, float ring,
                            float span, float solid_angle, const float* __restrict u, float intervals) {
    for (int j = 0; j < n; ++j) {
        const float x = intervals * std::sqrt(ring + span * azimuth[j]);
        const int k = static_cast<int>(x);
        const float t = x - static_cast<float>(k);
        weight[j] += solid_angle * (u[k] + t * (u[k + 1] - u[k]));
    }
}

// sin^2((phi_j - phi_C) / 2) for all columns of nodes, [k][row_length].
void azimuths(const Nodes& nodes, double phi, std::vector<float>& azimuth) {
    azimuth.resize(nodes.cos_phi.size());
    const double c = std::cos(phi), s = std::sin(phi);
    for (std::size_t j = 0; j < azimuth.size(); ++j)
        azimuth[j] =
            static_cast<float>(std::max(0.0, 0.5 * (1 - nodes.cos_phi[j] * c - nodes.sin_phi[j] * s)));
}

struct Scratch {
    std::vector<float> azimuth, x, y, z;  // per column of nodes
    std::vector<float> weight;            // [3][W]
    std::vector<float> profile;           // a zonal profile at one theta_o
    std::vector<float> slice;             // an isotropic table at one theta_v
    std::vector<float> t_light, t_azimuth, scale;
    std::vector<int> cell;
};

// The weights of the texels of one arc of row i, for each channel of the profile.
SHRM_INLINE void radial_weights(const Nodes& nodes, const Centre& centre, const float* u, int channels,
                                int intervals, int i, Arc arc, const std::vector<float>& azimuth,
                                float* weight, std::size_t stride) {
    const int n = arc.end - arc.begin;
    for (int c = 0; c < channels; ++c) {
        float* w = weight + size(c) * stride;
        std::fill_n(w, n, 0.0f);
        for (int a = 0; a < nodes.k; ++a) {
            const std::size_t row = size(i * nodes.k + a);
            const float ring = static_cast<float>(centre.ring(nodes, row));
            const float span = static_cast<float>(centre.span(nodes, row));
            for (int b = 0; b < nodes.k; ++b)
                add_radial(w, azimuth.data() + b * row_length(nodes.W) + arc.begin, n, ring, span,
                           static_cast<float>(nodes.solid_angle[row] * nodes.column_weight[size(b)]),
                           u + c * (intervals + 2), static_cast<float>(intervals));
        }
    }
}

void radial_query(const Nodes& nodes, const Planes& planes, const glm::dvec3& axis, const float* u,
                  int channels, int intervals, const Band& band, Scratch& scratch, float* out) {
    const Centre centre(axis);
    azimuths(nodes, centre.phi, scratch.azimuth);
    const std::size_t stride = size(nodes.W);
    scratch.weight.resize(3 * stride);
    float* weight = scratch.weight.data();
    double sum[3] = {};
    for (int i = 0; i < nodes.H; ++i) {
        const Arcs arcs = columns(nodes, centre, band, i);
        for (int part = 0; part < arcs.count; ++part) {
            const Arc arc = arcs.arc[part];
            radial_weights(nodes, centre, u, channels, intervals, i, arc, scratch.azimuth, weight, stride);
            const std::size_t next = channels == 3 ? stride : 0;
            const float* w[3] = {weight, weight + next, weight + 2 * next};
            const float* light[3] = {planes.at(0, i, arc.begin), planes.at(1, i, arc.begin),
                                     planes.at(2, i, arc.begin)};
            accumulate(w, light, arc.end - arc.begin, sum);
        }
    }
    for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(sum[c]);
}

// ---- A whole map of a radial lobe: slide the kernel along the row

// A kernel row: arc.begin for the first output column, padded with zeros to whole lanes.
struct KernelRow {
    int i, begin, groups;
    std::size_t at;
};

inline constexpr int outputs = 4;         // columns of the map at once: 12 accumulators in registers
inline constexpr int rows_in_single = 8;  // rows of the picture summed in single precision

template <int channels>
SHRM_INLINE void slide(const Planes& planes, const std::vector<KernelRow>& rows, const float* kernel, int W,
                       const int shift[outputs], double out[outputs][3]) {
    for (std::size_t first = 0; first < rows.size(); first += rows_in_single) {
        Lanes sum[outputs][3] = {};
        for (std::size_t r = first; r < std::min(rows.size(), first + rows_in_single); ++r) {
            const KernelRow& row = rows[r];
            const float* light[outputs];
            for (int t = 0; t < outputs; ++t) light[t] = planes.at(0, row.i, (row.begin + shift[t]) % W);
            const float* k = kernel + row.at;
            for (int m = 0; m < row.groups * lanes; m += lanes)
                for (int c = 0; c < 3; ++c) {
                    Lanes w;
                    load(w, k + (channels == 3 ? c * row.groups * lanes : 0) + m);
                    for (int t = 0; t < outputs; ++t) {
                        Lanes l;
                        load(l, light[t] + size(c) * planes.stride + m);
                        sum[t][c] += w * l;
                    }
                }
        }
        for (int t = 0; t < outputs; ++t)
            for (int c = 0; c < 3; ++c) out[t][c] += sum_of(sum[t][c]);
    }
}

// Output columns begin, begin + step, ... of one row of the map.
void radial_map_row(const Nodes& nodes, const Planes& planes, const RadialProfile& profile, double outer,
                    double theta, int begin, int step, int map_W, Scratch& scratch, float* out) {
    const double phi = pi - 2 * pi / map_W * (begin + 0.5);
    const Centre centre({std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)});
    azimuths(nodes, centre.phi, scratch.azimuth);
    std::vector<KernelRow> rows;
    std::vector<float>& kernel = scratch.weight;
    kernel.clear();
    for (int i = 0; i < nodes.H; ++i) {
        const Arcs arcs = columns(nodes, centre, {0, outer}, i);
        if (arcs.count == 0) continue;
        const Arc arc = arcs.arc[0];
        const int groups = (arc.end - arc.begin + lanes - 1) / lanes;
        const std::size_t stride = size(groups * lanes), at = kernel.size();
        kernel.resize(at + stride * size(profile.channels), 0.0f);
        radial_weights(nodes, centre, profile.values.data(), profile.channels, profile.intervals, i, arc,
                       scratch.azimuth, kernel.data() + at, stride);
        rows.push_back({i, arc.begin, groups, at});
    }
    const int columns_per_step = nodes.W / (map_W / step);
    for (int t0 = 0; begin + t0 * step < map_W; t0 += outputs) {
        int shift[outputs];
        for (int t = 0; t < outputs; ++t) shift[t] = (t0 + t) * columns_per_step % nodes.W;
        double sum[outputs][3] = {};
        if (profile.channels == 3)
            slide<3>(planes, rows, kernel.data(), nodes.W, shift, sum);
        else
            slide<1>(planes, rows, kernel.data(), nodes.W, shift, sum);
        for (int t = 0; t < outputs && begin + (t0 + t) * step < map_W; ++t)
            for (int c = 0; c < 3; ++c)
                out[3 * (begin + (t0 + t) * step) + c] = static_cast<float>(sum[t][c]);
    }
}

// ---- Isotropic lobes

// Row `from` and the next of a table of rows of n values, mixed.
SHRM_INLINE void mix_rows(const float* __restrict table, std::size_t n, int from, float t,
                          std::vector<float>& out) {
    out.resize(n);
    const float* __restrict low = table + size(from) * n;
    const float* __restrict high = low + n;
    float* __restrict mixed = out.data();
    for (std::size_t k = 0; k < n; ++k) mixed[k] = low[k] + t * (high[k] - low[k]);
}

// A light at (x, y, z) about the normal, the view at (view.x, 0, view.z): the cell of the
// ratio's table, the place in it, and the envelope times the solid angle, zero below the horizon.
struct Lookup {
    float view_x, view_z;
    float envelope_intervals, light_intervals, azimuth_intervals;
    int row;  // length of a row of the slice
};

SHRM_INLINE void look_up(const Lookup& table, const float* __restrict envelope, const float* __restrict X,
                         const float* __restrict Y, const float* __restrict Z, int n, float sin_theta,
                         const float* rest, float solid_angle, int* __restrict cell,
                         float* __restrict t_light, float* __restrict t_azimuth, float* __restrict scale) {
    constexpr float tiny = 1e-30f;
    for (int j = 0; j < n; ++j) {
        const float x = sin_theta * X[j] + rest[0], y = sin_theta * Y[j] + rest[1],
                    z0 = sin_theta * Z[j] + rest[2];
        float z = z0 > 0.0f ? z0 : 0.0f;
        z = z < 1.0f ? z : 1.0f;
        const float hx = x + table.view_x, hz = z + table.view_z;
        const float across = hx * hx + y * y;
        float half = std::sqrt(across) / (hz + std::sqrt(across + hz * hz) + tiny);  // tan(theta_h / 2)
        half = half < 1.0f ? half : 1.0f;
        const float xe = half * table.envelope_intervals;
        const int ke = static_cast<int>(xe);
        const float e = envelope[ke] + (xe - static_cast<float>(ke)) * (envelope[ke + 1] - envelope[ke]);

        const float xl = table.light_intervals * std::sqrt(1.0f - std::sqrt(z));
        const float xa = table.azimuth_intervals * (0.5f - 0.5f * x / (std::abs(x) + std::abs(y) + tiny));
        const int kl = static_cast<int>(xl), ka = static_cast<int>(xa);
        cell[j] = kl * table.row + ka;
        t_light[j] = xl - static_cast<float>(kl);
        t_azimuth[j] = xa - static_cast<float>(ka);
        scale[j] = (z0 > 0.0f ? solid_angle : 0.0f) * e;
    }
}

SHRM_INLINE void add_ratio(float* __restrict weight, const float* __restrict slice, int row, int n,
                           const int* __restrict cell, const float* __restrict t_light,
                           const float* __restrict t_azimuth, const float* __restrict scale) {
    for (int j = 0; j < n; ++j) {
        const float a = slice[cell[j]], b = slice[cell[j] + 1];
        const float c = slice[cell[j] + row], d = slice[cell[j] + row + 1];
        const float low = a + t_azimuth[j] * (b - a), high = c + t_azimuth[j] * (d - c);
        weight[j] += scale[j] * (low + t_light[j] * (high - low));
    }
}

void isotropic_query(const Nodes& nodes, const Planes& planes, const IsotropicTable& table,
                     const glm::dvec3& n, const glm::dvec3& v, Scratch& s, float* out) {
    // The frame of the normal: the view in the plane of x and z.
    const double cos_v = std::clamp(glm::dot(n, v), 0.0, 1.0);
    const glm::dvec3 across = v - glm::dot(n, v) * n;
    const glm::dvec3 other = std::abs(n.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
    const glm::dvec3 x_axis =
        glm::length(across) > 1e-9 ? glm::normalize(across) : glm::normalize(glm::cross(n, other));
    const glm::dvec3 y_axis = glm::cross(n, x_axis);

    // The table at this view.
    const double place = table.view_intervals * (1 - std::sqrt(std::asin(cos_v) * 2 / pi));
    const int from = std::min(static_cast<int>(place), table.view_intervals - 1);
    const double t = place - from;
    const int row = table.azimuth_intervals + 2;
    const std::size_t plane = size(row) * size(table.light_intervals + 2);
    mix_rows(table.ratio.data(), plane * size(table.channels), from, static_cast<float>(t), s.slice);

    // What to visit: the lobe's cap or the hemisphere, whichever is smaller.
    const auto& low = table.caps[size(from)];
    const auto& high = table.caps[size(from) + 1];
    const double offset = low.centre + t * (high.centre - low.centre);
    double outer = std::max(low.outer, high.outer);
    glm::dvec3 axis = std::cos(offset) * n - std::sin(offset) * x_axis;
    if (outer >= pi / 2) {
        outer = pi / 2;
        axis = n;
    }
    const Centre centre(axis);

    const std::size_t length = nodes.cos_phi.size(), stride = size(nodes.W);
    for (auto* column : {&s.x, &s.y, &s.z}) column->resize(length);
    for (std::size_t j = 0; j < length; ++j) {
        s.x[j] = static_cast<float>(x_axis.x * nodes.cos_phi[j] + x_axis.y * nodes.sin_phi[j]);
        s.y[j] = static_cast<float>(y_axis.x * nodes.cos_phi[j] + y_axis.y * nodes.sin_phi[j]);
        s.z[j] = static_cast<float>(n.x * nodes.cos_phi[j] + n.y * nodes.sin_phi[j]);
    }
    s.weight.resize(3 * stride);
    for (auto* column : {&s.t_light, &s.t_azimuth, &s.scale}) column->resize(stride);
    s.cell.resize(stride);

    const Lookup lookup = {static_cast<float>(std::sqrt(std::max(0.0, 1 - cos_v * cos_v))),
                           static_cast<float>(cos_v),
                           static_cast<float>(table.envelope_intervals),
                           static_cast<float>(table.light_intervals),
                           static_cast<float>(table.azimuth_intervals),
                           row};
    double sum[3] = {};
    for (int i = 0; i < nodes.H; ++i) {
        const Arcs arcs = columns(nodes, centre, {0, outer}, i);
        if (arcs.count == 0) continue;
        const int begin = arcs.arc[0].begin, count = arcs.arc[0].end - begin;
        for (int c = 0; c < table.channels; ++c) std::fill_n(s.weight.data() + size(c) * stride, count, 0.0f);
        for (int a = 0; a < nodes.k; ++a) {
            const std::size_t ring = size(i * nodes.k + a);
            const float rest[3] = {static_cast<float>(nodes.cos_theta[ring] * x_axis.z),
                                   static_cast<float>(nodes.cos_theta[ring] * y_axis.z),
                                   static_cast<float>(nodes.cos_theta[ring] * n.z)};
            for (int b = 0; b < nodes.k; ++b) {
                const std::ptrdiff_t at = b * row_length(nodes.W) + begin;
                look_up(lookup, table.envelope.data(), s.x.data() + at, s.y.data() + at, s.z.data() + at,
                        count, static_cast<float>(nodes.sin_theta[ring]), rest,
                        static_cast<float>(nodes.solid_angle[ring] * nodes.column_weight[size(b)]),
                        s.cell.data(), s.t_light.data(), s.t_azimuth.data(), s.scale.data());
                for (int c = 0; c < table.channels; ++c)
                    add_ratio(s.weight.data() + size(c) * stride, s.slice.data() + size(c) * plane, row,
                              count, s.cell.data(), s.t_light.data(), s.t_azimuth.data(), s.scale.data());
            }
        }
        const std::size_t next = table.channels == 3 ? stride : 0;
        const float* w[3] = {s.weight.data(), s.weight.data() + next, s.weight.data() + 2 * next};
        const float* light[3] = {planes.at(0, i, begin), planes.at(1, i, begin), planes.at(2, i, begin)};
        accumulate(w, light, count, sum);
    }
    for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(sum[c]);
}

// One scratch for each thread; queries are dealt out in small groups and never share a sum.
template <class Query>
void for_each_query(std::size_t count, const Query& query) {
#pragma omp parallel
    {
        Scratch scratch;
#pragma omp for schedule(dynamic, 4)
        for (std::ptrdiff_t q = 0; q < static_cast<std::ptrdiff_t>(count); ++q)
            query(static_cast<std::size_t>(q), scratch);
    }
}

}  // namespace

void integrate_radial(const Picture& picture, const RadialProfile& profile, Band band,
                      std::span<const glm::dvec3> centres, std::span<float> out) {
    const Nodes nodes(picture);
    const Planes planes(picture);
    for_each_query(centres.size(), [&](std::size_t q, Scratch& scratch) {
        radial_query(nodes, planes, centres[q], profile.values.data(), profile.channels, profile.intervals,
                     band, scratch, &out[3 * q]);
    });
}

void integrate_radial_map(const Picture& picture, const RadialProfile& profile, double outer, int map_H,
                          int map_W, std::span<float> out) {
    const Nodes nodes(picture);
    const Planes planes(picture);
    // Columns that are a whole number of the picture's columns apart share a kernel.
    const int step = map_W / std::gcd(map_W, picture.W);
    const std::size_t tasks = size(map_H) * size(step);
    for_each_query(tasks, [&](std::size_t task, Scratch& scratch) {
        const std::size_t i = task / size(step);
        const int begin = static_cast<int>(task % size(step));
        radial_map_row(nodes, planes, profile, outer, pi / map_H * (static_cast<double>(i) + 0.5), begin,
                       step, map_W, scratch, &out[3 * i * size(map_W)]);
    });
}

void integrate_zonal(const Picture& picture, const ZonalProfiles& profiles, std::span<const glm::dvec3> axes,
                     std::span<const double> theta_o, std::span<float> out) {
    const Nodes nodes(picture);
    const Planes planes(picture);
    const std::size_t length = size(profiles.channels * (profiles.intervals + 2));
    for_each_query(axes.size(), [&](std::size_t q, Scratch& scratch) {
        const double place = theta_o[q] / pi * (profiles.rows - 1);
        const int from = std::clamp(static_cast<int>(place), 0, profiles.rows - 2);
        mix_rows(profiles.values.data(), length, from, static_cast<float>(place - from), scratch.profile);
        const Band& low = profiles.bands[size(from)];
        const Band& high = profiles.bands[size(from) + 1];
        const Band band = {std::min(low.inner, high.inner), std::max(low.outer, high.outer)};
        radial_query(nodes, planes, axes[q], scratch.profile.data(), profiles.channels, profiles.intervals,
                     band, scratch, &out[3 * q]);
    });
}

void integrate_isotropic(const Picture& picture, const IsotropicTable& table,
                         std::span<const glm::dvec3> normals, std::span<const glm::dvec3> views,
                         std::span<float> out) {
    const Nodes nodes(picture);
    const Planes planes(picture);
    for_each_query(normals.size(), [&](std::size_t q, Scratch& scratch) {
        isotropic_query(nodes, planes, table, normals[q], views[q], scratch, &out[3 * q]);
    });
}

}  // namespace shrm::angular
