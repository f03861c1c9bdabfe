#include <algorithm>
#include <cmath>
#include <vector>

#include "shrm/angular/angular.hpp"
#include "shrm/angular/caps.hpp"
#include "shrm/angular/queries.hpp"
#include "shrm/angular/sums.hpp"
#include "shrm/angular/texels.hpp"

namespace shrm::angular {
namespace {

// A light at (x, y, z) about the normal, the view at (view.x, 0, view.z): the cell of the
// ratio's table, the place in it, and the envelope times the node's share, zero below the horizon.
struct Lookup {
    float view_x, view_z;
    float envelope_intervals, light_intervals, azimuth_intervals;
    int row;  // length of a row of the slice
};

SHRM_INLINE void look_up(const Lookup& table, const float* __restrict envelope, const float* __restrict X,
                         const float* __restrict Y, const float* __restrict Z, int n, float sin_theta,
                         const float* rest, float share, int* __restrict cell, float* __restrict t_light,
                         float* __restrict t_azimuth, float* __restrict scale) {
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
        scale[j] = (z0 > 0.0f ? share : 0.0f) * e;
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

struct Scratch {
    Reach reach;
    std::vector<float> slice;    // the table at one theta_v
    std::vector<float> x, y, z;  // per column of nodes
    std::vector<float> weight;   // [3][W]
    std::vector<float> t_light, t_azimuth, scale;
    std::vector<int> cell;
};

void isotropic_query(const Nodes& nodes, const Planes& planes, const IsotropicTable& table,
                     const glm::dvec3& normal, const glm::dvec3& view, Scratch& s, float* out) {
    // The table at the view's angle.
    const LocalFrame frame(normal, view);
    const auto& [x_axis, y_axis, n, cos_v] = frame;
    const ViewPlace place(cos_v, table.view_intervals);
    const int row = table.azimuth_intervals + 2;
    const std::size_t plane = size(row) * size(table.light_intervals + 2);
    mix_rows(table.ratio.data(), plane * size(table.channels), place.from, static_cast<float>(place.t),
             s.slice);

    // The texels to visit, and their lights in the normal's frame.
    const Visit visit(frame, place, table.caps);
    s.reach.find(nodes, Center(visit.axis), {0, visit.outer});
    along_columns(nodes, x_axis.x, x_axis.y, 0, s.x);
    along_columns(nodes, y_axis.x, y_axis.y, 0, s.y);
    along_columns(nodes, n.x, n.y, 0, s.z);
    const std::size_t stride = size(round_up(nodes.W, most_lanes));
    s.weight.resize(3 * stride);
    for (auto* column : {&s.t_light, &s.t_azimuth, &s.scale}) column->resize(stride);
    s.cell.resize(stride);

    const Lookup lookup = {static_cast<float>(std::sqrt(std::max(0.0, 1 - cos_v * cos_v))),
                           static_cast<float>(cos_v),
                           static_cast<float>(table.envelope_intervals),
                           static_cast<float>(table.light_intervals),
                           static_cast<float>(table.azimuth_intervals),
                           row};
    // Row by row: the weights of its texels, then their sum.
    Sum sum;
    for (int i = s.reach.first; i < s.reach.last; ++i) {
        const Arcs arcs = s.reach.columns(nodes, i);
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
                        static_cast<float>(nodes.row_share[ring] * nodes.column_share[size(b)]),
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
    sum.write(out);
}

}  // namespace

void integrate_isotropic(const Picture& picture, const IsotropicTable& table,
                         std::span<const glm::dvec3> normals, std::span<const glm::dvec3> views,
                         std::span<float> out) {
    const Nodes nodes(picture);
    const Planes planes(picture);
    for_each_query<Scratch>(normals.size(), [&](std::size_t q, Scratch& s) {
        isotropic_query(nodes, planes, table, normals[q], views[q], s, &out[3 * q]);
    });
}

}  // namespace shrm::angular
