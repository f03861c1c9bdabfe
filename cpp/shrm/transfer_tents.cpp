#include <algorithm>

#include "shrm/core.hpp"
#include "shrm/transfer_lighting.hpp"
#include "shrm/transfer_rows.hpp"

namespace shrm {
namespace {

// The four rows of a vertex lie in two pairs, anywhere in a matrix of kilobytes: they are asked for so many
// vertices ahead that they have arrived when their turn comes.
constexpr int ahead = 12;

constexpr std::size_t cache_line = 64;

inline void prefetch(const void* from, std::size_t bytes) {
    const auto* at = static_cast<const char*>(from);
    for (std::size_t offset = 0; offset < bytes; offset += cache_line) __builtin_prefetch(at + offset);
    __builtin_prefetch(at + bytes - 1);
}

// Radiance of a block's vertices: red, green, blue, and a fourth lane of 0.
//   matrices (V, M^2, C, n^2) from the block's first vertex on
template <int known, int channels, class Stored>
SHRM_KERNEL void light_block(const Stored* matrices, int M, const Neighbours& tents, int vertices,
                             const RowLight& light, Quads& radiance) {
    const Row<known> row{light.terms()};
    const auto width = std::size_t(channels * row.count());  // of a tent
    const std::size_t matrix = size(M * M) * width, below = size(M) * width;
    for (int i = 0; i < vertices; i += vertex_group) {
        Floats sums[lanes] = {};
        for (int g = 0; g < vertex_group; ++g) {
            const int p = std::min(i + g, vertices - 1), later = std::min(p + ahead, vertices - 1);
            const Stored* next = matrices + size(later) * matrix + size(tents.first[later]) * width;
            prefetch(next, 2 * width * sizeof(Stored));
            prefetch(next + below, 2 * width * sizeof(Stored));

            const Stored* rows = matrices + size(p) * matrix + size(tents.first[p]) * width;
            const float* w = &tents.weights[0][p];
            for (int c = 0; c < channels; ++c, rows += row.count())
                for (int v = 0; v < row.vectors(); ++v) {
                    const Floats sum =
                        (w[0] * row.load(rows, v) + w[vertex_block] * row.load(rows + width, v)) +
                        (w[2 * vertex_block] * row.load(rows + below, v) +
                         w[3 * vertex_block] * row.load(rows + below + width, v));
                    if constexpr (channels == 1)
                        unrolled<3>(
                            [&](auto k) { sums[4 * g + k] += sum * light.channel(k, v, row.vectors()); });
                    else
                        sums[4 * g + c] += sum * light.channel(c, v, row.vectors());
                }
        }
        store(radiance.values + 4 * i, sums_of<lanes>(sums));
    }
}

template <class Stored>
void light_tents(const TransferSurface& surface, const Stored* matrices, int M, int channels,
                 std::span<const float> light, const Eye& eye, std::span<float> radiance) {
    const RowLight packed(light);
    const std::size_t matrix = size(M * M) * size(channels * packed.terms());
    for_terms(packed.terms(), [&](auto known) {
#pragma omp parallel for schedule(static)
        for (int block = 0; block < surface.blocks(); ++block) {
            Neighbours tents;
            Quads found;
            tents_of_views(surface, block, eye, M, tents);
            const int count = surface.count(block);
            const Stored* from = matrices + size(block) * vertex_block * matrix;
            if (channels == 1)
                light_block<known, 1>(from, M, tents, count, packed, found);
            else
                light_block<known, 3>(from, M, tents, count, packed, found);
            found.copy(count, &radiance[size(block) * 3 * vertex_block]);
        }
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
            for (int v = 0; v < row.vectors(); ++v)
                unrolled<3>([&](auto c) {
                    const Stored* of_channel = channels == 1 ? from : from + c * row.count();
                    sums[4 * g + c] += row.load(of_channel, v) * light.channel(c, v, row.vectors());
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
    const std::size_t of_vertex = size(M * M) * 3, below = size(M) * 3;
#pragma omp parallel for schedule(static)
    for (int block = 0; block < surface.blocks(); ++block) {
        Neighbours tents;
        tents_of_views(surface, block, eye, M, tents);
        const int count = surface.count(block);
        const float* from = &coefficients[size(block) * vertex_block * of_vertex];
        const auto first = [&](int i) { return from + size(i) * of_vertex + size(tents.first[i]) * 3; };
        float* to = &radiance[size(block) * 3 * vertex_block];
        for (int i = 0; i < count; ++i) {
            const float *rows = first(i), *next = first(std::min(i + ahead, count - 1));
            prefetch(next, 6 * sizeof(float));
            prefetch(next + below, 6 * sizeof(float));
            for (std::size_t c = 0; c < 3; ++c)
                to[3 * i + int(c)] = tents.weights[0][i] * rows[c] + tents.weights[1][i] * rows[3 + c] +
                                     tents.weights[2][i] * rows[below + c] +
                                     tents.weights[3][i] * rows[below + 3 + c];
        }
    }
}

void light_rows(const TransferValues& rows, int vertices, int channels, std::span<const float> light,
                std::span<float> radiance) {
    if (rows.halves.empty())
        light_rows(rows.floats.data(), vertices, channels, light, radiance);
    else
        light_rows(rows.halves.data(), vertices, channels, light, radiance);
}

}  // namespace shrm
