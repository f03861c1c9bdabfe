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

// g H of the lights of a row of nodes, as HalfVectors, for one view.
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

struct Columns {
    std::vector<float> cos_phi, sin_phi;
    explicit Columns(const Nodes& nodes)
        : cos_phi(nodes.cos_phi.begin(), nodes.cos_phi.end()),
          sin_phi(nodes.sin_phi.begin(), nodes.sin_phi.end()) {}
};

// One query: the texels that it visits, N.L of a column at theta = pi/2 less N_z [k][row_length], and its
// sum.
struct Visited {
    glm::dvec3 normal, view;
    glm::vec3 scaled;  // g N
    Reach reach;
    bool cut;  // by the horizon; else the height is not needed
    std::vector<float> height;
    Lanes single[3];
    int terms;
    Sum sum;

    void find(const Nodes& nodes, const Columns& columns, std::span<const Cap> caps, const glm::dvec3& n,
              const glm::dvec3& v, float g) {
        normal = n;
        view = v;
        scaled = glm::vec3(static_cast<double>(g) * n);
        const LocalFrame frame(n, v);
        const Visit visit(frame, ViewPlace(frame.cos_v, static_cast<int>(caps.size()) - 1), caps);
        reach.find(nodes, Centre(visit.axis), {0, visit.outer});
        cut = visit.outer + std::acos(std::clamp(glm::dot(n, visit.axis), -1.0, 1.0)) > pi / 2 - 1e-6;
        if (cut) {
            height.resize(columns.cos_phi.size());
            const glm::vec3 m(n);
            for (std::size_t j = 0; j < height.size(); ++j)
                height[j] = m.x * columns.cos_phi[j] + m.y * columns.sin_phi[j];
        }
        for (Lanes& part : single) part = Lanes{};
        terms = 0;
        sum = Sum();
    }
};

// Queries at once: rows of the picture and of its half vectors, which are more than a cache holds, serve them
// all.
inline constexpr int queries_at_once = 16;

struct Scratch {
    Visited visited[queries_at_once];
    std::vector<float> half;    // of one arc [3][row_length]
    std::vector<float> weight;  // of one arc
};

// A light's half vectors depend on the view alone, not on the normal: all normals of a distant view share
// them.
struct SharedView {
    glm::dvec3 view;
    std::vector<float> half;  // [H * k][k][3][row_length]; empty if few queries have this view

    bool is(const glm::dvec3& v) const { return glm::length(v - view) < 1e-12; }
};

inline constexpr int shared_subsamples = 2;  // more would fill the memory

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
                         setting.shared.half.data() + 3 * size(row * nodes.k + b) * planes.length,
                         planes.length);
}

// A query's texels in row i, for a view that is shared and one node to a texel: the innermost loop alone.
template <class Profile>
SHRM_INLINE void sum_shared(const Setting& setting, const Profile& u, int i, Visited& of) {
    const auto& [nodes, planes, columns, g, shared] = setting;
    if (i < of.reach.first || i >= of.reach.last) return;
    const Arcs arcs = of.reach.columns(nodes, i);
    if (arcs.count == 0) return;
    const int begin = arcs.arc[0].begin, n = arcs.arc[0].end - begin;
    const float* first = planes.at(0, i, begin);
    const float* light[3] = {first, first + planes.stride, first + 2 * planes.stride};
    const float* h = shared.half.data() + 3 * size(i) * planes.length + begin;
    const HalfVectors vectors = {h, h + planes.length, h + 2 * planes.length};
    const float* height = of.cut ? of.height.data() + begin : nullptr;
    const HalfAngleRow row = {of.scaled, static_cast<float>(nodes.sin_theta[size(i)]),
                              static_cast<float>(nodes.cos_theta[size(i)] * of.normal.z)};
    if (of.cut)
        sum_weighted([&](int j) { return half_angle<true>(u, vectors, height, j, row); }, light, n,
                     of.single);
    else
        sum_weighted([&](int j) { return half_angle<false>(u, vectors, height, j, row); }, light, n,
                     of.single);
    of.terms += n / width + 1;
    if (of.terms > terms_in_single) {
        of.sum.add(of.single);
        of.terms = 0;
    }
}

