#include "shrm/reflection/local_form.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>
#include <vector>

#include "shrm/core.hpp"
#include "shrm/sh/ring_fourier.hpp"
#include "shrm/sh/wigner.hpp"

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

// The sizes, coefficients and recurrences that all rings of a local map share.
struct LocalForm {
    int F, P, channels;
    std::span<const double> rho;
    std::vector<Complex> L;                     // L_lm of the complex basis, (lm, channel)
    std::vector<WignerRecurrence> recurrences;  // (q, m = -F..F)

    LocalForm(std::span<const double> light, std::span<const double> rho_, int F_, int P_, int channels_)
        : F(F_), P(P_), channels(channels_), rho(rho_), L(basis_size(F_) * size(channels_)) {
        for (int q = 0; q <= P; ++q)
            for (int m = -F; m <= F; ++m) recurrences.emplace_back(m, q, F);
        for (int l = 0; l <= F; ++l)
            for (int m = -l; m <= l; ++m)
                for (int c = 0; c < channels; ++c)
                    L[lm(l, m) * size(channels) + size(c)] = complex_coefficient(light, l, m, channels, c);
    }

    int planes() const { return (P + 1) * (P + 1) * channels; }

    // B_mpq(alpha) = sum_l B_lmpq d^l_mq(alpha)   [RH02] eq. 14, first step of app. C, step 3
    // B_lmpq = L_lm rho_lpq                       [RH02] eq. 5, without Lambda_l as in app. A
    // for one q and |m|: B (sign of m, p, channel)
    void sum_degrees(double alpha, int q, int m, std::vector<Complex>& B) const {
        const double x = std::cos(alpha), cos_half = std::cos(alpha / 2), sin_half = std::sin(alpha / 2);
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
    }

    // B_pq(alpha, beta) = sum_m B_mpq e^{i m beta}   [RH02] eq. 14, second step of app. C, step 3: its real
    // and its imaginary part as cosines and sines of m beta.   mode: of the maps' cosines, then of their
    // sines
    void write_modes(int q, const std::vector<Complex>& B, float* mode) const {
        const double norm = q ? std::numbers::sqrt2 : 1;
        for (int p = q; p <= P; ++p)
            for (int c = 0; c < channels; ++c) {
                const Complex u = B[size(p * channels + c)], v = B[size((P + 1 + p) * channels + c)];
                const int re = (p * (p + 1) + q) * channels + c, im = (p * (p + 1) - q) * channels + c;
                mode[re] = static_cast<float>(norm * (u.real() + v.real()));
                mode[planes() + re] = static_cast<float>(norm * (v.imag() - u.imag()));
                if (q == 0) continue;
                mode[im] = static_cast<float>(-norm * (u.imag() + v.imag()));
                mode[planes() + im] = static_cast<float>(-norm * (u.real() - v.real()));
            }
    }
};

// d^p_{sq}(-alpha) of [RH02] eq. 8 at [q, s], as d^p_{qs}(alpha).
std::vector<double> wigner_matrix(int p, double alpha) {
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
    return d;
}

}  // namespace

void local_reflection_map(std::span<const double> light, std::span<const double> rho, int F, int P,
                          int channels, int H, int W, std::span<float> rings) {
    const RingFourier fourier(W, F);
    const LocalForm form(light, rho, F, P, channels);
    const int planes = form.planes(), stride = 2 * planes;
#pragma omp parallel
    {
        std::vector<float> modes(size(F + 1) * size(stride));
        std::vector<Complex> B(size(2 * (P + 1) * channels));
#pragma omp for schedule(static)
        for (int i = 0; i < H; ++i) {
            std::fill(modes.begin(), modes.end(), 0.f);
            for (int q = 0; q <= P; ++q)
                for (int m = 0; m <= F; ++m) {
                    form.sum_degrees((i + 0.5) * pi / H, q, m, B);
                    form.write_modes(q, B, &modes[size(m * stride)]);
                }
            fourier.synthesise(modes.data(), planes, stride, &rings[size(i) * size(planes) * size(W)]);
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
            const std::vector<double> d = wigner_matrix(p, alpha);
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

}  // namespace shrm
