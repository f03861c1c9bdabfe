// Rows of n^2 values, a float or a half each, times light. For .cpp files only, as simd.hpp.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "shrm/core.hpp"
#include "shrm/half.hpp"
#include "shrm/simd.hpp"
#include "shrm/transfer_views.hpp"

namespace shrm {

// The vectors of a row. Rows lie one after the other, unpadded: the last vector ends where the row does, and
// begins with values of the one before.
template <int known>  // n^2, or 0 where `given` says
struct Row {
    int given;

    constexpr int count() const { return known ? known : given; }
    constexpr int vectors() const { return (count() + lanes - 1) / lanes; }
    constexpr int begin(int v) const { return std::max(std::min(v * lanes, count() - lanes), 0); }

    template <class Stored>
    Floats load(const Stored* row, int v) const {
        if (count() >= lanes) return shrm::load(row + begin(v));
        Floats some{};
        for (int i = 0; i < count(); ++i) some[i] = float_from(row[i]);
        return some;
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

// Calls body(std::integral_constant<int, n^2>()) where there is a kernel for that order, else with 0.
template <class Body>
inline void for_terms(int terms, Body&& body) {
    if (terms == 25)
        body(std::integral_constant<int, 25>());
    else
        body(std::integral_constant<int, 0>());
}

}  // namespace shrm
