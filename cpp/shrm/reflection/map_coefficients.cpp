#include "shrm/reflection/map_coefficients.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "shrm/sh/wigner.hpp"

namespace shrm {

MapCoefficients::MapCoefficients(int F, int P, int channels, bool zonal)
    : F_(F), P_(P), channels_(channels), zonal_(zonal), light_(2 * basis_size(F) * size(channels)) {
    if (zonal) {
        shape_.resize(size(F + 1) * size(P + 1) * size(channels));
        return;
    }
    couple();
    shape_.resize(shapes_.size() * size(channels));
}

// Lists every term of every sum, then computes the couplings.
void MapCoefficients::couple() {
    // Which terms there are, and where their couplings and shapes will lie.
    maps_.resize(size(degree() + 1));
    std::size_t couplings = 0, factors = 0;
    for (int j = 0; j <= degree(); ++j)
        for (int p = std::max(0, j - F_); p <= P_; ++p) {
            const std::size_t first_shape = shapes_.size();
            // For odd l + p - j the terms of s and -s cancel:
            // <l -s p s | j 0> = (-1)^{l+p-j} <l s p -s | j 0>   [VMK88 8.4].
            for (int l = std::abs(j - p); l <= std::min(F_, j + p); l += 2) {
                shapes_.push_back({p, l, factors});
                factors += size(std::min(l, p)) + 1;
            }
            for (int q = 0; q <= p; ++q) {
                Map map{p, q, {}};
                std::size_t shape = first_shape;
                for (int l = std::abs(j - p); l <= std::min(F_, j + p); l += 2, ++shape) {
                    const int first = std::max(-j, -l - q), count = std::min(j, l - q) - first + 1;
                    if (count <= 0) continue;
                    map.terms.push_back({l, first, count, couplings, shape});
                    couplings += size(count);
                }
                maps_[size(j)].push_back(std::move(map));
            }
        }
    coupling_.resize(couplings);
    shape_factor_.assign(factors, 0);

    // Couplings, and the factors of shapes, in their places.
    const ClebschGordan clebsch_gordan(2 * degree() + 1);
#pragma omp parallel for schedule(dynamic)
    for (int j = 0; j <= degree(); ++j)
        for (const auto& [p, q, terms] : maps_[size(j)])
            for (const Term& t : terms) {
                for (int i = 0; i < t.count; ++i)
                    coupling_[t.coupling + size(i)] =
                        (q % 2 ? -1 : 1) * clebsch_gordan(t.l, t.first + i + q, p, -q, j);
                if (q > 0) continue;  // the shape is the same for all q
                double* factor = &shape_factor_[shapes_[t.shape].first];
                for (int s = -std::min(t.l, p); s <= std::min(t.l, p); ++s)
                    factor[std::abs(s)] +=
                        std::sqrt(4 * pi / (2 * j + 1)) * (s % 2 ? -1 : 1) * clebsch_gordan(t.l, s, p, -s, j);
            }
}

void MapCoefficients::set_material(std::span<const double> rho) {
    const auto at = [&](int l, int p, int q, int c) {
        return rho[((size(l) * size(P_ + 1) + size(p)) * size(P_ + 1) + size(q)) * size(channels_) + size(c)];
    };
    if (zonal_) {
        double* to = shape_.data();
        for (int l = 0; l <= F_; ++l)  // Lambda_l rho_lp0
            for (int p = 0; p <= P_; ++p)
                for (int c = 0; c < channels_; ++c) *to++ = std::sqrt(4 * pi / (2 * l + 1)) * at(l, p, 0, c);
        return;
    }
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
        const auto [p, l, first] = shapes_[i];
        for (int c = 0; c < channels_; ++c) {
            double sum = 0;
            for (int s = 0; s <= std::min(l, p); ++s) sum += shape_factor_[first + size(s)] * at(l, p, s, c);
            shape_[i * size(channels_) + size(c)] = sum;
        }
    }
}

