#include "shrm/transfer/products.hpp"

#include <algorithm>
#include <vector>

#include "shrm/core.hpp"
#include "shrm/simd/vectors.hpp"

namespace shrm {
namespace {

// Sums in registers: two vectors of rows times so many terms; what remains holds the rows of a direction.
constexpr int most_terms = (vector_registers - 4) / 2 - 1;
constexpr int tile = 2 * lanes;

// Q in tiles of rows, those of a direction together, zero beyond the last row: (tiles, directions, tile).
class Tiles {
  public:
    Tiles(const VisibleSizes& sizes, std::span<const float> rays)
        : directions_(size(sizes.directions)), count_((sizes.rows + tile - 1) / tile) {
        values_.resize(size(count_) * directions_ * tile);
        for (int r = 0; r < sizes.rows; ++r)
            for (std::size_t k = 0; k < directions_; ++k)
                values_[(size(r / tile) * directions_ + k) * tile + size(r % tile)] =
                    rays[size(r) * directions_ + k];
    }
    int count() const { return count_; }
    const float* operator[](int t) const { return &values_[size(t) * directions_ * tile]; }

  private:
    std::size_t directions_;
    int count_;
    std::vector<float> values_;
};

// sums(j, i) of `width` terms and one tile, over the directions that are seen.
template <int width>
SHRM_KERNEL void sum_tile(const float* rows, const float* harmonics, int terms, std::span<const int> seen,
                          float* sums) {
    Floats sum[width][2] = {};
    for (const int k : seen) {
        const float* row = rows + size(k) * tile;
        Floats low = load(row), high = load(row + lanes);
        keep(low);
        keep(high);
        const float* y = harmonics + size(k) * size(terms);
        unrolled<width>([&](auto j) {
            sum[j][0] += y[j] * low;
            sum[j][1] += y[j] * high;
        });
    }
    unrolled<width>([&](auto j) {
        store(sums + j * tile, sum[j][0]);
        store(sums + j * tile + lanes, sum[j][1]);
    });
}

// Terms are summed in even shares of at most `most_terms`.
template <int width = most_terms>
void sum_share(int wanted, const float* rows, const float* harmonics, int terms, std::span<const int> seen,
               float* sums) {
    if (width == wanted) return sum_tile<width>(rows, harmonics, terms, seen, sums);
    if constexpr (width > 1) sum_share<width - 1>(wanted, rows, harmonics, terms, seen, sums);
}

// turned = sums times the rotation of one vertex: degree by degree, rows of a tile in lanes.
SHRM_KERNEL void rotate_tile(const float* sums, int terms, const float* rotation, float* turned) {
    for (int first = 0, extent = 1; first < terms; first += extent, extent += 2)
        for (int m = 0; m < extent; ++m) {
            Floats low{}, high{};
            for (int k = 0; k < extent; ++k) {
                const float D = rotation[k * extent + m];
                low += D * load(sums + (first + k) * tile);
                high += D * load(sums + (first + k) * tile + lanes);
            }
            store(turned + (first + m) * tile, low);
            store(turned + (first + m) * tile + lanes, high);
            if (m == extent - 1) rotation += extent * extent;
        }
}

}  // namespace

void sum_over_visible(const VisibleSizes& sizes, std::span<const float> rays,
                      std::span<const float> harmonics, std::span<const std::uint8_t> visible,
                      std::span<const float> rotations, std::span<float> products) {
    const int terms = sizes.terms, shares = (terms + most_terms - 1) / most_terms;
    const std::size_t of_rotation = rotations.size() / size(std::max(sizes.vertices, 1));
    const Tiles tiles(sizes, rays);
#pragma omp parallel
    {
        std::vector<int> seen(size(sizes.directions));
        std::vector<float> sums(size(terms) * tile), turned(size(terms) * tile);
#pragma omp for schedule(dynamic, 4)
        for (int p = 0; p < sizes.vertices; ++p) {
            // The directions that the vertex sees.
            std::size_t count = 0;
            for (int k = 0; k < sizes.directions; ++k) {
                seen[count] = k;
                count += visible[size(p) * size(sizes.directions) + size(k)] != 0;
            }
            float* product = &products[size(p) * size(sizes.rows) * size(terms)];
            // Tile by tile of rows: sums over those directions, turned into the vertex's frame if asked.
            for (int t = 0; t < tiles.count(); ++t) {
                for (int s = 0; s < shares; ++s) {
                    const int first = s * terms / shares, end = (s + 1) * terms / shares;
                    sum_share(end - first, tiles[t], harmonics.data() + first, terms, {seen.data(), count},
                              &sums[size(first) * tile]);
                }
                const float* found = sums.data();
                if (!rotations.empty()) {
                    rotate_tile(sums.data(), terms, &rotations[size(p) * of_rotation], turned.data());
                    found = turned.data();
                }
                const int rows = std::min(tile, sizes.rows - t * tile);
                for (int i = 0; i < rows; ++i)
                    for (int j = 0; j < terms; ++j)
                        product[size(t * tile + i) * size(terms) + size(j)] = found[j * tile + i];
            }
        }
    }
}

}  // namespace shrm
