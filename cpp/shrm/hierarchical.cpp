#include "shrm/hierarchical.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "angular_lanes.hpp"
#include "angular_profile.hpp"
#include "core.hpp"

namespace shrm {
namespace {

// The bits of x and y in turns.
std::uint32_t morton(std::uint32_t x, std::uint32_t y) {
    std::uint32_t code = 0;
    for (unsigned bit = 0; bit < 16; ++bit)
        code |= (x >> bit & 1u) << (2 * bit) | (y >> bit & 1u) << (2 * bit + 1);
    return code;
}

// The cell of a direction among N x N of either paraboloid: p = (x, y) / (1 + |z|) [HS98].
std::size_t cell_of(const glm::dvec3& d, int N) {
    const auto place = [N](double p) {
        return static_cast<std::uint32_t>(std::clamp(static_cast<int>((p + 1) / 2 * N), 0, N - 1));
    };
    const double far = 1 + std::abs(d.z);
    return (d.z < 0 ? size(N) * size(N) : 0) + morton(place(d.x / far), place(d.y / far));
}

glm::dvec3 direction_of(const Pyramid::Node& node) {
    return {node.direction[0], node.direction[1], node.direction[2]};
}

// The power of all, at their centroid by power, and how far they reach from it.
Pyramid::Node gathered(std::span<const Pyramid::Node> parts) {
    Pyramid::Node all{};
    glm::dvec3 centroid(0);
    double power[3] = {};
    for (const Pyramid::Node& part : parts) {
        double weight = 0;
        for (int c = 0; c < 3; ++c) {
            power[c] += static_cast<double>(part.power[c]);
            weight += std::abs(static_cast<double>(part.power[c]));
        }
        centroid += weight * direction_of(part);
        all.brightness += part.brightness;
    }
    const double length = glm::length(centroid);
    if (length > 0) centroid /= length;
    for (int c = 0; c < 3; ++c) {
        all.power[c] = static_cast<float>(power[c]);
        all.direction[c] = static_cast<float>(centroid[c]);
    }
    for (const Pyramid::Node& part : parts) {
        if (part.brightness == 0) continue;
        const double chord = std::min(2., glm::length(direction_of(part) - centroid));
        all.radius = std::max(all.radius, static_cast<float>(2 * std::asin(chord / 2)) + part.radius);
    }
    return all;
}

}  // namespace

Pyramid::Pyramid(std::span<const float> pixels, int H, int W) {
    // About two texels to a cell of the discs.
    int N = 1;
    while (2. * N * N < double(H) * W / pi) N *= 2;

    std::vector<glm::dvec2> column(size(W));
    for (int j = 0; j < W; ++j) {
        const double phi = pi - 2 * pi * (j + 0.5) / W;
        column[size(j)] = {std::cos(phi), std::sin(phi)};
    }
    std::vector<std::uint32_t> cell;
    std::vector<Node> found;
    cell.reserve(size(H) * size(W));
    found.reserve(size(H) * size(W));
    for (int i = 0; i < H; ++i) {
        const double theta = (i + 0.5) * pi / H, area = 4 * pi / W * std::sin(theta) * std::sin(0.5 * pi / H);
        const double sine = std::sin(theta), cosine = std::cos(theta);
        const float* texels = &pixels[3 * size(i) * size(W)];
        for (const glm::dvec2& circle : column) {
            const glm::dvec3 d(sine * circle, cosine);
            Node texel{};
            for (int c = 0; c < 3; ++c) {
                texel.direction[c] = static_cast<float>(d[c]);
                texel.power[c] = static_cast<float>(area * double(*texels++));
                texel.brightness = std::max(texel.brightness, std::abs(texel.power[c]));
            }
            if (texel.brightness == 0) continue;
            brightness_ += static_cast<double>(texel.brightness);
            cell.push_back(static_cast<std::uint32_t>(cell_of(d, N)));
            found.push_back(texel);
        }
    }

    // Texels cell by cell.
    begin_.assign(2 * size(N) * size(N) + 1, 0);
    for (std::uint32_t k : cell) ++begin_[k + 1];
    for (std::size_t k = 1; k < begin_.size(); ++k) begin_[k] += begin_[k - 1];
    texels_.resize(found.size());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t k = 0; k < found.size(); ++k) texels_[next[cell[k]]++] = found[k];

