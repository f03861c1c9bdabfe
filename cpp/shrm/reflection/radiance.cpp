#include "shrm/reflection/radiance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include <omp.h>
#include <glm/geometric.hpp>

#include "shrm/core.hpp"
#include "shrm/pictures/cube.hpp"
#include "shrm/sh/view_harmonics.hpp"
#include "shrm/simd/half.hpp"
#include "shrm/simd/trigonometry.hpp"

namespace shrm {
namespace {

constexpr std::size_t largest_block = 65536;  // points; the more, the more of them look at the same texels

d8vec3 gather(std::span<const glm::dvec3> from, const std::size_t (&index)[8]) {
    d8vec3 to{};
    for (int u = 0; u < 8; ++u) {
        const glm::dvec3& direction = from[index[u]];
        to.x[u] = direction.x, to.y[u] = direction.y, to.z[u] = direction.z;
    }
    return to;
}

// The central directions of eight normals N and views V, and their effect on the views: see radiance.hpp.
void central_directions(Center center, std::span<const double> gamma, const d8vec3& N, d8vec3& V, d8vec3& C) {
    C = N;
    if (center == Center::tangent) return;
    const d8 cosine = dot(N, V);
    if (center == Center::reflection) {
        C = {2 * cosine * N.x - V.x, 2 * cosine * N.y - V.y, 2 * cosine * N.z - V.z};
        return;
    }
    const d8vec3 across{V.x - cosine * N.x, V.y - cosine * N.y, V.z - cosine * N.z};
    const d8 sine = square_root(dot(across, across));
    const auto below = (cosine < 0) & (sine >= 1e-12);
    const d8 inverse = 1 / (sine < 1e-12 ? 1 + d8{} : sine);
    V = {below ? inverse * across.x : V.x, below ? inverse * across.y : V.y,
         below ? inverse * across.z : V.z};
    if (center == Center::normal) return;
    const d8 theta_v = arc_tangent(sine, cosine);
    d8 angle, cos_angle, sin_angle;
    for (int u = 0; u < 8; ++u) {
        const double at = std::min(theta_v[u] / (pi / 2), 1.) * static_cast<double>(gamma.size() - 1);
        const std::size_t i = std::min(static_cast<std::size_t>(at), gamma.size() - 2);
        const double t = at - static_cast<double>(i);
        angle[u] = (1 - t) * gamma[i] + t * gamma[i + 1];
    }
    cosine_and_sine(angle, cos_angle, sin_angle);
    const d8 aside = sine < 1e-12 ? d8{} : sin_angle * inverse;
    cos_angle = sine < 1e-12 ? 1 + d8{} : cos_angle;
    C = {cos_angle * N.x - aside * across.x, cos_angle * N.y - aside * across.y,
         cos_angle * N.z - aside * across.z};
}

// Weights of the samples at -1, 0, 1, 2 for points at t in [0, 1).
void interpolation_weights(const d8& t, bool bilinear, d8 (&w)[4]) {
    if (bilinear) {
        w[0] = w[3] = d8{}, w[1] = 1 - t, w[2] = t;
        return;
    }
    w[0] = -1. / 6 * t * (t - 1) * (t - 2), w[1] = 0.5 * (t + 1) * (t - 1) * (t - 2);
    w[2] = -0.5 * (t + 1) * t * (t - 2), w[3] = 1. / 6 * (t + 1) * t * (t - 1);
}

// The texels that a point looks up: four rows and four columns from (row, column), with their weights. Rows
// and columns are counted from the first that any look takes: a cube's first, and two before a lat-long
// map's.
struct Look {
    glm::dvec3 view;  // what the harmonics are taken of; if zonal, z = C.V
    std::array<float, 4> row_weights;
    f4 column_weights;
    int row, column;
};

// Rows and columns, in texels from the center of the first, of eight directions on a lat-long map.
void latlong_position(int H, int W, const d8vec3& C, d8& row, d8& column) {
    row = H / pi * arc_tangent(length(C.x, C.y), C.z) - 0.5;
    column = W / (2 * pi) * (pi - arc_tangent(C.y, C.x)) - 0.5;
}

// The same on the faces of a cube of N texels, and which face.
void cube_position(int N, const d8vec3& C, d8& row, d8& column, i8& faces) {
    for (int u = 0; u < 8; ++u) {
        const glm::dvec3 d{-C.y[u], C.z[u], C.x[u]};  // in the cube's axes
        const glm::dvec3 a = glm::abs(d);
        int face;
        double s, t, major;
        if (a.x >= a.y && a.x >= a.z)
            face = d.x > 0 ? 0 : 1, major = a.x, s = d.x > 0 ? -d.z : d.z, t = -d.y;
        else if (a.y >= a.z)
            face = d.y > 0 ? 2 : 3, major = a.y, s = d.x, t = d.y > 0 ? d.z : -d.z;
        else
            face = d.z > 0 ? 4 : 5, major = a.z, s = d.z > 0 ? d.x : -d.x, t = -d.y;
        faces[u] = face;
        row[u] = (t / major + 1) / 2 * N - 0.5;
        column[u] = (s / major + 1) / 2 * N - 0.5;
    }
}

void look(const ReflectionMapView& map, const d8vec3& C, const d8vec3& V, bool bilinear, Look (&looks)[8]) {
    d8 row, column, row_weights[4], column_weights[4];
    i8 face{};
    const bool cube = map.layout == MapLayout::cube;
    if (cube)
        cube_position(map.W - 2 * cube_border, C, row, column, face);
    else
        latlong_position(map.H, map.W, C, row, column);
    const i8 i = __builtin_convertvector(row + 2, i8) - 2, j = __builtin_convertvector(column + 2, i8) - 2;
    interpolation_weights(row - __builtin_convertvector(i, d8), bilinear, row_weights);
    interpolation_weights(column - __builtin_convertvector(j, d8), bilinear, column_weights);
    const d8 cosine = dot(C, V);
    for (int u = 0; u < 8; ++u) {
        Look& to = looks[u];
        to.view = map.zonal ? glm::dvec3(0, 0, cosine[u]) : glm::dvec3(V.x[u], V.y[u], V.z[u]);
        if (cube) {
            to.row = face[u] * map.W + std::clamp(i[u] - 1 + cube_border, 0, map.W - 4);
            to.column = std::clamp(j[u] - 1 + cube_border, 0, map.W - 4);
        } else {
            to.row = std::clamp(i[u], -1, map.H - 1) + 1;
            to.column = std::clamp(j[u], -1, map.W - 1) + 1;
        }
        for (int a = 0; a < 4; ++a) {
            to.row_weights[size(a)] = static_cast<float>(row_weights[a][u]);
            to.column_weights[a] = static_cast<float>(column_weights[a][u]);
        }
    }
}

// A tile of the rings for points that look at the same rows and at columns near to each other. In the rings
// its lines lie a row apart, often a power of two, and would push each other out of the cache.
class Tile {
  public:
    static constexpr int step = 16, columns = step + 4;  // the first column of a look is one of 16

