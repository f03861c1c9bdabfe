// The descent itself, the same for lobes of all kinds. Private to hierarchical.
//
// A kernel is a lobe for a block of targets. It has
//   Value                     what it is at a node: u[groups][channels], and what the two questions need
//   at(node)                  its value there
//   reaches(value, radius)    whether it may be other than nothing within `radius` of the node
//   hides(value, radius)      whether it may hide there between samples
// the last two for any target of the block.
#pragma once

#include <algorithm>
#include <vector>

#include <glm/vec3.hpp>

#include "shrm/angular/sums.hpp"
#include "shrm/core.hpp"
#include "shrm/hierarchical/hierarchical.hpp"

namespace shrm::hierarchical {

// Vectors that hold a block of targets: what one of them needs, all do, whatever the width of vectors.
inline constexpr int groups = block / lanes;

// A number for each target of a block.
struct Numbers {
    Floats groups_[groups] = {};

    SHRM_INLINE const Floats& operator[](int group) const { return groups_[group]; }
    void set(int k, double value) { groups_[k / lanes][k % lanes] = static_cast<float>(value); }
};

// A direction for each.
struct Directions {
    Numbers x = {}, y = {}, z = {};

    void set(int k, const glm::dvec3& d) {
        x.set(k, d.x);
        y.set(k, d.y);
        z.set(k, d.z);
    }
    // The square of the chord to scale L.
    SHRM_INLINE Floats chord2(int group, const Pyramid::Node& node, float scale = 1) const {
        const Floats dx = x[group] - scale * node.direction[0], dy = y[group] - scale * node.direction[1],
                     dz = z[group] - scale * node.direction[2];
        return dz * dz + (dy * dy + dx * dx);
    }
    SHRM_INLINE Floats along(int group, const Pyramid::Node& node) const {
        return x[group] * node.direction[0] + (y[group] * node.direction[1] + z[group] * node.direction[2]);
    }
};

// Sums of three channels in single precision, carried over to double before their rounding shows.
struct Total {
    Floats single[groups][3] = {};
    angular::Sum sum[groups];
    int terms = 0;

    template <int channels>
    SHRM_INLINE void add(const Floats (&u)[groups][channels], const Pyramid::Node& node) {
        for (int k = 0; k < groups; ++k)
            for (int c = 0; c < 3; ++c) single[k][c] += u[k][channels == 1 ? 0 : c] * node.power[c];
        if (++terms == angular::terms_in_single) carry();
    }
    SHRM_INLINE void carry() {
        for (int k = 0; k < groups; ++k) sum[k].add(single[k]);
        terms = 0;
    }
};

template <class Kernel>
struct Walk {
    using Value = typename Kernel::Value;
    struct Entry {
        int level;
        std::size_t index;
        Value value;
    };

    const Pyramid& pyramid;
    float limit;  // to a child's brightness times its difference from its parent
    bool whole;   // every texel
    std::vector<Entry> stack = {};
    double evaluations = 0;

    void integrate(const Kernel& kernel, Total& total) {
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

    void enter(const Kernel& kernel, int level, std::size_t index, const Value& value) {
        if (kernel.reaches(value, pyramid.node(level, index).radius)) stack.push_back({level, index, value});
    }

    SHRM_INLINE void descend(const Kernel& kernel, const Entry& entry, Total& total) {
        const float radius = pyramid.node(entry.level, entry.index).radius;
        bool split = whole || kernel.hides(entry.value, radius);
        Value values[4];
        Ints differs = {};
        for (std::size_t k = 0; k < 4; ++k) {
            const Pyramid::Node& child = pyramid.node(entry.level + 1, 4 * entry.index + k);
            if (child.brightness == 0) continue;
            values[k] = kernel.at(child);
            ++evaluations;
            for (int v = 0; v < groups; ++v)
                for (int c = 0; c < Kernel::channels; ++c) {
                    const Floats difference = child.brightness * (values[k].u[v][c] - entry.value.u[v][c]);
                    differs |= (difference > limit) | (difference < -limit);
                }
        }
        split = split || any(differs);
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

// Calls prepare(kernel, lane, target) for each target of a block; the last block repeats the last target.
template <class Kernel, class Prepare>
Effort integrate(const Pyramid& pyramid, const Descent& descent, const Kernel& lobe, std::size_t count,
                 const Prepare& prepare, std::span<float> out) {
    const auto limit =
        static_cast<float>(descent.threshold * descent.integral * pyramid.brightness() / (4 * pi));
    const auto blocks = static_cast<std::ptrdiff_t>((count + size(block) - 1) / size(block));
    double evaluations = 0;
#pragma omp parallel reduction(+ : evaluations)
    {
        Walk<Kernel> walk{pyramid, limit, descent.threshold <= 0};
        Kernel kernel = lobe;
#pragma omp for schedule(dynamic, 4)
        for (std::ptrdiff_t b = 0; b < blocks; ++b) {
            const std::size_t first = std::size_t(b) * size(block);
            for (int k = 0; k < block; ++k) prepare(kernel, k, std::min(first + size(k), count - 1));
            Total total;
            walk.integrate(kernel, total);
            total.carry();
            for (int k = 0; k < block && first + size(k) < count; ++k)
                for (int c = 0; c < 3; ++c)
                    out[3 * (first + size(k)) + size(c)] =
                        static_cast<float>(total.sum[k / lanes].total[c][k % lanes]);
        }
        evaluations = walk.evaluations;
    }
    return {evaluations / static_cast<double>(std::max<std::ptrdiff_t>(blocks, 1))};
}

}  // namespace shrm::hierarchical
