#include "shrm/reflection_map.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>
#include <vector>

#include "shrm/core.hpp"
#include "shrm/ring_fourier.hpp"
#include "shrm/wigner.hpp"

namespace shrm {
namespace {

using Complex = std::complex<double>;

// L_lm of the complex basis, for either sign of m, from real coefficients.
Complex complex_coefficient(std::span<const double> real, int l, int m, int channels, int c) {
    const auto at = [&](int order) { return real[lm(l, order) * size(channels) + size(c)]; };
    if (m == 0) return at(0);
    const Complex positive = Complex(at(std::abs(m)), -at(-std::abs(m))) / std::numbers::sqrt2;
    if (m > 0) return positive;
    return m % 2 ? -std::conj(positive) : std::conj(positive);
}

std::size_t rho_index(int l, int p, int q, int P, int channels, int c) {
    return ((size(l) * size(P + 1) + size(p)) * size(P + 1) + size(q)) * size(channels) + size(c);
}

}  // namespace

void local_reflection_map(std::span<const double> light, std::span<const double> rho, int F, int P,
                          int channels, int H, int W, std::span<float> rings) {
    const RingFourier fourier(W, F);
    const int maps = (P + 1) * (P + 1), stride = (maps * channels + 7) / 8 * 8;
    // recurrences (q, m = -F..F), shared by all rings, all p and all channels
    std::vector<WignerRecurrence> recurrences;
    for (int q = 0; q <= P; ++q)
        for (int m = -F; m <= F; ++m) recurrences.emplace_back(m, q, F);
    std::vector<Complex> L(basis_size(F) * size(channels));
    for (int l = 0; l <= F; ++l)
        for (int m = -l; m <= l; ++m)
            for (int c = 0; c < channels; ++c)
                L[lm(l, m) * size(channels) + size(c)] = complex_coefficient(light, l, m, channels, c);

#pragma omp parallel
    {
        std::vector<float> modes(size(F + 1) * size(2 * stride)), scratch;
        std::vector<Complex> B(size(2 * (P + 1) * channels));  // (sign of m, p, channel) at one q and |m|
#pragma omp for schedule(static)
        for (int i = 0; i < H; ++i) {
            const double alpha = (i + 0.5) * pi / H, x = std::cos(alpha);
            const double cos_half = std::cos(alpha / 2), sin_half = std::sin(alpha / 2);
            std::fill(modes.begin(), modes.end(), 0.f);
            for (int q = 0; q <= P; ++q)
                for (int m = 0; m <= F; ++m) {
                    // B_mpq(alpha) = sum_l B_lmpq d^l_mq(alpha)   [RH02] eq. 14, first step of app. C, step 3
                    // B_lmpq = L_lm rho_lpq                       [RH02] eq. 5, without Lambda_l as in app. A
                    std::fill(B.begin(), B.end(), 0);
                    for (int sign = 0; sign < (m ? 2 : 1); ++sign) {
                        const int order = sign ? -m : m;
                        const WignerRecurrence& recurrence = recurrences[size(q * (2 * F + 1) + order + F)];
                        double d = recurrence.start(cos_half, sin_half), previous = 0;
                        for (int l = recurrence.first_degree(); l <= F; ++l) {
                            for (int p = q; p <= P; ++p)
                                for (int c = 0; c < channels; ++c)
                                    B[size((sign * (P + 1) + p) * channels + c)] +=
                                        d * rho[rho_index(l, p, q, P, channels, c)] *
                                        L[lm(l, order) * size(channels) + size(c)];
                            if (l == F) break;
                            const auto [a, b, back] = recurrence.step(l);
                            previous = std::exchange(d, (a * x + b) * d - back * previous);
                        }
                    }
                    // B_pq(alpha, beta) = sum_m B_mpq e^{i m beta}   [RH02] eq. 14, second step of app. C,
                    // step 3: its real and its imaginary part as cosines and sines of m beta
                    for (int p = q; p <= P; ++p)
                        for (int c = 0; c < channels; ++c) {
                            const Complex u = B[size(p * channels + c)],
                                          v = B[size((P + 1 + p) * channels + c)];
                            float* mode = &modes[size(m * 2 * stride)];
                            const double norm = q ? std::numbers::sqrt2 : 1;
                            const int re = (p * (p + 1) + q) * channels + c,
                                      im = (p * (p + 1) - q) * channels + c;
                            mode[re] = static_cast<float>(norm * (u.real() + v.real()));
                            mode[stride + re] = static_cast<float>(norm * (v.imag() - u.imag()));
                            if (q == 0) continue;
                            mode[im] = static_cast<float>(-norm * (u.imag() + v.imag()));
                            mode[stride + im] = static_cast<float>(-norm * (u.real() - v.real()));
                        }
                }
            fourier.synthesise(modes.data(), maps * channels, stride,
                               &rings[size(i) * size(maps * channels) * size(W)], scratch);
        }
    }
}

void global_from_local(std::span<const float> local, int P, int channels, int H, int W,
                       std::span<float> global) {
    const std::size_t maps = size((P + 1) * (P + 1)), n = size(channels), width = size(W);
#pragma omp parallel for schedule(static)
    for (int i = 0; i < H; ++i) {
        const double alpha = (i + 0.5) * pi / H;
        const auto at = [&](int p, int q, int c) {
            return (((size(i) * maps) + lm(p, q)) * n + size(c)) * width;
        };
        for (int p = 0; p <= P; ++p) {
            // d^p_{sq}(-alpha) of [RH02] eq. 8 at [q, s], as d^p_{qs}(alpha)
            std::vector<double> d(size(2 * p + 1) * size(2 * p + 1));
            for (int q = -p; q <= p; ++q)
                for (int s = -p; s <= p; ++s) {
                    const WignerRecurrence recurrence(q, s, p);
                    double value = recurrence.start(std::cos(alpha / 2), std::sin(alpha / 2)), previous = 0;
                    for (int l = recurrence.first_degree(); l < p; ++l) {
                        const auto [a, b, back] = recurrence.step(l);
                        previous = std::exchange(value, (a * std::cos(alpha) + b) * value - back * previous);
                    }
                    d[size((q + p) * (2 * p + 1) + s + p)] = value;
                }
            for (int c = 0; c < channels; ++c)
                for (int j = 0; j < W; ++j) {
                    const double beta = pi - 2 * pi * (j + 0.5) / W;
                    // B~_pq = sum_s d^p_{sq}(-alpha) e^{-i q beta} B_ps   [RH02] eq. 8
                    for (int q = 0; q <= p; ++q) {
                        Complex sum = 0;
                        for (int s = -p; s <= p; ++s) {
                            const int a = std::abs(s);
                            Complex B = local[at(p, a, c) + size(j)];
                            if (s)
                                B = Complex(B.real(), -local[at(p, -a, c) + size(j)]) / std::numbers::sqrt2;
                            if (s < 0) B = a % 2 ? -std::conj(B) : std::conj(B);
                            sum += d[size((q + p) * (2 * p + 1) + s + p)] * B;
                        }
                        sum *= std::polar(q ? std::numbers::sqrt2 : 1, -q * beta);
                        global[at(p, q, c) + size(j)] = static_cast<float>(sum.real());
                        if (q) global[at(p, -q, c) + size(j)] = static_cast<float>(-sum.imag());
                    }
                }
        }
    }
}

void global_coefficients(std::span<const double> light, std::span<const double> rho, int F, int P,
                         int channels, std::span<double> coefficients) {
    const ClebschGordan coupling(2 * (F + P) + 1);
    const int J = F + P, n = channels, maps = (P + 1) * (P + 1);
    std::fill(coefficients.begin(), coefficients.end(), 0.);
    std::vector<std::pair<int, int>> orders;
    for (int p = 0; p <= P; ++p)
        for (int q = 0; q <= p; ++q) orders.emplace_back(p, q);
#pragma omp parallel for schedule(dynamic)
    for (std::size_t index = 0; index < orders.size(); ++index) {
        const auto [p, q] = orders[index];
        std::vector<Complex> b(basis_size(J) * size(n));  // b^pq_jk, complex basis
        std::vector<double> shape(size(n));               // shape_lj, one l and one j at a time
        for (int l = 0; l <= F; ++l)
            for (int j = std::abs(l - p); j <= l + p; j += 2) {  // odd l + p - j cancels between s and -s
                std::fill(shape.begin(), shape.end(), 0.);
                for (int s = -std::min(l, p); s <= std::min(l, p); ++s) {
                    const double w =
                        std::sqrt(4 * pi / (2 * j + 1)) * (s % 2 ? -1 : 1) * coupling(l, s, p, -s, j);
                    for (int c = 0; c < n; ++c)
                        shape[size(c)] += w * rho[rho_index(l, p, std::abs(s), P, n, c)];
                }
                for (int k = std::max(-j, -l - q); k <= std::min(j, l - q); ++k) {
                    // L_lm rho_lps of [RH02] eq. 5 at m = k + q, summed over s in `shape`
                    const double w = (q % 2 ? -1 : 1) * coupling(l, k + q, p, -q, j);
                    for (int c = 0; c < n; ++c)
                        b[lm(j, k) * size(n) + size(c)] +=
                            w * shape[size(c)] * complex_coefficient(light, l, k + q, n, c);
                }
            }
        // The maps sqrt2 Re B~_pq and -sqrt2 Im B~_pq are real functions: x_jk = (b_jk + (-1)^k conj b_j,-k)
        // / 2 and likewise for the imaginary part, then into the real basis.
        const double norm = q ? std::numbers::sqrt2 : 1;
        for (int j = 0; j <= F + p; ++j)
            for (int k = 0; k <= j; ++k)
                for (int c = 0; c < n; ++c) {
                    const Complex plus = b[lm(j, k) * size(n) + size(c)];
                    const Complex minus = std::conj(b[lm(j, -k) * size(n) + size(c)]) * (k % 2 ? -1. : 1.);
                    const Complex re = norm * (plus + minus) / 2.,
                                  im = -norm * (plus - minus) / Complex(0, 2);
                    const auto store = [&](int map_q, Complex value) {
                        const auto at = [&](int order) -> double& {
                            return coefficients[(lm(j, order) * size(maps) + lm(p, map_q)) * size(n) +
                                                size(c)];
                        };
                        at(k) = k ? std::numbers::sqrt2 * value.real() : value.real();
                        if (k) at(-k) = -std::numbers::sqrt2 * value.imag();
                    };
                    store(q, re);
                    if (q) store(-q, im);
                }
    }
}

}  // namespace shrm
