#include <algorithm>

#include "shrm/core.hpp"
#include "shrm/simd/shuffles.hpp"
#include "shrm/transfer/lighting.hpp"
#include "shrm/transfer/rows.hpp"

namespace shrm {
namespace {

// The four rows of a vertex, of `width` values each: two side by side, and two `below` values further on.
// They lie anywhere in a matrix of kilobytes, so that memory is asked for them a block ahead.
template <class Stored>
class FourRows {
  public:
    FourRows(const Stored* matrices, int M, std::size_t width)
        : matrices_(matrices), matrix_(size(M * M) * width), width_(width), below_(size(M) * width) {}

    const Stored* of(const BlockTents& block, int i) const {
        return matrices_ + (size(block.first) + size(i)) * matrix_ + size(block.tents.first[i]) * width_;
    }
    std::size_t below() const { return below_; }
    // Always inlined: g++ takes a function that only prefetches for one that does nothing.
    [[gnu::always_inline]] void prefetch(const BlockTents& block, int i) const {
        const Stored* rows = of(block, std::min(i, block.count - 1));
        const std::size_t bytes = std::max(2 * width_, width_ + lanes) * sizeof(Stored);  // whole vectors
        shrm::prefetch(rows, bytes);
        shrm::prefetch(rows + below_, bytes);
    }

  private:
    const Stored* matrices_;
    std::size_t matrix_, width_, below_;
};

template <int known, int channels, class Stored>
SHRM_KERNEL void light_block(const FourRows<Stored>& matrices, const BlockTents& now, const BlockTents& next,
                             const RowLight& light, Quads& radiance) {
    const Row<known> row{light.terms()};
    const std::size_t width = size(channels * row.count()), below = matrices.below();
    for (int i = 0; i < now.count; i += vertex_group) {
        Floats sums[lanes] = {};
        for (int g = 0; g < vertex_group; ++g) {
            matrices.prefetch(next, i + g);
            const int p = std::min(i + g, now.count - 1);
            const Stored* rows = matrices.of(now, p);
            const float* w = &now.tents.weights[0][p];
            for (int c = 0; c < channels; ++c, rows += row.count())
                row.for_vectors([&](auto v) {
                    const Floats sum =
                        (w[0] * row.load(rows, v) + w[vertex_block] * row.load(rows + width, v)) +
                        (w[2 * vertex_block] * row.load(rows + below, v) +
                         w[3 * vertex_block] * row.load(rows + below + width, v));
                    if constexpr (channels == 1)
                        unrolled<3>(
                            [&](auto k) { sums[4 * g + k] += sum * light.channel(k, v, row.vectors()); });
                    else
                        sums[4 * g + c] += sum * light.channel(c, v, row.vectors());
                });
        }
        store(radiance.values + 4 * i, sums_of<lanes>(sums));
    }
}

template <class Stored>
void light_tents(const TransferSurface& surface, const Stored* matrices, int M, int channels,
                 std::span<const float> light, const Eye& eye, std::span<float> radiance) {
    const RowLight packed(light);
    const FourRows<Stored> rows(matrices, M, size(channels * packed.terms()));
    for_terms(packed.terms(), [&](auto known) {
        for_blocks(surface, eye, M, [&](const BlockTents& now, const BlockTents& next) {
            Quads found;
            if (channels == 1)
                light_block<known, 1>(rows, now, next, packed, found);
            else
                light_block<known, 3>(rows, now, next, packed, found);
            found.copy(now.count, &radiance[3 * size(now.first)]);
        });
    });
}

template <int known, class Stored>
SHRM_KERNEL void light_rows_block(const Stored* rows, int channels, int vertices, const RowLight& light,
                                  Quads& radiance) {
    const Row<known> row{light.terms()};
    for (int i = 0; i < vertices; i += vertex_group) {
        Floats sums[lanes] = {};
        for (int g = 0; g < vertex_group; ++g) {
            const Stored* from = rows + size(std::min(i + g, vertices - 1)) * size(channels * row.count());
            row.for_vectors([&](auto v) {
                unrolled<3>([&](auto c) {
                    const Stored* of_channel = channels == 1 ? from : from + c * row.count();
                    sums[4 * g + c] += row.load(of_channel, v) * light.channel(c, v, row.vectors());
                });
            });
        }
        store(radiance.values + 4 * i, sums_of<lanes>(sums));
    }
}

template <class Stored>
void light_rows(const Stored* rows, int vertices, int channels, std::span<const float> light,
                std::span<float> radiance) {
    const RowLight packed(light);
    const int blocks = (vertices + vertex_block - 1) / vertex_block;
    for_terms(packed.terms(), [&](auto known) {
#pragma omp parallel for schedule(static)
        for (int block = 0; block < blocks; ++block) {
            const std::size_t first = size(block) * vertex_block;
            const int count = std::min(vertices - block * vertex_block, vertex_block);
            Quads found;
            light_rows_block<known>(rows + first * size(channels * packed.terms()), channels, count, packed,
                                    found);
            found.copy(count, &radiance[3 * first]);
        }
    });
}

}  // namespace

void light_tents(const TransferSurface& surface, const TransferValues& matrices, int M, int channels,
                 std::span<const float> light, const Eye& eye, std::span<float> radiance) {
    if (matrices.halves.empty())
        light_tents(surface, matrices.floats.data(), M, channels, light, eye, radiance);
    else
        light_tents(surface, matrices.halves.data(), M, channels, light, eye, radiance);
}

void light_fixed_tents(const TransferSurface& surface, std::span<const float> coefficients, int M,
                       const Eye& eye, std::span<float> radiance) {
    const FourRows<float> rows(coefficients.data(), M, 3);
    for_blocks(surface, eye, M, [&](const BlockTents& now, const BlockTents& next) {
        for (int i = 0; i < now.count; ++i) {
            rows.prefetch(next, i);
            const float *row = rows.of(now, i), *below = row + rows.below();
            for (int c = 0; c < 3; ++c)
                radiance[3 * size(now.first + i) + size(c)] =
                    (now.tents.weights[0][i] * row[c] + now.tents.weights[1][i] * row[3 + c]) +
                    (now.tents.weights[2][i] * below[c] + now.tents.weights[3][i] * below[3 + c]);
        }
    });
}

void light_rows(const TransferValues& rows, int vertices, int channels, std::span<const float> light,
                std::span<float> radiance) {
    if (rows.halves.empty())
        light_rows(rows.floats.data(), vertices, channels, light, radiance);
    else
        light_rows(rows.halves.data(), vertices, channels, light, radiance);
}

}  // namespace shrm
