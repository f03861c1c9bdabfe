#include "shrm/brdf/brdf_analysis.hpp"

#include <algorithm>
#include <cmath>

#include "shrm/core.hpp"
#include "shrm/sh/legendre.hpp"
#include "shrm/simd/trigonometry.hpp"

namespace shrm {
namespace {

constexpr int at_once = 8;  // colatitudes

double sum_of_lanes(d8 v) {
    return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

// The memory that the projection of one view takes, a colatitude to a lane; the last lanes are zero.
struct Workspace {
    Workspace(const TransferTable& t, int L, int Q)
        : groups(round_up(t.I, unrolled * at_once) / at_once),
          K(round_up(t.K, unrolled)),
          rho_q(size(Q + 1) * size(groups) * size(t.channels)),
          rho_hat(size(K) * size(t.channels)),
          cosine(size(K)),
          x(size(groups)),
          sine(size(groups)),
          weight(size(groups)),
          sums(size(std::max(L, Q) + 1) * size(t.channels)) {}

    static constexpr int unrolled = 4;  // independent recurrences, for the latency of a product

    int groups, K;
    std::vector<d8> rho_q;            // (Q+1, groups, channels)
    std::vector<d8> rho_hat, cosine;  // (K, channels) and (K), of one group; rho_hat times weight_share
    std::vector<d8> x, sine, weight;  // cos and sin(theta_i); weight sin(theta_i)^q
    std::vector<d8> sums;             // (Q+1 or L+1, channels)
};

// One group of colatitudes of one view into the workspace; adds its part of the energy per channel.
void gather(const TransferTable& t, int v, int group, Workspace& w, double* energy) {
    const int first = group * at_once;
    const std::size_t channels = size(t.channels), I = size(t.I);
    const d8 arc = load_first(&t.arc[size(v) * I] + first, t.I - first);
    const d8 ring = load_first(&t.weight_theta[size(v) * I] + first, t.I - first) * (2 * arc);
    for (std::size_t c = 0; c < channels; ++c) {
        d8 sum{};
        for (int k = 0; k < t.K; ++k) {
            const double* row = &t.rho_hat[(size(v) * size(t.K) + size(k)) * I * channels];
            d8 value{};
            if (channels == 1)
                value = load_first(row + first, t.I - first);
            else
                for (int i = 0; i < at_once && first + i < t.I; ++i)
                    value[i] = row[size(first + i) * channels + c];
            w.rho_hat[size(k) * channels + c] = t.weight_share[size(k)] * value;
            sum += w.rho_hat[size(k) * channels + c] * value;
        }
        energy[c] += sum_of_lanes(ring * sum);
    }
    for (int k = 0; k < t.K; ++k) {
        d8 sine;
        cosine_and_sine(t.share[size(k)] * arc, w.cosine[size(k)], sine);
    }
}

// rho_q(i, c) = 2 arc sum_k weight cos(q phi_k) rho_hat(k, i, c) for one view. The first step of [RH02]
// appendix C, its factor 2 pi left to the fit over theta_o.
void azimuthal_step(const TransferTable& t, int v, int Q, Workspace& w, double* energy) {
    constexpr int unrolled = Workspace::unrolled;
    const std::size_t channels = size(t.channels);
    for (int group = 0; group < w.groups; ++group) {
        gather(t, v, group, w, energy);
        std::fill_n(w.sums.begin(), size(Q + 1) * channels, d8{});
        for (int k = 0; k < w.K; k += unrolled) {
            const d8* rho_hat = &w.rho_hat[size(k) * channels];
            d8 cosine[unrolled], previous[unrolled], twice[unrolled];
            for (int u = 0; u < unrolled; ++u) {
                previous[u] = w.cosine[size(k + u)];  // cos(-phi)
                twice[u] = 2 * previous[u];
                cosine[u] = 1 + d8{};
            }
            d8* sum = w.sums.data();
            for (int q = 0; q <= Q; ++q) {
                for (std::size_t c = 0; c < channels; ++c, ++sum)
                    for (int u = 0; u < unrolled; ++u) *sum += rho_hat[size(u) * channels + c] * cosine[u];
                for (int u = 0; u < unrolled; ++u) {
                    const d8 next = twice[u] * cosine[u] - previous[u];
                    previous[u] = cosine[u];
                    cosine[u] = next;
                }
            }
        }
        const int first = group * at_once;
        const d8 arc = load_first(&t.arc[size(v) * size(t.I)] + first, t.I - first);
        for (int q = 0; q <= Q; ++q)
            for (std::size_t c = 0; c < channels; ++c)
                w.rho_q[(size(q) * size(w.groups) + size(group)) * channels + c] =
                    2 * arc * w.sums[size(q) * channels + c];
    }
}

// g_lq(v) = sum_i weight f_lq(theta_i) rho_q(i) for one view and one q: the third step of [RH02] appendix C,
// taken before the second: the integrals commute. Takes weight sin^q and leaves weight sin^(q+1).
void polar_step(const TransferTable& t, int v, int q, int L, int Q, const LegendreRecurrence& recurrence,
                Workspace& w, double* g) {
    constexpr int unrolled = Workspace::unrolled;
    const std::size_t channels = size(t.channels);
    const auto* steps = recurrence.steps(q);
    std::fill_n(w.sums.begin(), size(L + 1) * channels, d8{});
    for (int group = 0; group < w.groups; group += unrolled) {
        const d8* rho = &w.rho_q[(size(q) * size(w.groups) + size(group)) * channels];
        d8 x[unrolled], f[unrolled], previous[unrolled];
        for (int u = 0; u < unrolled; ++u) {
            x[u] = w.x[size(group + u)];
            f[u] = recurrence.start(q) * w.weight[size(group + u)];
            previous[u] = d8{};
        }
        d8* sum = &w.sums[size(q) * channels];
        for (int l = q; l <= L; ++l) {
            for (std::size_t c = 0; c < channels; ++c, ++sum)
                for (int u = 0; u < unrolled; ++u) *sum += f[u] * rho[size(u) * channels + c];
            const auto [a, b] = steps[l - q];
            for (int u = 0; u < unrolled; ++u) {
                const d8 next = a * x[u] * f[u] - b * previous[u];
                previous[u] = f[u];
                f[u] = next;
            }
        }
    }
    for (int group = 0; group < w.groups; ++group) w.weight[size(group)] *= w.sine[size(group)];
    for (std::size_t c = 0; c < channels; ++c)
        for (int l = q; l <= L; ++l)
            g[((c * size(Q + 1) + size(q)) * size(L + 1) + size(l)) * size(t.views) + size(v)] =
                sum_of_lanes(w.sums[size(l) * channels + c]);
}

void project_view(const TransferTable& t, int v, int L, int Q, const LegendreRecurrence& recurrence,
                  Workspace& w, double* g, double* energy) {
    std::vector<double> of_channels(size(t.channels));
    azimuthal_step(t, v, Q, w, of_channels.data());
    for (int c = 0; c < t.channels; ++c) energy[c * t.views + v] = of_channels[size(c)];
    const std::size_t row = size(v) * size(t.I);
    for (int group = 0; group < w.groups; ++group) {
        const std::size_t at = size(group);
        const int first = group * at_once;
        cosine_and_sine(load_first(&t.theta_i[row] + first, t.I - first), w.x[at], w.sine[at]);
        w.weight[at] = load_first(&t.weight_theta[row] + first, t.I - first);
    }
    for (int q = 0; q <= std::min(Q, L); ++q) polar_step(t, v, q, L, Q, recurrence, w, g);
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

void directions(const LightNodes& nodes, std::span<const double> theta_v, std::span<const double> gamma,
                std::span<double> wi, std::span<double> wo) {
    const int K = static_cast<int>(nodes.share.size()), I = nodes.I;
    const std::size_t views = theta_v.size(), n = views * size(K) * size(I);
    for (std::size_t v = 0; v < views; ++v) {
        const double c = std::cos(gamma[v]), s = std::sin(gamma[v]);
        const double *theta = &nodes.theta_i[v * size(I)], *arc = &nodes.arc[v * size(I)];
        for (int first = 0; first < I; first += at_once) {
            const int count = I - first;
            const d8 arcs = load_first(arc + first, count);
            d8 z, rho;  // L = (rho cos(phi), rho sin(phi), z) in the frame of C
            cosine_and_sine(load_first(theta + first, count), z, rho);
            for (int k = 0; k < K; ++k) {
                d8 x, y;
                cosine_and_sine(nodes.share[size(k)] * arcs, x, y);
                double* to = &wi[(v * size(K) + size(k)) * size(I)] + first;
                store_first(to, c * (rho * x) - s * z, count);
                store_first(to + n, rho * y, count);
                store_first(to + 2 * n, s * (rho * x) + c * z, count);
            }
        }
        const std::size_t of_view = size(K) * size(I);
        std::fill_n(&wo[v * of_view], of_view, std::sin(theta_v[v]));
        std::fill_n(&wo[n + v * of_view], of_view, 0.);
        std::fill_n(&wo[2 * n + v * of_view], of_view, std::cos(theta_v[v]));
    }
}

void project(const TransferTable& table, int L, int Q, std::span<double> g, std::span<double> energy) {
    const LegendreRecurrence recurrence(std::max(L, Q));
    std::fill(g.begin(), g.end(), 0.);
#pragma omp parallel
    {
        Workspace workspace(table, L, Q);
#pragma omp for schedule(dynamic)
        for (int v = 0; v < table.views; ++v)
            project_view(table, v, L, Q, recurrence, workspace, g.data(), energy.data());
    }
}

}  // namespace shrm
