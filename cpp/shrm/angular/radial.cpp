#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "shrm/angular/angular.hpp"
#include "shrm/angular/profile.hpp"
#include "shrm/angular/queries.hpp"
#include "shrm/angular/sums.hpp"
#include "shrm/angular/texels.hpp"

namespace shrm::angular {
namespace {

// ---- One center: what it visits, and the sum

// An arc of a row of texels, from column `begin` in [0, W).
struct Row {
    int i, begin, count;
};

// The rows of texels about a center, and what gives z = ring + span azimuth at their nodes.
struct Visited {
    std::vector<Row> rows;
    std::vector<float> ring, span;  // [H * k]
    std::vector<float> azimuth;     // sin^2((phi - phi_C)/2), [k][row_length]
    Reach reach;

    void find(const Nodes& nodes, const RadialProfile& profile, double outer, const glm::dvec3& axis) {
        const Center center(axis);
        along_columns(nodes, -0.5 * std::cos(center.phi), -0.5 * std::sin(center.phi), 0.5, azimuth);
        for (float& a : azimuth) a = a > 0 ? a : 0;
        reach.find(nodes, center, {0, std::min(outer, profile.support)});
        ring.resize(nodes.cos_theta.size());
        span.resize(ring.size());
        for (std::size_t row = size(reach.first * nodes.k); row < size(reach.last * nodes.k); ++row) {
            ring[row] = static_cast<float>(1 + profile.scale * center.ring(nodes, row));
            span[row] = static_cast<float>(profile.scale * center.span(nodes, row));
        }
        rows.clear();
        for (int i = reach.first; i < reach.last; ++i) {
            const Arcs arcs = reach.columns(nodes, i);
            if (arcs.count > 0) rows.push_back({i, arcs.arc[0].begin, arcs.arc[0].end - arcs.arc[0].begin});
        }
    }
};

struct Scratch {
    Visited cap;
    std::vector<float> weight;
};

// weight[j] = the profile's mean over texel j of n in a row of a cap, readable in whole groups of lanes.
template <bool held>
SHRM_INLINE void weigh(const Nodes& nodes, const Cubics<held>& u, const Visited& cap, const Row& row,
                       float* weight) {
    std::fill_n(weight, round_up(row.count, lanes), 0.0f);
    for (int a = 0; a < nodes.k; ++a) {
        const std::size_t node = size(row.i * nodes.k + a);
        for (int b = 0; b < nodes.k; ++b) {
            const float* azimuth = cap.azimuth.data() + b * row_length(nodes.W) + row.begin;
            const float share = static_cast<float>(nodes.row_share[node] * nodes.column_share[size(b)]);
            for (int j = 0; j < row.count; j += lanes) {
                const Floats z = cap.ring[node] + cap.span[node] * load(azimuth + j);
                store(weight + j, load(weight + j) + share * u.anywhere(z));
            }
        }
    }
}

// The sum where every texel has one node and one weight: nothing but rows of the innermost loop.
template <bool held>
void sum_texels(const Planes& planes, const RadialProfile& profile, const Visited& cap, float* out) {
    const Cubics<held> u(profile, 0);
    Sum sum;
    Floats single[3] = {};
    int terms = 0;
    for (const Row& row : cap.rows) {
        const float* first = planes.at(0, row.i, row.begin);
        const float* light[3] = {first, first + planes.stride, first + 2 * planes.stride};
        sum_arc(u, cap.azimuth.data() + row.begin, light, row.count, cap.ring[size(row.i)],
                cap.span[size(row.i)], single);
        terms += row.count / lanes + 1;
        if (terms > terms_in_single) {
            sum.add(single);
            terms = 0;
        }
    }
    sum.add(single);
    sum.write(out);
}

// The same for any number of nodes and channels.
template <bool held>
void sum_weights(const Nodes& nodes, const Planes& planes, const RadialProfile& profile, Scratch& s,
                 float* out) {
    const int stride = round_up(nodes.W, most_lanes);
    s.weight.resize(size(3 * stride));
    const float* w[3];
    for (int c = 0; c < 3; ++c) w[c] = s.weight.data() + (c < profile.channels ? c : 0) * stride;
    Sum sum;
    for (const Row& row : s.cap.rows) {
        const float* light[3] = {planes.at(0, row.i, row.begin), planes.at(1, row.i, row.begin),
                                 planes.at(2, row.i, row.begin)};
        for (int c = 0; c < profile.channels; ++c)
            weigh(nodes, Cubics<held>(profile, c), s.cap, row, s.weight.data() + c * stride);
        accumulate(w, light, row.count, sum);
    }
    sum.write(out);
}

bool one_weight(const Nodes& nodes, const RadialProfile& profile) {
    return nodes.k == 1 && profile.channels == 1;
}

template <bool held>
void integrate_center(const Nodes& nodes, const Planes& planes, const RadialProfile& profile, double outer,
                      const glm::dvec3& axis, Scratch& s, float* out) {
    s.cap.find(nodes, profile, outer, axis);
    if (one_weight(nodes, profile))
        sum_texels<held>(planes, profile, s.cap, out);
    else
        sum_weights<held>(nodes, planes, profile, s, out);
}

// ---- A whole map: neighboring columns of a row at once

struct Map {
    int H, W;
    glm::dvec3 center(int i, int j) const {
        const double theta = pi / H * (i + 0.5), phi = pi - 2 * pi / W * (j + 0.5);
        return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
    }
};

// The columns of a picture sorted by their remainder, columns_apart of them, so that the texels under
// neighboring columns of the map are neighbors: [H][channel][remainder][length].
struct Sorted {
    int columns_apart, period, length;
    std::vector<float> values;

