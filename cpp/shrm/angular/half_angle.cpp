#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

#include "shrm/angular/angular.hpp"
#include "shrm/angular/caps.hpp"
#include "shrm/angular/profile.hpp"
#include "shrm/angular/queries.hpp"
#include "shrm/angular/sums.hpp"
#include "shrm/angular/texels.hpp"

namespace shrm::angular {
namespace {

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
    bool tabulated;
    std::vector<float> height;
    Floats single[3];
    int terms;
    Sum sum;

    void find(const Nodes& nodes, const Columns& columns, std::span<const Cap> caps, const glm::dvec3& n,
              const glm::dvec3& v, float g) {
        normal = n;
        view = v;
        scaled = glm::vec3(static_cast<double>(g) * n);
        const LocalFrame frame(n, v);
        const Visit visit(frame, ViewPlace(frame.cos_v, static_cast<int>(caps.size()) - 1), caps);
        reach.find(nodes, Center(visit.axis), {0, visit.outer});
        cut = visit.outer + std::acos(std::clamp(glm::dot(n, visit.axis), -1.0, 1.0)) > pi / 2 - 1e-6;
        if (cut) {
            height.resize(columns.cos_phi.size());
            const glm::vec3 m(n);
            for (std::size_t j = 0; j < height.size(); ++j)
                height[j] = m.x * columns.cos_phi[j] + m.y * columns.sin_phi[j];
        }
        for (Floats& part : single) part = Floats{};
        terms = 0;
        sum = Sum();
    }
};

// Queries at once: rows of the picture and of its half vectors are read once for all of them.
inline constexpr int queries_at_once = 16;

struct Scratch {
    Visited visited[queries_at_once];
    std::vector<float> weight;  // of one arc
};

// A light's half vectors depend on the view alone, not on the normal: all normals of a distant view share
// them.
struct SharedView {
    glm::dvec3 view;
    std::vector<float> half;  // [H * k][k][3][row_length]; empty unless it is shared

    bool is(const glm::dvec3& v) const { return glm::length(v - view) < 1e-12; }
};

// The arrays and the lobe that all queries use.
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

    bool tabulates(const glm::dvec3& view) const { return !shared.half.empty() && shared.is(view); }

    // Half vectors of row `node` and column b of nodes, from column `begin` of the picture on.
    ComputedHalfVectors computed(const glm::dvec3& view, int node, int b, int begin) const {
        const std::size_t at = size(b * row_length(nodes.W) + begin);
        return {columns.cos_phi.data() + at,
                columns.sin_phi.data() + at,
                static_cast<float>(nodes.sin_theta[size(node)]),
                static_cast<float>(nodes.cos_theta[size(node)] + view.z),
                glm::vec3(view),
                g};
    }
    TabulatedHalfVectors tabulated(int node, int b, int begin) const {
        const float* h = shared.half.data() + 3 * size(node * nodes.k + b) * planes.length + begin;
        return {h, h + planes.length, h + 2 * planes.length};
    }
};

void tabulate_half_vectors(Setting& setting) {
    const int length = row_length(setting.nodes.W), rows = setting.nodes.H * setting.nodes.k;
    setting.shared.half.resize(3 * size(rows) * size(setting.nodes.k) * size(length));
#pragma omp parallel for
    for (int row = 0; row < rows; ++row)
        for (int b = 0; b < setting.nodes.k; ++b) {
            const ComputedHalfVectors half_vectors = setting.computed(setting.shared.view, row, b, 0);
            float* out = setting.shared.half.data() + 3 * size(row * setting.nodes.k + b) * size(length);
            for (int j = 0; j < length; j += lanes) {
                const int from =
                    std::min(j, length - lanes);  // the last group may begin within the one before
                const HalfVectors h = half_vectors.at(from);
                store(out + from, h.x);
                store(out + length + from, h.y);
                store(out + 2 * length + from, h.z);
            }
        }
}

// True if a table of half vectors pays: its queries visit several times as many nodes as it has, and it fits
// the last cache beside the picture. In memory it would take as long to read as half vectors to compute.
bool worth_sharing(const Setting& setting, std::span<const Cap> caps, std::span<const glm::dvec3> views) {
    constexpr double times = 4, bytes = 1 << 23;
    const Nodes& nodes = setting.nodes;
    const double table =
        3 * sizeof(float) * static_cast<double>(nodes.cos_phi.size() * nodes.cos_theta.size());
    double outer = 0;
    for (const Cap& cap : caps) outer = std::max(outer, std::min(cap.outer, pi / 2));
    const auto same =
        std::count_if(views.begin(), views.end(), [&](const auto& v) { return setting.shared.is(v); });
    return table <= bytes && 0.5 * (1 - std::cos(outer)) * static_cast<double>(same) > times;
}

// A query's texels in row i, one node to each: the innermost loop alone.
template <class Profile, class Source>
SHRM_INLINE void sum_row(const Setting& setting, const Profile& u, const Source& half_vectors, int i,
                         int begin, int n, Visited& query) {
    const auto& [nodes, planes, columns, g, shared] = setting;
    const float* first = planes.at(0, i, begin);
    const float* light[3] = {first, first + planes.stride, first + 2 * planes.stride};
    const float* height = query.cut ? query.height.data() + begin : nullptr;
    const HalfAngleRow row = {query.scaled, static_cast<float>(nodes.sin_theta[size(i)]),
                              static_cast<float>(nodes.cos_theta[size(i)] * query.normal.z)};
    if (query.cut)
        sum_weighted([&](int j) { return half_angle<true>(u, half_vectors, height, j, row); }, light, n,
                     query.single);
    else
        sum_weighted([&](int j) { return half_angle<false>(u, half_vectors, height, j, row); }, light, n,
                     query.single);
    query.terms += n / lanes + 1;
    if (query.terms > terms_in_single) {
        query.sum.add(query.single);
        query.terms = 0;
    }
}

