#include "shrm/brdf_analysis.hpp"

#include <algorithm>
#include <cmath>

#include "shrm/core.hpp"
#include "shrm/legendre.hpp"

namespace shrm {
namespace {

// rho_q(i, c) = sum_k weight cos(q phi_k) rho_hat(i, k, c) for one view; rho_q (Q+1, channels, I). The first
// step of [RH02] appendix C, its factor 2 pi left to the fit over theta_o.
void azimuthal_step(const TransferTable& t, int v, int Q, double* rho_q, double* energy) {
    const std::size_t I = size(t.I), K = size(t.K), channels = size(t.channels);
    std::vector<double> cosine(K), previous(K), twice(K), values(K), squares(channels, 0.);
    for (std::size_t i = 0; i < I; ++i) {
        const std::size_t node = size(v) * I + i, first = node * K;
        const double* phi = &t.phi[first];
        for (std::size_t k = 0; k < K; ++k) twice[k] = 2 * std::cos(phi[k]);
        for (std::size_t c = 0; c < channels; ++c) {
            double square = 0;
            for (std::size_t k = 0; k < K; ++k) {
                const double value = t.rho_hat[(first + k) * channels + c];
                values[k] = t.weight_phi[first + k] * value;
                square += values[k] * value;
            }
            squares[c] += t.weight_theta[node] * square;
            for (std::size_t k = 0; k < K; ++k)
                cosine[k] = 1, previous[k] = twice[k] / 2;  // cos 0, cos(-phi)
            for (int q = 0; q <= Q; ++q) {
                double sum = 0;
                for (std::size_t k = 0; k < K; ++k) sum += values[k] * cosine[k];
                rho_q[(size(q) * channels + c) * I + i] = sum;
                for (std::size_t k = 0; k < K; ++k) {
                    const double next = twice[k] * cosine[k] - previous[k];
                    previous[k] = cosine[k];
                    cosine[k] = next;
                }
            }
        }
    }
    for (std::size_t c = 0; c < channels; ++c) energy[c * size(t.views) + size(v)] = squares[c];
}

// g_lq(v) = sum_i weight f_lq(theta_i) rho_q(i) for one view and one q: the third step of [RH02] appendix C,
// taken before the second: the integrals commute.
void polar_step(const TransferTable& t, int v, int q, int L, int Q, const LegendreRecurrence& recurrence,
                const double* rho_q, double* g) {
    const std::size_t I = size(t.I);
    std::vector<double> x(I), f(I), previous(I, 0.);
    for (std::size_t i = 0; i < I; ++i) {
        const double theta = t.theta_i[size(v) * I + i];
        x[i] = std::cos(theta);
        f[i] = t.weight_theta[size(v) * I + i] * recurrence.start(q) * power(std::sin(theta), q);
    }
    for (int l = q; l <= L; ++l) {
        for (int c = 0; c < t.channels; ++c) {
            const double* rho = rho_q + (size(q) * size(t.channels) + size(c)) * I;
            double partial[8] = {};  // a fixed order of summation that a vector unit can follow
            std::size_t i = 0;
            for (; i + 8 <= I; i += 8)
                for (std::size_t u = 0; u < 8; ++u) partial[u] += f[i + u] * rho[i + u];
            for (; i < I; ++i) partial[0] += f[i] * rho[i];
            double sum = 0;
            for (double part : partial) sum += part;
            g[((size(c) * size(Q + 1) + size(q)) * size(L + 1) + size(l)) * size(t.views) + size(v)] = sum;
        }
        const auto [a, b] = recurrence.steps(q)[l - q];
        for (std::size_t i = 0; i < I; ++i) {
            const double next = a * x[i] * f[i] - b * previous[i];
            previous[i] = f[i];
            f[i] = next;
        }
    }
}

}  // namespace

void legendre(int F, int m, std::span<const double> theta, std::span<double> values) {
    const LegendreRecurrence recurrence(std::max(F, m));
    const std::size_t n = theta.size();
    std::fill(values.begin(), values.end(), 0.);
    for (std::size_t i = 0; i < n; ++i) {
        const double x = std::cos(theta[i]);
        double f = recurrence.start(m) * power(std::sin(theta[i]), m), previous = 0;
        for (int l = m; l <= F; ++l) {
            values[size(l) * n + i] = f;
            const auto [a, b] = recurrence.steps(m)[l - m];
            const double next = a * x * f - b * previous;
            previous = f;
            f = next;
        }
    }
}

void project(const TransferTable& table, int L, int Q, std::span<double> g, std::span<double> energy) {
    const LegendreRecurrence recurrence(std::max(L, Q));
    std::fill(g.begin(), g.end(), 0.);
#pragma omp parallel
    {
        std::vector<double> rho_q(size(Q + 1) * size(table.channels) * size(table.I));
#pragma omp for schedule(dynamic)
        for (int v = 0; v < table.views; ++v) {
            azimuthal_step(table, v, Q, rho_q.data(), energy.data());
            for (int q = 0; q <= std::min(Q, L); ++q)
                polar_step(table, v, q, L, Q, recurrence, rho_q.data(), g.data());
        }
    }
}

}  // namespace shrm
