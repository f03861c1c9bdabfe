#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

#include "angular.hpp"
#include "angular_caps.hpp"
#include "angular_lanes.hpp"
#include "angular_profile.hpp"
#include "angular_queries.hpp"
#include "angular_texels.hpp"

namespace shrm::angular {
namespace {

// Half vectors of a row of nodes for one view, each g H, where z = 1 + |g H - g N|^2 as the profile has it:
// sin^2(theta_h / 2) = |H - N|^2 / 4 keeps its accuracy for small angles.
struct HalfVectors {
    const float *x, *y, *z;
};

void half_vectors(const float* __restrict cos_phi, const float* __restrict sin_phi, int n, float sin_theta,
                  float cos_theta, const glm::vec3& view, float g, float* out, std::size_t stride) {
    float* __restrict x = out;
    float* __restrict y = out + stride;
    float* __restrict z = out + 2 * stride;
    const float hz = cos_theta + view.z;
    for (int j = 0; j < n; ++j) {
        const float hx = sin_theta * cos_phi[j] + view.x, hy = sin_theta * sin_phi[j] + view.y;
        const float length2 = hx * hx + hy * hy + hz * hz;
        const float r = g / std::sqrt(length2 > 1e-30f ? length2 : 1e-30f);  // L = -V is below the horizon
        x[j] = r * hx;
        y[j] = r * hy;
        z[j] = r * hz;
    }
}

struct Scratch {
    Reach reach;
    std::vector<float> height;  // N.L of a column at theta = pi/2, less N_z: [k][row_length]
    std::vector<float> half;    // of one arc [3][...]
    std::vector<float> weight;
};

// A light's half vectors depend on the view alone, not on the normal: all normals of a distant view share them.
struct SharedView {
    glm::dvec3 view;
    std::vector<float> half;  // [H * k][k][3][row_length]; empty if few queries have this view

    bool is(const glm::dvec3& v) const { return glm::length(v - view) < 1e-12; }
};

inline constexpr int shared_subsamples = 2;  // more would fill the memory

struct Query {
    glm::vec3 n;  // g N
    float sin_theta, rest;
};

// u where N.L > 0 for a group of lanes from j on.
template <class Profile>
SHRM_INLINE Lanes half_angle(const Profile& u, const HalfVectors& h, const float* height, int j, const Query& q) {
    const Lanes dx = load(h.x + j) - q.n.x, dy = load(h.y + j) - q.n.y, dz = load(h.z + j) - q.n.z;
    const Lanes above = q.sin_theta * load(height + j) + q.rest;
    return only(above > 0.0f, u.anywhere(dz * dz + (dy * dy + (dx * dx + 1.0f))));
}

struct Columns {
    std::vector<float> cos_phi, sin_phi;
    explicit Columns(const Nodes& nodes)
        : cos_phi(nodes.cos_phi.begin(), nodes.cos_phi.end()),
          sin_phi(nodes.sin_phi.begin(), nodes.sin_phi.end()) {}
};

// What all queries use.
struct Setting {
    Nodes nodes;
    Planes planes;
    Columns columns;
    float g;
    SharedView shared;

