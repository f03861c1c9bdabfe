#include <algorithm>

#include "shrm/core.hpp"
#include "shrm/simd/shuffles.hpp"
#include "shrm/transfer/lighting.hpp"
#include "shrm/transfer/rows.hpp"

namespace shrm {
namespace {

// K is padded to a multiple of four; a vector of the table holds lanes / 4 components of (r, g, b, 0).
constexpr int together = 4;

// Weights of `vertex_group` components, each for four lanes.
template <int quarter>
inline Floats spread(Floats weights) {
    return shuffled<[](int i) { return quarter * vertex_group + i / 4; }>(weights, weights);
}

// sum_k w_k (sum over four tents of their weights times the table's row), four lanes for each component of a
// vector.
//   table (M^2, K, 4) from the first tent on; weights (K,), and lanes more
template <class Stored>
inline Floats of_vertex(const float* table, int K, int M, const Stored* weights, const float* tents) {
    const float *right = table + 4 * K, *below = table + 4 * K * M, *both = below + 4 * K;
    const Floats w0 = tents[0] + Floats{}, w1 = tents[vertex_block] + Floats{},
                 w2 = tents[2 * vertex_block] + Floats{}, w3 = tents[3 * vertex_block] + Floats{};
    Floats sum = {};
    for (int k = 0; k < K; k += lanes) {
        const Floats of_components = load(weights + k);
        unrolled<4>([&](auto quarter) {
            const int at = 4 * (k + quarter * vertex_group);
            if (at < 4 * K)
                sum += spread<quarter>(of_components) * ((w0 * load(table + at) + w1 * load(right + at)) +
                                                         (w2 * load(below + at) + w3 * load(both + at)));
        });
    }
    return sum;
}

}  // namespace

CompressedTransfer::CompressedTransfer(const TransferValues& weights, std::span<const std::int32_t> clusters,
                                       std::span<const float> components, int vertices, int Q, int stored,
                                       int K, int M, int channels, int terms)
    : vertices_(vertices),
      Q_(Q),
      K_(round_up(K, together)),
      M_(M),
      channels_(channels),
      terms_(terms),
      half_(weights.floats.empty()),
      clusters_(clusters.begin(), clusters.end()) {
    // The weights of the first K components of each vertex, padded with zeros.
    const auto pack = [&](const auto* from, auto& to) {
        to.resize(size(vertices) * size(K_) + lanes);
        for (std::size_t p = 0; p < size(vertices); ++p)
            std::copy_n(from + p * size(stored), K, to.begin() + std::ptrdiff_t(p * size(K_)));
    };
    if (half_)
        pack(weights.halves.data(), halves_);
    else
        pack(weights.floats.data(), weights_);

    // The components' coefficients, components last.
    const std::size_t rows = size(M * M) * size(channels * terms);
    components_.resize(size(Q) * rows * size(K_) + lanes);
    for (std::size_t q = 0; q < size(Q); ++q)
        for (std::size_t k = 0; k < size(K); ++k)
            for (std::size_t row = 0; row < rows; ++row)
                components_[(q * rows + row) * size(K_) + k] =
                    components[(q * size(stored) + k) * rows + row];
    tables_.resize(size(Q) * size(M * M) * size(K_) * 4);
}

// The components' coefficients of one tent under the light.
void CompressedTransfer::light_node(std::size_t node, std::span<const float> light) {
    const std::size_t terms = size(terms_), K = size(K_);
    for (int k = 0; k < K_; k += lanes) {
        Floats sums[3] = {};
        for (std::size_t j = 0; j < terms; ++j)
            unrolled<3>([&](auto c) {
                const std::size_t channel = node * size(channels_) + (channels_ == 1 ? 0 : std::size_t(c));
                sums[c] += light[3 * j + c] * load(&components_[(channel * terms + j) * K + size(k)]);
            });
        float* to = &tables_[(node * K + size(k)) * 4];
        for (int i = 0; i < std::min(lanes, K_ - k); ++i)
            for (int c = 0; c < 3; ++c) to[4 * i + c] = sums[c][i];
    }
}

void CompressedTransfer::light(const TransferSurface& surface, std::span<const float> light, const Eye& eye,
                               std::span<float> radiance) {
    const std::size_t of_cluster = size(M_ * M_) * size(K_) * 4;
    const auto light_block = [&](const auto* weights, int block) SHRM_KERNEL {
        Neighbours tents;
        Quads found;
        tents_of_views(surface, block, eye, M_, tents);
        const int first = block * vertex_block, count = surface.count(block);
        for (int i = 0; i < count; i += vertex_group) {
            Floats sums[lanes] = {};  // every fourth of them holds a vertex's
            unrolled<vertex_group>([&](auto g) {
                const int at = std::min(i + g, count - 1), p = first + at;
                const std::size_t cluster = clusters_.empty() ? 0 : size(clusters_[size(p)]);
                const float* table = &tables_[cluster * of_cluster + size(tents.first[at] * K_) * 4];
                sums[4 * g] = of_vertex(table, K_, M_, weights + size(p) * size(K_), &tents.weights[0][at]);
            });
            add_lanes<lanes, 4>(sums);  // lane 4 g + c is now the sum of lanes c, c + 4, ... of vertex g
            store(found.values + 4 * i, sums[0]);
        }
        found.copy(count, &radiance[3 * size(first)]);
    };
    // First all components under the light, then all vertices from them.
    const auto nodes = static_cast<std::ptrdiff_t>(size(Q_) * size(M_ * M_));
#pragma omp parallel
    {
#pragma omp for schedule(static)
        for (std::ptrdiff_t node = 0; node < nodes; ++node) light_node(std::size_t(node), light);
#pragma omp for schedule(static)
        for (int block = 0; block < surface.blocks(); ++block)
            if (half_)
                light_block(halves_.data(), block);
            else
                light_block(weights_.data(), block);
    }
}

}  // namespace shrm