// Row i of queries with one node to a texel.
template <class Profile>
void sum_rows(const Setting& setting, const Profile& u, int i, std::span<Visited> queries) {
    for (Visited& query : queries) {
        if (i < query.reach.first || i >= query.reach.last) continue;
        const Arcs arcs = query.reach.columns(setting.nodes, i);
        if (arcs.count == 0) continue;
        const int begin = arcs.arc[0].begin, n = arcs.arc[0].end - begin;
        if (query.tabulated)
            sum_row(setting, u, setting.tabulated(i, 0, begin), i, begin, n, query);
        else
            sum_row(setting, u, setting.computed(query.view, i, 0, begin), i, begin, n, query);
    }
}

// weight[j] += share * u of n nodes of a row from column `begin` on.
template <class Profile, class Source>
SHRM_INLINE void weigh(const Profile& u, const Source& half_vectors, const Visited& query,
                       const float* height, const HalfAngleRow& row, float share, int n, float* weight) {
    for (int j = 0; j < n; j += lanes) {
        const Floats u_j = query.cut ? half_angle<true>(u, half_vectors, height, j, row)
                                     : half_angle<false>(u, half_vectors, height, j, row);
        store(weight + j, load(weight + j) + share * u_j);
    }
}

// Row i of a query with any number of nodes to a texel.
template <class Profile>
void sum_nodes(const Setting& setting, const Profile& u, int i, Visited& query, std::vector<float>& weight) {
    const auto& [nodes, planes, columns, g, shared] = setting;
    const Arcs arcs = query.reach.columns(nodes, i);
    if (arcs.count == 0) return;
    const int begin = arcs.arc[0].begin, n = arcs.arc[0].end - begin;
    weight.assign(size(round_up(n, lanes)), 0.0f);
    for (int node = i * nodes.k; node < (i + 1) * nodes.k; ++node)
        for (int b = 0; b < nodes.k; ++b) {
            const std::size_t row = size(node);
            const HalfAngleRow at = {query.scaled, static_cast<float>(nodes.sin_theta[row]),
                                     static_cast<float>(nodes.cos_theta[row] * query.normal.z)};
            const float* height = query.cut ? query.height.data() + b * row_length(nodes.W) + begin : nullptr;
            const float share = static_cast<float>(nodes.row_share[row] * nodes.column_share[size(b)]);
            if (query.tabulated)
                weigh(u, setting.tabulated(node, b, begin), query, height, at, share, n, weight.data());
            else
                weigh(u, setting.computed(query.view, node, b, begin), query, height, at, share, n,
                      weight.data());
        }
    const float* w[3] = {weight.data(), weight.data(), weight.data()};
    const float* light[3] = {planes.at(0, i, begin), planes.at(1, i, begin), planes.at(2, i, begin)};
    accumulate(w, light, n, query.sum);
}

template <bool held>
void half_angles(const Picture& picture, const RadialProfile& profile, std::span<const Cap> caps,
                 std::span<const glm::dvec3> normals, std::span<const glm::dvec3> views, bool share,
                 std::span<float> out) {
    if (normals.empty()) return;
    Setting setting(picture, profile, views[0]);
    if (share && worth_sharing(setting, caps, views)) tabulate_half_vectors(setting);
    const std::size_t blocks = (normals.size() + queries_at_once - 1) / queries_at_once;
    for_each_query<Scratch>(blocks, [&](std::size_t block, Scratch& s) {
        // The caps that the block's queries visit, and the rows of all
        const Cubics<held> u(profile, 0);
        const std::size_t from = block * queries_at_once,
                          count = std::min<std::size_t>(queries_at_once, normals.size() - from);
        const std::span<Visited> queries(s.visited, count);
        int first = picture.H, last = 0;
        for (std::size_t k = 0; k < count; ++k) {
            Visited& query = queries[k];
            query.find(setting.nodes, setting.columns, caps, normals[from + k], views[from + k], setting.g);
            query.tabulated = setting.tabulates(query.view);
            first = std::min(first, query.reach.first);
            last = std::max(last, query.reach.last);
        }
        // The picture row by row, for all queries together if each texel has one node.
        if (picture.subsamples == 1) {
            for (int i = first; i < last; ++i) sum_rows(setting, u, i, queries);
        } else {
            for (Visited& query : queries)
                for (int i = query.reach.first; i < query.reach.last; ++i)
                    sum_nodes(setting, u, i, query, s.weight);
        }
        for (std::size_t k = 0; k < count; ++k) {
            queries[k].sum.add(queries[k].single);
            queries[k].sum.write(&out[3 * (from + k)]);
        }
    });
}

}  // namespace

void integrate_half_angle(const Picture& picture, const RadialProfile& profile, std::span<const Cap> caps,
                          std::span<const glm::dvec3> normals, std::span<const glm::dvec3> views, bool share,
                          std::span<float> out) {
    const auto integrate = profile.segments == held_segments ? half_angles<true> : half_angles<false>;
    integrate(picture, profile, caps, normals, views, share, out);
}

}  // namespace shrm::angular