    explicit Tile(const ReflectionMapView& map)
        : map_(map), values_(4 * size(map.maps()) * 3 * columns), maps_(map.maps()) {}

    // Four rows of all maps from `row`, and from `column` the columns of one look or of any; beyond a pole a
    // map continues half a turn on.
    void load(int row, int column, bool one) {
        const std::size_t rings = size(maps_) * 3;
        for (int a = 0; a < 4; ++a) {
            int from_row = row + a, from = column;
            if (map_.layout == MapLayout::latlong) {
                from_row -= 2;
                const bool beyond = from_row < 0 || from_row >= map_.H;
                if (beyond) from_row = from_row < 0 ? -1 - from_row : 2 * map_.H - 1 - from_row;
                from_row = std::clamp(from_row, 0, map_.H - 1);  // a map of one row
                from = (column - 2 + (beyond ? map_.W / 2 : 0) + map_.W) % map_.W;
            }
            const std::size_t ring = size(from_row) * rings * size(map_.pitch);
            float* target = &values_[size(a) * rings * columns];
            const auto copy_ring = [&](const auto* source) {
                if (one)
                    copy<4>(source + ring, from, target);
                else
                    copy<columns>(source + ring, from, target);
            };
            if (map_.halves.empty())
                copy_ring(map_.rings.data());
            else
                copy_ring(map_.halves.data());
        }
    }