// The coefficients of one degree j of all maps.
void MapCoefficients::sum_degree(int j, double* b, double* coefficients) const {
    const std::size_t width = size(2 * j + 1), maps = size(this->maps()), n = size(channels_);
    for (const auto& [p, q, terms] : maps_[size(j)]) {
        std::fill_n(b, 2 * n * width, 0.);
        for (const Term& t : terms) {
            // L_lm rho_lps of [RH02] eq. 5 at m = k + q, summed over s in the shape
            const double* w = &coupling_[t.coupling];
            const std::size_t light_width = size(2 * t.l + 1);
            const double* light = &light_[2 * n * size(t.l) * size(t.l)] + (t.first + q + t.l);
            for (std::size_t c = 0; c < n; ++c) {
                const double shape = shape_[t.shape * n + c];
                const double *re = light + 2 * c * light_width, *im = re + light_width;
                double *to_re = b + 2 * c * width + size(t.first + j), *to_im = to_re + width;
                for (int i = 0; i < t.count; ++i) to_re[i] += shape * w[i] * re[i];
                for (int i = 0; i < t.count; ++i) to_im[i] += shape * w[i] * im[i];
            }
        }
        // The maps sqrt2 Re B~_pq and -sqrt2 Im B~_pq are real functions: x_jk = (b_jk + (-1)^k conj b_j,-k)
        // / 2 and likewise for the imaginary part, then into the real basis.
        const double norm = q ? std::numbers::sqrt2 / 2 : 0.5;
        double* row = coefficients + size(j * j) * maps * n;
        for (int k = 0; k <= j; ++k)
            for (std::size_t c = 0; c < n; ++c) {
                const double *re = b + 2 * c * width + size(j), *im = re + width;
                const double sign = k % 2 ? -1 : 1, scale = norm * (k ? std::numbers::sqrt2 : 1);
                double *plus = row + size(j + k) * maps * n + c, *minus = row + size(j - k) * maps * n + c;
                const std::size_t of_re = lm(p, q) * n, of_im = lm(p, -q) * n;
                plus[of_re] = scale * (re[k] + sign * re[-k]);
                if (k) minus[of_re] = -scale * (im[k] - sign * im[-k]);
                if (q == 0) continue;
                plus[of_im] = -scale * (im[k] + sign * im[-k]);
                if (k) minus[of_im] = -scale * (re[k] - sign * re[-k]);
            }
    }
}

void MapCoefficients::run(std::span<const double> light, std::span<double> coefficients) {
    const std::size_t n = size(channels_);
    // In a series about C every coefficient is a product.
    if (zonal_) {
        const std::size_t width = size(P_ + 1) * n;
        for (int l = 0; l <= F_; ++l)
            for (int m = -l; m <= l; ++m)
                for (std::size_t z = 0; z < width; ++z)
                    coefficients[lm(l, m) * width + z] =
                        light[lm(l, m) * n + z % n] * shape_[size(l) * width + z];
        return;
    }
    if (b_.size() < size(omp_get_max_threads())) b_.resize(size(omp_get_max_threads()));
    // L_lm of the complex basis, for either sign of m
    for (int l = 0; l <= F_; ++l)
        for (int m = 0; m <= l; ++m)
            for (std::size_t c = 0; c < n; ++c) {
                const std::size_t width = size(2 * l + 1);
                double* re = &light_[2 * n * size(l) * size(l)] + 2 * c * width + size(l);
                double* im = re + width;
                const double scale = m ? 1 / std::numbers::sqrt2 : 1, sign = m % 2 ? -1 : 1;
                re[m] = scale * light[lm(l, m) * n + c];
                im[m] = m ? -scale * light[lm(l, -m) * n + c] : 0;
                re[-m] = sign * re[m];
                im[-m] = m ? -sign * im[m] : 0;
            }
            // One degree after the other, the longest first.
#pragma omp parallel
    {
        std::vector<double>& b = b_[size(omp_get_thread_num())];
        b.resize(2 * n * size(2 * degree() + 1));
#pragma omp for schedule(dynamic)
        for (int j = degree(); j >= 0; --j) {
            // Maps of small p have no degree j > F + p.
            std::fill_n(&coefficients[size(j * j) * size(maps()) * n], size(2 * j + 1) * size(maps()) * n,
                        0.);
            sum_degree(j, b.data(), coefficients.data());
        }
    }
}

}  // namespace shrm
