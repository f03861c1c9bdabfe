// Shared by all kinds of lobe: the picture's planes, and queries dealt out to threads. Private to angular.
#pragma once

#include <vector>

#include "shrm/angular/angular.hpp"
#include "shrm/angular/sums.hpp"

namespace shrm::angular {

struct Planes {
    std::size_t length, stride;
    const float* first;

    explicit Planes(const Picture& picture)
        : length(size(row_length(picture.W))),
          stride(length * size(picture.H)),
          first(picture.planes.data()) {}
    SHRM_INLINE const float* at(int channel, int row, int column) const {
        return first + size(channel) * stride + size(row) * length + size(column);
    }
};

// Row `from` and the next of a table of rows of n values, mixed.
SHRM_INLINE void mix_rows(const float* __restrict table, std::size_t n, int from, float t,
                          std::vector<float>& out) {
    out.resize(n);
    const float* __restrict low = table + size(from) * n;
    const float* __restrict high = low + n;
    float* __restrict mixed = out.data();
    for (std::size_t k = 0; k < n; ++k) mixed[k] = low[k] + t * (high[k] - low[k]);
}

// One scratch for each thread; queries are dealt out in small groups and never share a sum.
template <class Scratch, class Query>
void for_each_query(std::size_t count, const Query& query) {
#pragma omp parallel
    {
        Scratch scratch;
#pragma omp for schedule(dynamic, 4)
        for (std::ptrdiff_t q = 0; q < static_cast<std::ptrdiff_t>(count); ++q)
            query(static_cast<std::size_t>(q), scratch);
    }
}

}  // namespace shrm::angular