    // radiance (3) += sum over the maps of weight times the interpolated map: the sum of [RH02] eq. 7 or, if
    // zonal, eq. 6, the weights being Y_pq of the view, `stride` apart; `offset` columns from the tile's
    // first.
    void interpolate(const Look& at, int offset, const float* weights, std::size_t stride,
                     float* radiance) const {
        const std::size_t row = size(maps_) * 3 * columns;
        const float* texels = &values_[size(offset)];
        f4 sums[4][3] = {};  // of each row, its columns still apart
        for (int z = 0; z < maps_; ++z, weights += stride)
            for (std::size_t c = 0; c < 3; ++c, texels += columns)
                for (std::size_t a = 0; a < 4; ++a) sums[a][c] += *weights * load_four(texels + a * row);
        for (std::size_t c = 0; c < 3; ++c) {
            f4 sum{};
            for (std::size_t a = 0; a < 4; ++a) sum += at.row_weights[a] * sums[a][c];
            sum *= at.column_weights;
            radiance[c] += (sum[0] + sum[2]) + (sum[1] + sum[3]);
        }
    }

  private:
    template <int count, class Stored>
    void copy(const Stored* source, int from, float* target) const {
        for (int k = 0; k < 3 * maps_; ++k, source += map_.pitch, target += columns)
            if (from + count <= map_.W) {
                for (int b = 0; b < count; ++b) target[b] = float_from(source[from + b]);
            } else {
                for (int b = 0, column = from; b < count; ++b) {
                    target[b] = float_from(source[column]);
                    column = column + 1 < map_.W ? column + 1 : 0;
                }
            }
    }

    const ReflectionMapView& map_;
    std::vector<float> values_;
    int maps_;
};

// The points of a block in the order of the tiles they look at: the rings pass through the cache once.
class Order {
  public:
    const std::vector<std::size_t>& sort(const ReflectionMapView& map, const std::vector<Look>& looks) {
        const std::size_t across = size(map.W) / Tile::step + 1, tiles = size(map.H + 2) * across;
        const bool by_rows = tiles > looks.size();  // more would cost more than it saves
        const auto key = [&](const Look& at) {
            return by_rows ? size(at.row) : size(at.row) * across + size(at.column) / Tile::step;
        };
        start_.assign((by_rows ? size(map.H + 2) : tiles) + 1, 0);
        for (const Look& at : looks) ++start_[key(at) + 1];
        std::partial_sum(start_.begin(), start_.end(), start_.begin());
        order_.resize(looks.size());
        for (std::size_t i = 0; i < looks.size(); ++i) order_[start_[key(looks[i])]++] = i;
        return order_;
    }

  private:
    std::vector<std::size_t> start_, order_;
};

// Some points, one after the other: where they look, then in what order, then the sums over the maps.
class Block {
  public:
    explicit Block(const ReflectionMapView& map)
        : map_(map), tile_(map), Y_(basis_size(map.P)), weights_(Y_.size()) {}

    // Calls central(i, C, V) for the central directions and views of the points i to i + 7.
    template <class Central>
    void locate(std::size_t count, bool bilinear, const Central& central) {
        looks_.resize(count);
        for (std::size_t i = 0; i < count; i += 8) {
            d8vec3 C, V;
            central(i, C, V);
            Look eight[8];
            look(map_, C, V, bilinear, eight);
            std::copy_n(eight, std::min<std::size_t>(8, count - i), &looks_[i]);
        }
    }