    Sorted(const Picture& picture, int apart, int more)
        : columns_apart(apart), period(picture.W / apart), length(2 * period + more) {
        const Planes planes(picture);
        values.resize(size(picture.H * 3 * apart) * size(length));
#pragma omp parallel for
        for (int i = 0; i < picture.H; ++i)
            for (int c = 0; c < 3; ++c)
                for (int r = 0; r < apart; ++r) {
                    const float* from = planes.at(c, i, r);
                    float* to = values.data() + size((i * 3 + c) * apart + r) * size(length);
                    for (int x = 0; x < period; ++x) to[x] = from[x * apart];
                    for (int x = period; x < length; ++x) to[x] = to[x - period];
                }
    }
    SHRM_INLINE const float* at(int i, int channel, int column) const {
        const int remainder = column % columns_apart;
        return values.data() + size((i * 3 + channel) * columns_apart + remainder) * size(length) +
               column / columns_apart;
    }
};

// Columns first, first + step, ... of row i of the map, angle and profile evaluated for every pair of texels.
template <bool held>
void every_pair(const Nodes& nodes, const Sorted& light, const RadialProfile& profile, double outer,
                const Map& map, int i, int first, int step, Visited& cap, float* out) {
    const int apart = light.columns_apart;
    const Cubics<held> u(profile, 0);
    cap.find(nodes, profile, outer, map.center(i, first));
    for (int t = 0; t < light.period; t += lanes) {
        Sum sum;
        Floats single[3] = {};
        int terms = 0;
        for (const Row& row : cap.rows) {
            const Floats ring = splat(cap.ring[size(row.i)]), span = splat(cap.span[size(row.i)]);
            const int moved = row.begin + t * apart, column = moved < nodes.W ? moved : moved - nodes.W;
            for (int j = 0; j < std::min(apart, row.count); ++j) {
                const float* at[3];
                for (int c = 0; c < 3; ++c) at[c] = light.at(row.i, c, column + j);
                sum_turned(u, cap.azimuth.data() + row.begin + j, apart, at,
                           (row.count - j + apart - 1) / apart, ring, span, single);
            }
            terms += row.count;
            if (terms > terms_in_single) {
                sum.add(single);
                terms = 0;
            }
        }
        sum.add(single);
        for (int x = 0; x < lanes && t + x < light.period; ++x)
            for (int c = 0; c < 3; ++c)
                out[(i * map.W + first + (t + x) * step) * 3 + c] = static_cast<float>(sum.total[c][x]);
    }
}

// Rows and columns of the map that are summed at once by symmetry: 12 accumulators in registers, with each
// load of the picture serving two rows and each of the kernels two groups of columns.
inline constexpr int map_rows = 2, map_groups = 2;

struct SlideScratch {
    Visited cap[map_rows];
    std::vector<Row> rows;      // the widest of the caps' arcs, which all have one middle
    std::vector<float> kernel;  // for each row [map_rows][channel][count]
    std::vector<float> weight;
};

// The kernels of neighboring rows of the map, each 0 where its own cap ends.
template <bool held>
void find_kernels(const Nodes& nodes, const RadialProfile& profile, SlideScratch& s) {
    s.rows.clear();
    s.kernel.clear();
    s.weight.resize(size(round_up(nodes.W, most_lanes)));
    // The place of each cap in its own list of rows
    const Row* own[map_rows] = {};
    const Row* end[map_rows] = {};
    for (int r = 0; r < map_rows; ++r) {
        own[r] = s.cap[r].rows.data();
        end[r] = own[r] + s.cap[r].rows.size();
    }
    // Every row of the picture that any of them visits.
    for (int i = 0; i < nodes.H; ++i) {
        const Row* here[map_rows] = {};
        Row widest = {i, 0, 0};
        for (int r = 0; r < map_rows; ++r)
            if (own[r] != end[r] && own[r]->i == i) {
                here[r] = own[r]++;
                if (here[r]->count > widest.count) widest = *here[r];
            }
        if (widest.count == 0) continue;
        s.rows.push_back(widest);
        for (int r = 0; r < map_rows; ++r)
            for (int c = 0; c < profile.channels; ++c) {
                const std::size_t at = s.kernel.size();
                s.kernel.resize(at + size(widest.count), 0.0f);
                if (here[r] == nullptr) continue;
                weigh(nodes, Cubics<held>(profile, c), s.cap[r], *here[r], s.weight.data());
                const int inset = (here[r]->begin - widest.begin + nodes.W) % nodes.W;
                std::copy_n(s.weight.data(), here[r]->count, s.kernel.data() + at + size(inset));
            }
    }
}

typedef Floats Block[map_rows][map_groups][3];

template <int channels>
SHRM_INLINE void slide_row(const Sorted& light, const Row& row, int column, const float* kernel, Block& sum) {
    const int apart = light.columns_apart;
    for (int first = 0; first < std::min(apart, row.count); ++first) {
        const float* at[3];
        for (int c = 0; c < 3; ++c) at[c] = light.at(row.i, c, column + first);
        int x = 0;
        for (int j = first; j < row.count; j += apart, ++x)
            for (int c = 0; c < 3; ++c) {
                Floats l[map_groups];
                for (int g = 0; g < map_groups; ++g) l[g] = load_once(at[c] + x + g * lanes);
                for (int r = 0; r < map_rows; ++r) {
                    const float w = kernel[(r * channels + (channels == 3 ? c : 0)) * row.count + j];
                    for (int g = 0; g < map_groups; ++g) sum[r][g][c] += w * l[g];
                }
            }
    }
}

// map_groups groups of columns, the first of them turned by `turn` columns of the picture.
template <int channels>
void slide_block(const Sorted& light, const SlideScratch& s, int W, int turn,
                 double total[map_rows][map_groups][3][lanes]) {
    const float* kernel = s.kernel.data();
    for (std::size_t k = 0; k < s.rows.size();) {
        Block sum = {};
        for (int terms = 0; k < s.rows.size() && terms < terms_in_single; ++k) {
            const Row& row = s.rows[k];
            const int moved = row.begin + turn;
            slide_row<channels>(light, row, moved < W ? moved : moved - W, kernel, sum);
            kernel += map_rows * channels * row.count;
            terms += row.count;
        }
        for (int r = 0; r < map_rows; ++r)
            for (int g = 0; g < map_groups; ++g)
                for (int c = 0; c < 3; ++c) add_in_double(sum[r][g][c], total[r][g][c]);
    }
}

// Columns first, first + step, ... of the rows of the map from `top` on.
template <bool held>
void slide(const Nodes& nodes, const Sorted& light, const RadialProfile& profile, double outer,
           const Map& map, int top, int first, int step, SlideScratch& s, float* out) {
    const int rows = std::min(map_rows, map.H - top);
    for (int r = 0; r < map_rows; ++r)
        if (r < rows)
            s.cap[r].find(nodes, profile, outer, map.center(top + r, first));
        else
            s.cap[r].rows.clear();
    find_kernels<held>(nodes, profile, s);
    for (int t = 0; t < light.period; t += map_groups * lanes) {
        double total[map_rows][map_groups][3][lanes] = {};
        const auto sum = profile.channels == 3 ? slide_block<3> : slide_block<1>;
        sum(light, s, nodes.W, t * light.columns_apart, total);
        for (int r = 0; r < rows; ++r)
            for (int x = 0; x < map_groups * lanes && t + x < light.period; ++x)
                for (int c = 0; c < 3; ++c)
                    out[((top + r) * map.W + first + (t + x) * step) * 3 + c] =
                        static_cast<float>(total[r][x / lanes][c][x % lanes]);
    }
}

template <bool held>
void centers(const Picture& picture, const RadialProfile& profile, double outer,
             std::span<const glm::dvec3> axes, std::span<float> out) {
    const Nodes nodes(picture);
    const Planes planes(picture);
    for_each_query<Scratch>(axes.size(), [&](std::size_t q, Scratch& s) {
        integrate_center<held>(nodes, planes, profile, outer, axes[q], s, &out[3 * q]);
    });
}

template <bool held>
void whole_map(const Picture& picture, const RadialProfile& profile, double outer, const Map& map,
               bool symmetry, std::span<float> out) {
    const Nodes nodes(picture);
    // Columns of the map that are a whole number of the picture's columns apart visit the same texels,
    // turned.
    const int shared = std::gcd(map.W, picture.W), step = map.W / shared, apart = picture.W / shared;
    if (shared >= lanes && symmetry) {
        const Sorted light(picture, apart, map_groups * lanes);
        const int blocks = (map.H + map_rows - 1) / map_rows;
        for_each_query<SlideScratch>(size(blocks * step), [&](std::size_t task, SlideScratch& s) {
            const int top = static_cast<int>(task) / step * map_rows, first = static_cast<int>(task) % step;
            slide<held>(nodes, light, profile, outer, map, top, first, step, s, out.data());
        });
    } else if (shared >= lanes && one_weight(nodes, profile)) {
        const Sorted light(picture, apart, lanes);
        for_each_query<Visited>(size(map.H * step), [&](std::size_t task, Visited& cap) {
            const int i = static_cast<int>(task) / step, first = static_cast<int>(task) % step;
            every_pair<held>(nodes, light, profile, outer, map, i, first, step, cap, out.data());
        });
    } else {
        std::vector<glm::dvec3> axes;
        for (int i = 0; i < map.H; ++i)
            for (int j = 0; j < map.W; ++j) axes.push_back(map.center(i, j));
        centers<held>(picture, profile, outer, axes, out);
    }
}

}  // namespace

void integrate_radial(const Picture& picture, const RadialProfile& profile, double outer,
                      std::span<const glm::dvec3> axes, std::span<float> out) {
    const auto integrate = profile.segments == held_segments ? centers<true> : centers<false>;
    integrate(picture, profile, outer, axes, out);
}

void integrate_radial_map(const Picture& picture, const RadialProfile& profile, double outer, int map_H,
                          int map_W, bool symmetry, std::span<float> out) {
    const auto integrate = profile.segments == held_segments ? whole_map<true> : whole_map<false>;
    integrate(picture, profile, outer, {map_H, map_W}, symmetry, out);
}

}  // namespace shrm::angular