    std::size_t count = 0;
    for (int n = 1; n <= N; n *= 2) {
        first_.push_back(count);
        count += 2 * size(n) * size(n);
    }
    nodes_.resize(count);
    for (int level = levels() - 1; level >= 0; --level) gather(level);
}

void Pyramid::gather(int level) {
    const bool finest = level + 1 == levels();
    const std::size_t count = std::size_t{2} << (2 * level);
    Node* const to = &nodes_[first_[size(level)]];
    for (std::size_t i = 0; i < count; ++i)
        to[i] = gathered(finest ? texels(i) : std::span(&node(level + 1, 4 * i), 4));
}

namespace hierarchical {
namespace {

using angular::Ints;
using angular::Lanes;
using angular::width;

SHRM_INLINE bool any(const Ints& mask) {
#if defined(__AVX512F__)
    const auto m = reinterpret_cast<__m512i>(mask);
    return _mm512_test_epi32_mask(m, m) != 0;
#elif defined(__AVX2__)
    const auto m = reinterpret_cast<__m256i>(mask);
    return _mm256_testz_si256(m, m) == 0;
#else
    int found = 0;
    for (int k = 0; k < width; ++k) found |= mask[k];
    return found != 0;
#endif
}

// Vectors that hold a block of targets: what one of them needs, all do, whatever the width of vectors.
inline constexpr int groups = block / width;

// A radial lobe for a block of targets.
template <bool held, int channels>
struct Kernel {
    using Profile = angular::Cubics<held>;
    const Profile* profile;
    Lanes x[groups], y[groups], z[groups];  // g C, so that the profile's variable is 1 + |g C - g L|^2
    float g;

    struct Value {
        Lanes u[groups][channels];
        Lanes place[groups];  // the profile's variable
    };
    SHRM_INLINE Value at(const Pyramid::Node& node) const {
        const float nx = g * node.direction[0], ny = g * node.direction[1], nz = g * node.direction[2];
        Value value;
        for (int k = 0; k < groups; ++k) {
            const Lanes dx = x[k] - nx, dy = y[k] - ny, dz = z[k] - nz;
            value.place[k] = dz * dz + (dy * dy + (dx * dx + 1.0f));
            for (int c = 0; c < channels; ++c) value.u[k][c] = profile[c].anywhere(value.place[k]);
        }
        return value;
    }
};

// Sums of three channels in single precision, carried over to double before their rounding shows.
struct Total {
    Lanes single[groups][3] = {};
    angular::Sum sum[groups];
    int terms = 0;

    template <int channels>
    SHRM_INLINE void add(const Lanes (&u)[groups][channels], const Pyramid::Node& node) {
        for (int k = 0; k < groups; ++k)
            for (int c = 0; c < 3; ++c) single[k][c] += u[k][channels == 1 ? 0 : c] * node.power[c];
        if (++terms == angular::terms_in_single) carry();
    }
    SHRM_INLINE void carry() {
        for (int k = 0; k < groups; ++k) sum[k].add(single[k]);
        terms = 0;
    }
};

// Chords are no longer than their angles: what lies beyond `angle` of a centre has a variable above this.
inline float place_beyond(float g, double angle) {
    const float chord = g * static_cast<float>(angle);
    return 1.0f + chord * chord;
}

template <bool held, int channels>
struct Walk {
    using Value = typename Kernel<held, channels>::Value;
    struct Entry {
        int level;
        std::size_t index;
        Value value;
    };

    const Pyramid& pyramid;
    const Descent& descent;
    double support;
    float limit;
    std::vector<Entry> stack;
    double evaluations = 0;

    void integrate(const Kernel<held, channels>& kernel, Total& total) {
        stack.clear();
        for (std::size_t face = 0; face < 2; ++face)
            if (pyramid.node(0, face).brightness > 0)
                enter(kernel, 0, face, kernel.at(pyramid.node(0, face)));
        while (!stack.empty()) {
            const Entry entry = stack.back();
            stack.pop_back();
            if (entry.level + 1 == pyramid.levels()) {
                for (const Pyramid::Node& texel : pyramid.texels(entry.index))
                    total.add(kernel.at(texel).u, texel);
                evaluations += static_cast<double>(pyramid.texels(entry.index).size());
                continue;
            }
            descend(kernel, entry, total);
        }
    }

    // Beyond its support a lobe is nothing.
    void enter(const Kernel<held, channels>& kernel, int level, std::size_t index, const Value& value) {
        const double radius = static_cast<double>(pyramid.node(level, index).radius);
        const float beyond = place_beyond(kernel.g, support + radius);
        Ints reached = {};
        for (const Lanes& place : value.place) reached |= place < beyond;
        if (any(reached)) stack.push_back({level, index, value});
    }

