#include "shrm/sh/evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "shrm/core.hpp"
#include "shrm/sh/legendre.hpp"
#include "shrm/simd/packs.hpp"

namespace shrm {
namespace {

// A real function's coefficient of (l, +-m) is the integral of f_lm times this times cos or sin(m phi).
constexpr double real_norm(int m) {
    return m == 0 ? 1 : std::numbers::sqrt2;
}

constexpr int block = 8;  // directions that are evaluated together, and channels: sums stay in registers

// The real basis at up to 8 directions, ((F+1)^2, 8).
void basis_block(const glm::dvec3* directions, int count, int F, const LegendreRecurrence& recurrence,
                 double* basis) {
    d8 x, sine, cos_1, sin_1, cos_m = 1 + d8{}, sin_m{};
    for (int n = 0; n < block; ++n) {
        const glm::dvec3 d = directions[std::min(n, count - 1)];
        sine[n] = std::sqrt(d.x * d.x + d.y * d.y);
        x[n] = d.z;
        cos_1[n] = sine[n] > 0 ? d.x / sine[n] : 1;
        sin_1[n] = sine[n] > 0 ? d.y / sine[n] : 0;
    }
    for (int m = 0; m <= F; ++m) {
        d8 f, previous{};
        for (int n = 0; n < block; ++n) f[n] = real_norm(m) * recurrence.start(m) * power(sine[n], m);
        for (int l = m; l <= F; ++l) {
            store(basis + lm(l, -m) * block, f * sin_m);
            store(basis + lm(l, m) * block, f * cos_m);  // m = 0: last
            const auto [a, b] = recurrence.steps(m)[l - m];
            const d8 next = a * x * f - b * previous;
            previous = f;
            f = next;
        }
        const d8 next = cos_m * cos_1 - sin_m * sin_1;
        sin_m = sin_m * cos_1 + cos_m * sin_1;
        cos_m = next;
    }
}

// values(n, c) = sum over k of basis(k, n) coefficients(k, c), coefficients ((F+1)^2, channels rounded up to
// 8).
void basis_product(const double* basis, const double* coefficients, std::size_t terms, int channels,
                   int count, double* values) {
    const std::size_t stride = size(round_up(channels, block));
    for (int c0 = 0; c0 < channels; c0 += block) {
        d8 sums[block] = {};
        for (std::size_t k = 0; k < terms; ++k) {
            const d8 c = load(coefficients + k * stride + c0);
            for (int n = 0; n < block; ++n) sums[n] += basis[k * block + size(n)] * c;
        }
        for (int n = 0; n < count; ++n)
            store_first(values + size(n) * size(channels) + c0, sums[n], channels - c0);
    }
}

}  // namespace

void evaluate(std::span<const double> coefficients, int channels, int F,
              std::span<const glm::dvec3> directions, std::span<double> values) {
    const LegendreRecurrence recurrence(F);
    const std::size_t terms = basis_size(F), stride = size(round_up(channels, block));
    std::vector<double> padded(terms * stride, 0.);
    for (std::size_t k = 0; k < terms; ++k)
        for (std::size_t c = 0; c < size(channels); ++c)
            padded[k * stride + c] = coefficients[k * size(channels) + c];
    const auto n = static_cast<std::ptrdiff_t>(directions.size());
#pragma omp parallel
    {
        std::vector<double> basis(terms * block);
#pragma omp for schedule(static)
        for (std::ptrdiff_t i = 0; i < n; i += block) {
            const int count = static_cast<int>(std::min<std::ptrdiff_t>(block, n - i));
            basis_block(directions.data() + i, count, F, recurrence, basis.data());
            basis_product(basis.data(), padded.data(), terms, channels, count, values.data() + i * channels);
        }
    }
}

}  // namespace shrm