    // radiance (count, 3) += the sums.
    void add(float* radiance) {
        const auto& sorted = order_.sort(map_, looks_);
        std::size_t end = 0;  // of the points in the tile
        int column = 0;       // the tile's first
        for (std::size_t i = 0; i < sorted.size(); ++i) {
            if (i % 8 == 0) {
                harmonics(sorted, i);
                for (std::size_t next = i; next < std::min(i + 8, sorted.size()); ++next)
                    __builtin_prefetch(radiance + 3 * sorted[next], 1);
            }
            const Look& at = looks_[sorted[i]];
            if (i == end) {
                bool one = true;
                for (; end < sorted.size() && same_tile(at, looks_[sorted[end]]); ++end)
                    one = one && at.column == looks_[sorted[end]].column;
                column = one ? at.column : at.column / Tile::step * Tile::step;
                tile_.load(at.row, column, one);
            }
            const float* weights = reinterpret_cast<const float*>(weights_.data()) + i % 8;
            tile_.interpolate(at, at.column - column, weights, 8, radiance + 3 * sorted[i]);
        }
    }

  private:
    static bool same_tile(const Look& a, const Look& b) {
        return a.row == b.row && a.column / Tile::step == b.column / Tile::step;
    }

    // The weights of the maps for the points i to i + 7 in the order.
    void harmonics(const std::vector<std::size_t>& sorted, std::size_t i) {
        d8 x{}, y{}, z{};
        for (std::size_t u = 0; u < 8; ++u) {
            const glm::dvec3& view = looks_[sorted[std::min(i + u, sorted.size() - 1)]].view;
            x[u] = view.x, y[u] = view.y, z[u] = view.z;
        }
        if (map_.zonal)
            zonal_harmonics(map_.P, z, Y_.data());
        else
            real_harmonics(map_.P, d8vec3{x, y, z}, Y_.data());
        for (std::size_t k = 0; k < size(map_.maps()); ++k) weights_[k] = __builtin_convertvector(Y_[k], f8);
    }

    const ReflectionMapView& map_;
    Tile tile_;
    Order order_;
    std::vector<Look> looks_;
    std::vector<d8> Y_;        // of eight points
    std::vector<f8> weights_;  // the same
};

// Deals n points out to threads in blocks. Calls central(C, V) to turn what eight of the axes and views are
// into central directions and views.
template <class Central>
void add_in_blocks(const ReflectionMapView& map, std::span<const glm::dvec3> axes,
                   std::span<const glm::dvec3> views, bool bilinear, const Central& central,
                   std::span<float> radiance) {
    const std::size_t n = axes.size(), threads = size(omp_get_max_threads());
    const std::size_t rounds = n / (threads * largest_block) + 1, length = n / (threads * rounds) + 1;
    const auto blocks = static_cast<std::ptrdiff_t>((n + length - 1) / length);
#pragma omp parallel
    {
        Block block(map);
#pragma omp for schedule(dynamic)
        for (std::ptrdiff_t number = 0; number < blocks; ++number) {
            const std::size_t first = static_cast<std::size_t>(number) * length,
                              count = std::min(length, n - first);
            block.locate(count, bilinear, [&](std::size_t i, d8vec3& C, d8vec3& V) {
                std::size_t at[8], view[8];
                for (std::size_t u = 0; u < 8; ++u) {
                    at[u] = first + std::min(i + u, count - 1);
                    view[u] = views.size() == 1 ? 0 : at[u];
                }
                C = gather(axes, at);
                V = gather(views, view);
                central(C, V);
            });
            block.add(&radiance[3 * first]);
        }
    }
}

}  // namespace

void add_radiance(const ReflectionMapView& map, Center center, std::span<const double> gamma,
                  std::span<const glm::dvec3> axes, std::span<const glm::dvec3> views, bool bilinear,
                  std::span<float> radiance) {
    const auto central = [&](d8vec3& C, d8vec3& V) {
        const d8vec3 N = C;
        central_directions(center, gamma, N, V, C);
    };
    add_in_blocks(map, axes, views, bilinear, central, radiance);
}

void add_looked_up(const ReflectionMapView& map, std::span<const glm::dvec3> C,
                   std::span<const glm::dvec3> views, bool bilinear, std::span<float> radiance) {
    add_in_blocks(map, C, views, bilinear, [](d8vec3&, d8vec3&) {}, radiance);
}

}  // namespace shrm