    SHRM_INLINE void descend(const Kernel<held, channels>& kernel, const Entry& entry, Total& total) {
        const Pyramid::Node& node = pyramid.node(entry.level, entry.index);
        const double radius = static_cast<double>(node.radius);
        Ints differs = {};
        if (radius > descent.finest) {
            const float beyond = place_beyond(kernel.g, descent.outer + radius);
            for (const Lanes& place : entry.value.place) differs |= place < beyond;
        }
        Value values[4];
        for (std::size_t k = 0; k < 4; ++k) {
            const Pyramid::Node& child = pyramid.node(entry.level + 1, 4 * entry.index + k);
            if (child.brightness == 0) continue;
            values[k] = kernel.at(child);
            ++evaluations;
            for (int v = 0; v < groups; ++v)
                for (int c = 0; c < channels; ++c) {
                    const Lanes difference = child.brightness * (values[k].u[v][c] - entry.value.u[v][c]);
                    differs |= (difference > limit) | (difference < -limit);
                }
        }
        const bool split = any(differs);
        for (std::size_t k = 0; k < 4; ++k) {
            const Pyramid::Node& child = pyramid.node(entry.level + 1, 4 * entry.index + k);
            if (child.brightness == 0) continue;
            if (split)
                enter(kernel, entry.level + 1, 4 * entry.index + k, values[k]);
            else
                total.add(values[k].u, child);
        }
    }
};

template <bool held, int channels>
Effort integrate(const Pyramid& pyramid, const angular::RadialProfile& profile, double integral,
                 const Descent& descent, std::span<const glm::dvec3> centres, std::span<float> out) {
    std::vector<angular::Cubics<held>> cubics;
    for (int c = 0; c < channels; ++c) cubics.emplace_back(profile, c);
    const float g = static_cast<float>(0.5 * std::sqrt(profile.scale));
    const auto limit = static_cast<float>(descent.threshold * integral * pyramid.brightness() / (4 * pi));
    const auto blocks = static_cast<std::ptrdiff_t>((centres.size() + size(block) - 1) / size(block));
    double evaluations = 0;
#pragma omp parallel reduction(+ : evaluations)
    {
        Walk<held, channels> walk{pyramid, descent, profile.support, limit, {}};
#pragma omp for schedule(dynamic, 4)
        for (std::ptrdiff_t b = 0; b < blocks; ++b) {
            Kernel<held, channels> kernel{cubics.data(), {}, {}, {}, g};
            const std::size_t first = std::size_t(b) * size(block);
            for (int k = 0; k < block; ++k) {  // the last block repeats the last target
                const glm::dvec3 scaled = double(g) * centres[std::min(first + size(k), centres.size() - 1)];
                kernel.x[k / width][k % width] = static_cast<float>(scaled.x);
                kernel.y[k / width][k % width] = static_cast<float>(scaled.y);
                kernel.z[k / width][k % width] = static_cast<float>(scaled.z);
            }
            Total total;
            walk.integrate(kernel, total);
            total.carry();
            for (int k = 0; k < block && first + size(k) < centres.size(); ++k)
                for (int c = 0; c < 3; ++c)
                    out[3 * (first + size(k)) + size(c)] =
                        static_cast<float>(total.sum[k / width].total[c][k % width]);
        }
        evaluations = walk.evaluations;
    }
    return {evaluations / static_cast<double>(std::max<std::ptrdiff_t>(blocks, 1))};
}

}  // namespace

Effort integrate_radial(const Pyramid& pyramid, const angular::RadialProfile& profile, double integral,
                        const Descent& descent, std::span<const glm::dvec3> centres, std::span<float> out) {
    // Without a threshold every texel is visited that the lobe reaches.
    const Descent whole = descent.threshold > 0 ? descent : Descent{0, profile.support, 0};
    const bool held = profile.segments == angular::held_segments;
    const auto run = [&]<bool in_registers, int channels>() {
        return integrate<in_registers, channels>(pyramid, profile, integral, whole, centres, out);
    };
    if (profile.channels == 1) return held ? run.operator()<true, 1>() : run.operator()<false, 1>();
    return held ? run.operator()<true, 3>() : run.operator()<false, 3>();
}

}  // namespace hierarchical
}  // namespace shrm
