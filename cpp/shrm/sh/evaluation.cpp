#include "shrm/sh/evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "shrm/core.hpp"
#include "shrm/sh/legendre.hpp"
#include "shrm/simd/vectors.hpp"

namespace shrm {
namespace {

// A real function's coefficient of (l, +-m) is the integral of f_lm times this times cos or sin(m phi).
constexpr double real_norm(int m) {
    return m == 0 ? 1 : std::numbers::sqrt2;
}

constexpr int block = 8;  // directions that are evaluated together: sums stay in registers

Doubles load_doubles(const double* from) {
    Doubles v;
    std::memcpy(&v, from, sizeof v);
    return v;
}

void store_doubles(double* to, Doubles v) {
    std::memcpy(to, &v, sizeof v);
}

// The real basis at up to 8 directions, ((F+1)^2, 8), for a vector of them from `first` on.
void basis_block(const glm::dvec3* directions, int first, int count, int F,
                 const LegendreRecurrence& recurrence, double* basis) {
    Doubles x, sine, cos_1, sin_1, cos_m = 1 + Doubles{}, sin_m{};
    for (int n = 0; n < double_lanes; ++n) {
        const glm::dvec3 d = directions[std::min(first + n, count - 1)];
        sine[n] = std::sqrt(d.x * d.x + d.y * d.y);
        x[n] = d.z;
        cos_1[n] = sine[n] > 0 ? d.x / sine[n] : 1;
        sin_1[n] = sine[n] > 0 ? d.y / sine[n] : 0;
    }
    for (int m = 0; m <= F; ++m) {
        Doubles f, previous{};
        for (int n = 0; n < double_lanes; ++n) f[n] = real_norm(m) * recurrence.start(m) * power(sine[n], m);
        for (int l = m; l <= F; ++l) {
            store_doubles(basis + lm(l, -m) * block + first, f * sin_m);
            store_doubles(basis + lm(l, m) * block + first, f * cos_m);  // m = 0: last
            const auto [a, b] = recurrence.steps(m)[l - m];
            const Doubles next = a * x * f - b * previous;
            previous = f;
            f = next;
        }
        const Doubles next = cos_m * cos_1 - sin_m * sin_1;
        sin_m = sin_m * cos_1 + cos_m * sin_1;
        cos_m = next;
    }
}

// values(n, c) = sum over k of basis(k, n) coefficients(k, c), coefficients ((F+1)^2, channels rounded up to
// whole vectors).
void basis_product(const double* basis, const double* coefficients, std::size_t terms, int channels,
                   int count, double* values) {
    const std::size_t stride = size(round_up(channels, double_lanes));
    for (int c0 = 0; c0 < channels; c0 += double_lanes) {
        Doubles sums[block] = {};
        for (std::size_t k = 0; k < terms; ++k) {
            const Doubles c = load_doubles(coefficients + k * stride + c0);
            for (int n = 0; n < block; ++n) sums[n] += basis[k * block + size(n)] * c;
        }
        for (int n = 0; n < count; ++n)
            for (int c = c0; c < std::min(c0 + double_lanes, channels); ++c)
                values[size(n) * size(channels) + size(c)] = sums[n][c - c0];
    }
}

}  // namespace

void evaluate(std::span<const double> coefficients, int channels, int F,
              std::span<const glm::dvec3> directions, std::span<double> values) {
    const LegendreRecurrence recurrence(F);
    const std::size_t terms = basis_size(F), stride = size(round_up(channels, double_lanes));
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
            for (int first = 0; first < block; first += double_lanes)
                basis_block(directions.data() + i, first, count, F, recurrence, basis.data());
            basis_product(basis.data(), padded.data(), terms, channels, count, values.data() + i * channels);
        }
    }
}

}  // namespace shrm