    Setting(const Picture& picture, const RadialProfile& profile, const glm::dvec3& view)
        : nodes(picture),
          planes(picture),
          columns(nodes),
          g(static_cast<float>(0.5 * std::sqrt(profile.scale))),
          shared{view, {}} {}
};

void share(Setting& setting) {
    const auto& [nodes, planes, columns, g, shared] = setting;
    const int length = row_length(nodes.W), rows = nodes.H * nodes.k;
    setting.shared.half.resize(3 * size(rows) * size(nodes.k) * planes.length);
#pragma omp parallel for
    for (int row = 0; row < rows; ++row)
        for (int b = 0; b < nodes.k; ++b)
            half_vectors(columns.cos_phi.data() + b * length, columns.sin_phi.data() + b * length, length,
                         static_cast<float>(nodes.sin_theta[size(row)]),
                         static_cast<float>(nodes.cos_theta[size(row)]), glm::vec3(shared.view), g,
                         setting.shared.half.data() + 3 * size(row * nodes.k + b) * planes.length, planes.length);
}

// A query's texels, for a view that is shared and one node to a texel: nothing but rows of the innermost loop.
template <bool held>
void sum_shared(const Setting& setting, const RadialProfile& profile, const glm::dvec3& normal, const Scratch& s,
                float* out) {
    const auto& [nodes, planes, columns, g, shared] = setting;
    const Cubics<held> u(profile, 0);
    Query q = {glm::vec3(static_cast<double>(g) * normal), 0, 0};
    Sum sum;
    Lanes single[3] = {};
    int terms = 0;
    for (int i = s.reach.first; i < s.reach.last; ++i) {
        const Arcs arcs = s.reach.columns(nodes, i);
        if (arcs.count == 0) continue;
        const int begin = arcs.arc[0].begin, n = arcs.arc[0].end - begin;
        const float* first = planes.at(0, i, begin);
        const float* light[3] = {first, first + planes.stride, first + 2 * planes.stride};
        const float* h = shared.half.data() + 3 * size(i) * planes.length + begin;
        q.sin_theta = static_cast<float>(nodes.sin_theta[size(i)]);
        q.rest = static_cast<float>(nodes.cos_theta[size(i)] * normal.z);
        const HalfVectors vectors = {h, h + planes.length, h + 2 * planes.length};
        const float* height = s.height.data() + begin;
        sum_weighted([&](int j) { return half_angle(u, vectors, height, j, q); }, light, n, single);
        terms += n / width + 1;
        if (terms > terms_in_single) {
            sum.add(single);
            terms = 0;
        }
    }
    sum.add(single);
    sum.write(out);
}

// The same for any number of nodes and any view.
template <bool held>
void sum_any(const Setting& setting, const RadialProfile& profile, const glm::dvec3& normal,
             const glm::dvec3& view, Scratch& s, float* out) {
    const auto& [nodes, planes, columns, g, shared] = setting;
    const Cubics<held> u(profile, 0);
    const bool tabulated = !shared.half.empty() && shared.is(view);
    const int length = row_length(nodes.W);
    s.half.resize(3 * size(length));
    s.weight.resize(size(length));
    const float* w[3] = {s.weight.data(), s.weight.data(), s.weight.data()};
    Query q = {glm::vec3(static_cast<double>(g) * normal), 0, 0};
    Sum sum;
    for (int i = s.reach.first; i < s.reach.last; ++i) {
        const Arcs arcs = s.reach.columns(nodes, i);
        if (arcs.count == 0) continue;
        const int begin = arcs.arc[0].begin, n = arcs.arc[0].end - begin;
        std::fill_n(s.weight.data(), round_up(n, width), 0.0f);
        for (int node = i * nodes.k; node < (i + 1) * nodes.k; ++node)
            for (int b = 0; b < nodes.k; ++b) {
                const std::size_t row = size(node), column = size(b * length + begin);
                q.sin_theta = static_cast<float>(nodes.sin_theta[row]);
                q.rest = static_cast<float>(nodes.cos_theta[row] * normal.z);
                const float* h = s.half.data();
                if (tabulated)
                    h = shared.half.data() + 3 * (row * size(nodes.k) + size(b)) * planes.length + begin;
                else
                    half_vectors(columns.cos_phi.data() + column, columns.sin_phi.data() + column,
                                 round_up(n, width), q.sin_theta, static_cast<float>(nodes.cos_theta[row]),
                                 glm::vec3(view), g, s.half.data(), planes.length);
                const HalfVectors vectors = {h, h + planes.length, h + 2 * planes.length};
                const float share = static_cast<float>(nodes.row_share[row] * nodes.column_share[size(b)]);
                for (int j = 0; j < n; j += width)
                    store(s.weight.data() + j, load(s.weight.data() + j) +
                                                   share * half_angle(u, vectors, s.height.data() + column, j, q));
            }
        const float* light[3] = {planes.at(0, i, begin), planes.at(1, i, begin), planes.at(2, i, begin)};
        accumulate(w, light, n, sum);
    }
    sum.write(out);
}

template <bool held>
void half_angles(const Picture& picture, const RadialProfile& profile, std::span<const Cap> caps,
                 std::span<const glm::dvec3> normals, std::span<const glm::dvec3> views,
                 std::span<float> out) {
    if (normals.empty()) return;
    Setting setting(picture, profile, views[0]);
    SharedView& shared = setting.shared;
    const auto same = std::count_if(views.begin(), views.end(), [&](const auto& v) { return shared.is(v); });
    if (picture.subsamples <= shared_subsamples && same > 1) share(setting);
    for_each_query<Scratch>(normals.size(), [&](std::size_t q, Scratch& s) {
        const LocalFrame frame(normals[q], views[q]);
        const Visit visit(frame, ViewPlace(frame.cos_v, static_cast<int>(caps.size()) - 1), caps);
        s.reach.find(setting.nodes, Centre(visit.axis), {0, visit.outer});
        along_columns(setting.nodes, normals[q].x, normals[q].y, 0, s.height);
        if (picture.subsamples == 1 && !shared.half.empty() && shared.is(views[q]))
            sum_shared<held>(setting, profile, normals[q], s, &out[3 * q]);
        else
            sum_any<held>(setting, profile, normals[q], views[q], s, &out[3 * q]);
    });
}

}  // namespace

void integrate_half_angle(const Picture& picture, const RadialProfile& profile, std::span<const Cap> caps,
                          std::span<const glm::dvec3> normals, std::span<const glm::dvec3> views,
                          std::span<float> out) {
    const auto integrate = profile.segments == held_segments ? half_angles<true> : half_angles<false>;
    integrate(picture, profile, caps, normals, views, out);
}

}  // namespace shrm::angular
