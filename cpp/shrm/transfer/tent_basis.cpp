#include "shrm/transfer/tent_basis.hpp"

#include <algorithm>
#include <cmath>

#include "shrm/core.hpp"

namespace shrm {

glm::dvec3 hemisphere_from_square(glm::dvec2 uv) {
    const double a = 2 * uv.x - 1, b = 2 * uv.y - 1;
    const bool along_x = std::abs(a) >= std::abs(b);
    const double r = std::max(std::abs(a), std::abs(b));
    // The angle from the axis that is nearest, at most pi/4 to either side.
    const double turn = r > 0 ? pi / 4 * (along_x ? b : a) / r : 0;
    const double near = std::copysign(std::cos(turn), along_x ? a : b), across = std::sin(turn);
    const double radius = r * std::sqrt(2 - r * r);
    return {radius * (along_x ? near : across), radius * (along_x ? across : near), 1 - r * r};
}

glm::dvec2 square_from_hemisphere(const glm::dvec3& w) {
    const double x = std::abs(w.x), y = std::abs(w.y), sine = std::sqrt(x * x + y * y);
    // r^2 = 1 - z, without its loss of digits near the pole
    const double r = w.z > 0 ? std::min(sine / std::sqrt(1 + w.z), 1.) : 1;
    const double across = r * (4 / pi) * std::atan2(std::min(x, y), std::max(x, y));
    const double a = std::copysign(x >= y ? r : across, w.x), b = std::copysign(x >= y ? across : r, w.y);
    return {(a + 1) / 2, (b + 1) / 2};
}

std::array<std::size_t, 4> FourTents::indices(int M) const {
    return {first, first + 1, first + size(M), first + size(M) + 1};
}

FourTents four_tents(int M, const glm::dvec3& w) {
    const glm::dvec2 uv = square_from_hemisphere(w) * double(M - 1);
    const int i = std::min(static_cast<int>(uv.x), M - 2), j = std::min(static_cast<int>(uv.y), M - 2);
    const double s = uv.x - i, t = uv.y - j;
    return {size(j) * size(M) + size(i), {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t}};
}

void evaluate_tents(std::span<const double> coefficients, int channels, int M,
                    std::span<const glm::dvec3> directions, std::span<double> values) {
    const auto n = static_cast<std::ptrdiff_t>(directions.size());
    const std::size_t width = size(channels);
#pragma omp parallel for schedule(static)
    for (std::ptrdiff_t k = 0; k < n; ++k) {
        const FourTents tents = four_tents(M, directions[static_cast<std::size_t>(k)]);
        double* value = values.data() + static_cast<std::size_t>(k) * width;
        std::fill_n(value, width, 0.);
        for (int corner = 0; corner < 4; ++corner) {
            const double* row = coefficients.data() + tents.indices(M)[size(corner)] * width;
            for (std::size_t c = 0; c < width; ++c) value[c] += tents.weights[size(corner)] * row[c];
        }
    }
}

// One thread: sums must not depend on how many there are.
void accumulate_tents(std::span<const double> values, int channels, int M,
                      std::span<const glm::dvec3> directions, std::span<double> sums) {
    const std::size_t width = size(channels);
    std::fill(sums.begin(), sums.end(), 0.);
    for (std::size_t k = 0; k < directions.size(); ++k) {
        const FourTents tents = four_tents(M, directions[k]);
        const double* value = values.data() + k * width;
        for (int corner = 0; corner < 4; ++corner) {
            double* row = sums.data() + tents.indices(M)[size(corner)] * width;
            for (std::size_t c = 0; c < width; ++c) row[c] += tents.weights[size(corner)] * value[c];
        }
    }
}

}  // namespace shrm