// All its texels, for any number of nodes and any view.
template <class Profile>
void sum_any(const Setting& setting, const Profile& u, Visited& of, Scratch& s) {
    const auto& [nodes, planes, columns, g, shared] = setting;
    const bool tabulated = !shared.half.empty() && shared.is(of.view);
    const int length = row_length(nodes.W);
    s.half.resize(3 * size(length));
    s.weight.resize(size(length));
    const float* w[3] = {s.weight.data(), s.weight.data(), s.weight.data()};
    HalfAngleRow at = {of.scaled, 0, 0};
    for (int i = of.reach.first; i < of.reach.last; ++i) {
        const Arcs arcs = of.reach.columns(nodes, i);
        if (arcs.count == 0) continue;
        const int begin = arcs.arc[0].begin, n = arcs.arc[0].end - begin;
        std::fill_n(s.weight.data(), round_up(n, width), 0.0f);
        for (int node = i * nodes.k; node < (i + 1) * nodes.k; ++node)
            for (int b = 0; b < nodes.k; ++b) {
                const std::size_t row = size(node), column = size(b * length + begin);
                at.sin_theta = static_cast<float>(nodes.sin_theta[row]);
                at.rest = static_cast<float>(nodes.cos_theta[row] * of.normal.z);
                const float* h = s.half.data();
                if (tabulated)
                    h = shared.half.data() + 3 * (row * size(nodes.k) + size(b)) * planes.length + begin;
                else
                    half_vectors(columns.cos_phi.data() + column, columns.sin_phi.data() + column,
                                 round_up(n, width), at.sin_theta, static_cast<float>(nodes.cos_theta[row]),
                                 glm::vec3(of.view), g, s.half.data(), planes.length);
                const HalfVectors vectors = {h, h + planes.length, h + 2 * planes.length};
                const float share = static_cast<float>(nodes.row_share[row] * nodes.column_share[size(b)]);
                for (int j = 0; j < n; j += width) {
                    const Lanes u_j = of.cut ? half_angle<true>(u, vectors, of.height.data() + column, j, at)
                                             : half_angle<false>(u, vectors, nullptr, j, at);
                    store(s.weight.data() + j, load(s.weight.data() + j) + share * u_j);
                }
            }
        const float* light[3] = {planes.at(0, i, begin), planes.at(1, i, begin), planes.at(2, i, begin)};
        accumulate(w, light, n, of.sum);
    }
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
    const std::size_t blocks = (normals.size() + queries_at_once - 1) / queries_at_once;
    for_each_query<Scratch>(blocks, [&](std::size_t block, Scratch& s) {
        const Cubics<held> u(profile, 0);
        const std::size_t from = block * queries_at_once,
                          count = std::min<std::size_t>(queries_at_once, normals.size() - from);
        int first = picture.H, last = 0;
        for (std::size_t k = 0; k < count; ++k) {
            Visited& of = s.visited[k];
            of.find(setting.nodes, setting.columns, caps, normals[from + k], views[from + k], setting.g);
            if (picture.subsamples > 1 || shared.half.empty() || !shared.is(of.view)) {
                sum_any(setting, u, of, s);
                of.reach.last = of.reach.first;
            }
            first = std::min(first, of.reach.first);
            last = std::max(last, of.reach.last);
        }
        for (int i = first; i < last; ++i)
            for (std::size_t k = 0; k < count; ++k) sum_shared(setting, u, i, s.visited[k]);
        for (std::size_t k = 0; k < count; ++k) {
            s.visited[k].sum.add(s.visited[k].single);
            s.visited[k].sum.write(&out[3 * (from + k)]);
        }
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
