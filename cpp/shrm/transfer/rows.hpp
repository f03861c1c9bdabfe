// Rows of n^2 values, a float or a half each, times light. For .cpp files only, as vectors.hpp.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "shrm/core.hpp"
#include "shrm/simd/half.hpp"
#include "shrm/simd/vectors.hpp"
#include "shrm/transfer/views.hpp"

namespace shrm {

constexpr int vectors_of(int count) {
    return (count + lanes - 1) / lanes;
}

// The vectors of a row. Rows lie one after the other, unpadded: the last vector ends where the row does, and
// begins with values of the one before.
template <int known>  // n^2, or 0 where `given` says
struct Row {
    int given;

    constexpr int count() const { return known ? known : given; }
    constexpr int vectors() const { return vectors_of(count()); }
    constexpr int begin(int v) const { return std::max(std::min(v * lanes, count() - lanes), 0); }
    constexpr int n() const {
        int n = 1;
        while (n * n < count()) ++n;
        return n;
    }

    template <class Stored>
    Floats load(const Stored* row, int v) const {
        return count() >= lanes ? shrm::load(row + begin(v)) : load_first(row, count());
    }
    // Calls body(v) for every vector, with constants where their number is known: sums stay in registers.
    template <class Body>
    void for_vectors(Body&& body) const {
        if constexpr (known > 0)
            unrolled<Row{known}.vectors()>(body);
        else
            for (int v = 0; v < vectors(); ++v) body(v);
    }
    // Calls body(l) for every degree, likewise.
    template <class Body>
    void for_degrees(Body&& body) const {
        if constexpr (known > 0)
            unrolled<Row{known}.n()>(body);
        else
            for (int l = 0; l * l < count(); ++l) body(l);
    }
};

// Light in the vectors of rows; 0 where they hold values of the one before.
class RowLight {
  public:
    // light (n^2, 3)
    explicit RowLight(std::span<const float> light)
        : terms_(static_cast<int>(light.size() / 3)), values_(size(3 * row().vectors() * lanes)) {
        for (int c = 0; c < 3; ++c)
            for (int j = 0; j < terms_; ++j) {
                const int v = j / lanes;
                values_[size((c * row().vectors() + v) * lanes + j - row().begin(v))] =
                    light[size(3 * j + c)];
            }
    }
    int terms() const { return terms_; }
    Floats channel(int c, int v, int vectors) const {
        return load(&values_[size((c * vectors + v) * lanes)]);
    }

  private:
    Row<0> row() const { return {terms_}; }
    int terms_;
    std::vector<float> values_;
};

// Vertices whose sums over vectors are finished together.
inline constexpr int vertex_group = lanes / 4;

// Radiance of a block as red, green, blue and a fourth value that means nothing.
struct Quads {
    alignas(64) float values[4 * vertex_block];

    void copy(int vertices, float* radiance) const {
        for (int i = 0; i < vertices; ++i)
            for (int c = 0; c < 3; ++c) radiance[3 * i + c] = values[4 * i + c];
    }
};

// Tents at the views of a block of vertices.
struct BlockTents {
    int block = -1, first, count;
    Neighbours tents;
};

// Calls light(now, next) for every block, with the tents of the block that follows too, so that what they
// will need can be asked for in time. The last is followed by itself.
template <class Light>
inline void for_blocks(const TransferSurface& surface, const Eye& eye, int M, Light&& light) {
    const int last = surface.blocks() - 1;
#pragma omp parallel
    {
        BlockTents found[2];
        const auto tents_of = [&](int block) -> const BlockTents& {
            BlockTents& to = found[block % 2];
            if (to.block != block) {
                to.block = block, to.first = block * vertex_block, to.count = surface.count(block);
                tents_of_views(surface, block, eye, M, to.tents);
            }
            return to;
        };
#pragma omp for schedule(static)
        for (int block = 0; block <= last; ++block)
            light(tents_of(block), tents_of(std::min(block + 1, last)));
    }
}

constexpr std::size_t cache_line = 64;

// Asks for memory, into the second cache: more of it can be on its way there than to the first.
[[gnu::always_inline]] inline void prefetch(const void* from, std::size_t bytes) {
    const auto at = reinterpret_cast<std::uintptr_t>(from);
    for (auto line = at / cache_line * cache_line; line < at + bytes; line += cache_line)
        __builtin_prefetch(reinterpret_cast<const void*>(line), 0, 2);
}

// Calls body(std::integral_constant<int, n^2>()) where there is a kernel for that order, else with 0.
template <class Body>
inline void for_terms(int terms, Body&& body) {
    if (terms == 25)
        body(std::integral_constant<int, 25>());
    else
        body(std::integral_constant<int, 0>());
}

}  // namespace shrm
