#include "shrm/sh.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "shrm/core.hpp"
#include "shrm/legendre.hpp"
#include "shrm/quadrature.hpp"
#include "shrm/ring_fourier.hpp"

namespace shrm {
namespace {

typedef double d8 __attribute__((vector_size(64)));
typedef double d8u __attribute__((vector_size(64), aligned(8)));

// A real function's coefficient of (l, +-m) is the integral of f_lm times this times cos or sin(m phi).
constexpr double real_norm(int m) {
    return m == 0 ? 1 : std::numbers::sqrt2;
}

// The theta half of the analysis: for the northern rings, nodes and weights such that the sum over a ring's
// nodes of weight f_lm(node) is f_lm sin(theta) dtheta for samples, or its integral over the row for areas.
struct RingQuadrature {
    int rings, nodes_per_ring;
    std::vector<double> x, sine, weight;  // (nodes_per_ring, rings rounded up to 8)

    RingQuadrature(int H, int F, Texel texel) : rings((H + 1) / 2), nodes_per_ring(1) {
        const double row = pi / H;
        std::vector<double> offsets{0.}, weights{1.};
        if (texel == Texel::area) {
            // f_lm sin(theta) is a trigonometric polynomial of degree l + 1: within a row it turns by
            // (F + 1) row radians, and 5 more nodes than half of that leave an error below 1e-13.
            nodes_per_ring = 5 + static_cast<int>((F + 1) * row / 2);
            gauss_legendre(nodes_per_ring, offsets, weights);
        }
        const std::vector<double> fejer = texel == Texel::sample ? fejer_weights(H) : std::vector<double>{};
        const int padded = round_up(rings, 8);
        x.assign(size(nodes_per_ring * padded), 0);
        sine = weight = x;
        for (int g = 0; g < nodes_per_ring; ++g)
            for (int i = 0; i < rings; ++i) {
                const double theta = (i + 0.5 + offsets[size(g)] / 2) * row;
                const std::size_t at = size(g * padded + i);
                x[at] = std::cos(theta);
                sine[at] = std::sin(theta);
                weight[at] = texel == Texel::sample ? fejer[size(i)] : weights[size(g)] * row / 2 * sine[at];
            }
    }
};

// One order m of the analysis: f_lm over all northern rings at once, by the recurrence in l.
//   modes (2 parities, 2 channels of cos and sin, rings padded), coefficients ((F+1)^2, channels)
void legendre_analysis(int m, int F, int channels, const LegendreRecurrence& recurrence,
                       const RingQuadrature& quadrature, const double* modes, double* coefficients) {
    const int padded = round_up(quadrature.rings, 8), count = quadrature.nodes_per_ring * padded;
    std::vector<double> f(size(count)), previous(size(count), 0.), row(size(padded));
    for (int i = 0; i < count; ++i) f[size(i)] = recurrence.start(m) * power(quadrature.sine[size(i)], m);
    for (int l = m; l <= F; ++l) {
        std::fill(row.begin(), row.end(), 0.);
        for (int g = 0; g < quadrature.nodes_per_ring; ++g)
            for (int i = 0; i < padded; ++i)
                row[size(i)] += quadrature.weight[size(g * padded + i)] * f[size(g * padded + i)];
        for (int z = 0; z < 2 * channels; ++z) {
            const double* mode = modes + (size((l - m) % 2 * 2 * channels + z)) * size(padded);
            d8 sums = {};
            for (int i = 0; i < padded; i += 8)
                sums +=
                    *reinterpret_cast<const d8u*>(&row[size(i)]) * *reinterpret_cast<const d8u*>(mode + i);
            double sum = 0;
            for (int i = 0; i < 8; ++i) sum += sums[i];
            const bool is_sine = z >= channels;
            if (m > 0 || !is_sine)
                coefficients[lm(l, is_sine ? -m : m) * size(channels) + size(z % channels)] =
                    real_norm(m) * sum;
        }
        const auto [a, b] = recurrence.steps(m)[l - m];
        for (int i = 0; i < count; ++i) {
            const double next = a * quadrature.x[size(i)] * f[size(i)] - b * previous[size(i)];
            previous[size(i)] = f[size(i)];
            f[size(i)] = next;
        }
    }
}

// The coefficients reordered for the synthesis: (m, l, cos | sin, channels rounded up to 8).
std::vector<float> by_order(std::span<const double> coefficients, int channels, int stride, int F) {
    std::vector<float> ordered(basis_size(F) * size(2 * stride), 0.f);
    std::size_t at = 0;
    for (int m = 0; m <= F; ++m)
        for (int l = m; l <= F; ++l, at += size(2 * stride))
            for (int c = 0; c < channels; ++c) {
                ordered[at + size(c)] =
                    static_cast<float>(real_norm(m) * coefficients[lm(l, m) * size(channels) + size(c)]);
                if (m > 0)
                    ordered[at + size(stride + c)] =
                        static_cast<float>(real_norm(m) * coefficients[lm(l, -m) * size(channels) + size(c)]);
            }
    return ordered;
}

// The modes of B rings of the north and their mirror images in the south.
//   modes (2 B, F + 1, 2, stride): ring b, then ring b of the south at B + b
template <int B>
inline void legendre_synthesis(const double* theta, int F, int stride, const LegendreRecurrence& recurrence,
                               const float* ordered, float* modes) {
    double x[B], sine[B];
    for (int b = 0; b < B; ++b) x[b] = std::cos(theta[b]), sine[b] = std::sin(theta[b]);
    const std::size_t width = size(2 * stride), ring = size(F + 1) * width;
    for (int m = 0; m <= F; ++m) {
        double f[B], previous[B] = {};
        for (int b = 0; b < B; ++b) f[b] = recurrence.start(m) * power(sine[b], m);
        float* north = modes + size(m) * width;
        float* south = north + B * ring;
        for (int b = 0; b < B; ++b) {
            std::fill_n(north + size(b) * ring, width, 0.f);
            std::fill_n(south + size(b) * ring, width, 0.f);
        }
        // f_lm(pi - theta) = (-1)^{l+m} f_lm(theta): even l - m into one sum, odd into the other
        for (int l = m; l <= F; ++l, ordered += width) {
            float* sum = (l - m) % 2 ? south : north;
            for (int b = 0; b < B; ++b) {
                const auto fb = static_cast<float>(f[b]);
                float* to = sum + size(b) * ring;
                for (std::size_t z = 0; z < width; ++z) to[z] += fb * ordered[z];
            }
            const auto [a0, b0] = recurrence.steps(m)[l - m];
            for (int b = 0; b < B; ++b) {
                const double next = a0 * x[b] * f[b] - b0 * previous[b];
                previous[b] = f[b];
                f[b] = next;
            }
        }
        for (int b = 0; b < B; ++b) {
            float *even = north + size(b) * ring, *odd = south + size(b) * ring;
            for (std::size_t z = 0; z < width; ++z) {
                const float e = even[z], o = odd[z];
                even[z] = e + o;
                odd[z] = e - o;
            }
        }
    }
}

constexpr int ring_block = 4;

void synthesis_block(int i0, int H, int W, int F, int channels, int stride,
                     const LegendreRecurrence& recurrence, const RingFourier& fourier,
                     const std::vector<float>& ordered, std::vector<float>& modes,
                     std::vector<float>& scratch, float* rings) {
    double theta[ring_block];
    for (int b = 0; b < ring_block; ++b) theta[b] = (i0 + b + 0.5) * pi / H;
    legendre_synthesis<ring_block>(theta, F, stride, recurrence, ordered.data(), modes.data());
    const std::size_t mode_size = size(F + 1) * size(2 * stride), ring_size = size(channels) * size(W);
    for (int b = 0; b < ring_block && i0 + b < (H + 1) / 2; ++b) {
        const int north = i0 + b, south = H - 1 - north;
        fourier.synthesise(modes.data() + size(b) * mode_size, channels, stride,
                           rings + size(north) * ring_size, scratch);
        if (south != north)
            fourier.synthesise(modes.data() + size(ring_block + b) * mode_size, channels, stride,
                               rings + size(south) * ring_size, scratch);
    }
}

}  // namespace

std::vector<double> fejer_weights(int H) {
    // w_i = 2/H (1 - 2 sum_k cos(2 k theta_i) / (4 k^2 - 1)), k <= H/2 [W06]; the cosines by recurrence.
    std::vector<double> weights(size(H));
    for (int i = 0; i < H; ++i) {
        const double twice = 2 * std::cos(2 * (i + 0.5) * pi / H);
        double sum = 0, c0 = 1, c1 = twice / 2;
        for (int k = 1; k <= H / 2; ++k) {
            sum += c1 / (4.0 * k * k - 1);
            c0 = std::exchange(c1, twice * c1 - c0);
        }
        weights[size(i)] = 2.0 / H * (1 - 2 * sum);
    }
    return weights;
}

void analysis(std::span<const float> pixels, int H, int W, int channels, int F, Texel texel,
              std::span<double> coefficients) {
    const RingFourier fourier(W, F);
    const RingQuadrature quadrature(H, F, texel);
    const LegendreRecurrence recurrence(F);
    const int rings = quadrature.rings, padded = round_up(rings, 8), parts = 2 * channels;
    // (m, even | odd in theta, cos | sin, channel, ring)
    std::vector<double> modes(size(F + 1) * size(2 * parts) * size(padded), 0.);
#pragma omp parallel
    {
        std::vector<double> north(size(parts) * size(F + 1)), south(north.size());
        std::vector<float> scratch;
#pragma omp for schedule(static)
        for (int i = 0; i < rings; ++i) {
            const std::size_t row = size(W) * size(channels);
            // L_m(theta), the integral over phi: [RH02] section 6.1, first step
            fourier.analyse(&pixels[size(i) * row], channels, texel, north.data(), scratch);
            if (H - 1 - i != i)
                fourier.analyse(&pixels[size(H - 1 - i) * row], channels, texel, south.data(), scratch);
            else
                std::fill(south.begin(), south.end(), 0.);  // the equator's ring mirrors onto itself
            for (int m = 0; m <= F; ++m)
                for (int c = 0; c < channels; ++c)
                    for (int s = 0; s < 2; ++s) {
                        const std::size_t from = size(c * 2 + s) * size(F + 1) + size(m);
                        double* to =
                            &modes[(size(m * 2) * size(parts) + size(s * channels + c)) * size(padded) +
                                   size(i)];
                        to[0] = north[from] + south[from];
                        to[size(parts) * size(padded)] = north[from] - south[from];
                    }
        }
        // L_lm, the integral over theta: [RH02] section 6.1, second step
#pragma omp for schedule(dynamic)
        for (int m = 0; m <= F; ++m)
            legendre_analysis(m, F, channels, recurrence, quadrature,
                              &modes[size(m * 2 * parts) * size(padded)], coefficients.data());
    }
}

void synthesis(std::span<const double> coefficients, int channels, int F, int H, int W,
               std::span<float> rings) {
    const int stride = round_up(channels, 8);
    const RingFourier fourier(W, F);
    const LegendreRecurrence recurrence(F);
    const std::vector<float> ordered = by_order(coefficients, channels, stride, F);
#pragma omp parallel
    {
        std::vector<float> modes(size(2 * ring_block) * size(F + 1) * size(2 * stride)), scratch;
#pragma omp for schedule(static)
        for (int i0 = 0; i0 < (H + 1) / 2; i0 += ring_block)
            synthesis_block(i0, H, W, F, channels, stride, recurrence, fourier, ordered, modes, scratch,
                            rings.data());
    }
}

namespace {

// Directions that are evaluated together, and channels: a block of sums that stays in registers.
constexpr int block = 8;

// The real basis at up to 8 directions, ((F+1)^2, 8).
template <class Real>
void basis_block(const glm::dvec3* directions, int count, int F, const LegendreRecurrence& recurrence,
                 Real* basis) {
    double x[block], sine[block], cos1[block], sin1[block], cosm[block], sinm[block];
    for (int n = 0; n < block; ++n) {
        const glm::dvec3 d = directions[std::min(n, count - 1)];
        sine[n] = std::sqrt(d.x * d.x + d.y * d.y);
        x[n] = d.z;
        cos1[n] = sine[n] > 0 ? d.x / sine[n] : 1;
        sin1[n] = sine[n] > 0 ? d.y / sine[n] : 0;
        cosm[n] = 1;
        sinm[n] = 0;
    }
    for (int m = 0; m <= F; ++m) {
        double f[block], previous[block] = {};
        for (int n = 0; n < block; ++n) f[n] = real_norm(m) * recurrence.start(m) * power(sine[n], m);
        for (int l = m; l <= F; ++l) {
            Real* cosines = basis + lm(l, m) * block;
            Real* sines = basis + lm(l, -m) * block;
            for (int n = 0; n < block; ++n) sines[n] = static_cast<Real>(f[n] * sinm[n]);
            for (int n = 0; n < block; ++n) cosines[n] = static_cast<Real>(f[n] * cosm[n]);  // m = 0: last
            const auto [a, b] = recurrence.steps(m)[l - m];
            for (int n = 0; n < block; ++n) {
                const double next = a * x[n] * f[n] - b * previous[n];
                previous[n] = f[n];
                f[n] = next;
            }
        }
        for (int n = 0; n < block; ++n) {
            const double next = cosm[n] * cos1[n] - sinm[n] * sin1[n];
            sinm[n] = sinm[n] * cos1[n] + cosm[n] * sin1[n];
            cosm[n] = next;
        }
    }
}

// values(n, c) = sum over k of basis(k, n) coefficients(k, c), coefficients ((F+1)^2, channels rounded up to
// 8).
template <class Real>
void basis_product(const Real* basis, const Real* coefficients, std::size_t terms, int channels, int count,
                   Real* values) {
    typedef Real pack __attribute__((vector_size(block * sizeof(Real))));
    typedef Real packu __attribute__((vector_size(block * sizeof(Real)), aligned(sizeof(Real))));
    const std::size_t stride = size(round_up(channels, block));
    for (int c0 = 0; c0 < channels; c0 += block) {
        pack sums[block] = {};
        for (std::size_t k = 0; k < terms; ++k) {
            const pack c = *reinterpret_cast<const packu*>(coefficients + k * stride + c0);
            for (int n = 0; n < block; ++n) sums[n] += basis[k * block + size(n)] * c;
        }
        for (int n = 0; n < count; ++n)
            for (int c = c0; c < std::min(c0 + block, channels); ++c)
                values[size(n) * size(channels) + size(c)] = sums[n][c - c0];
    }
}

}  // namespace

template <class Real>
void evaluate(std::span<const double> coefficients, int channels, int F,
              std::span<const glm::dvec3> directions, std::span<Real> values) {
    const LegendreRecurrence recurrence(F);
    const std::size_t terms = basis_size(F), stride = size(round_up(channels, block));
    std::vector<Real> padded(terms * stride, Real(0));
    for (std::size_t k = 0; k < terms; ++k)
        for (std::size_t c = 0; c < size(channels); ++c)
            padded[k * stride + c] = static_cast<Real>(coefficients[k * size(channels) + c]);
    const auto n = static_cast<std::ptrdiff_t>(directions.size());
#pragma omp parallel
    {
        std::vector<Real> basis(terms * block);
#pragma omp for schedule(static)
        for (std::ptrdiff_t i = 0; i < n; i += block) {
            const int count = static_cast<int>(std::min<std::ptrdiff_t>(block, n - i));
            basis_block<Real>(directions.data() + i, count, F, recurrence, basis.data());
            basis_product<Real>(basis.data(), padded.data(), terms, channels, count,
                                values.data() + i * channels);
        }
    }
}

template void evaluate(std::span<const double>, int, int, std::span<const glm::dvec3>, std::span<float>);
template void evaluate(std::span<const double>, int, int, std::span<const glm::dvec3>, std::span<double>);

}  // namespace shrm
