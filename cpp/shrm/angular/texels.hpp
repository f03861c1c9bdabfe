// The nodes of a picture's texels, and which texels an integral visits: rings and arcs about a
// center, so that nothing outside a lobe's width is even tested. Private to angular.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "shrm/angular/angular.hpp"
#include "shrm/angular/sums.hpp"
#include "shrm/quadrature.hpp"

namespace shrm::angular {

// ---- The nodes of a picture

// Directions of all nodes: k nodes to each row of texels and k to each column.
struct Nodes {
    int H, W, k;
    std::vector<double> cos_theta, sin_theta;  // [H * k]
    std::vector<double> cos_phi, sin_phi;      // [k][row_length(W)]
    std::vector<double> row_share;             // [H * k], of a texel's solid angle; sums to 1 over its k
    std::vector<double> column_share;          // [k], sums to 1

    explicit Nodes(const Picture& picture) : H(picture.H), W(picture.W), k(picture.subsamples) {
        std::vector<double> x;
        gauss_legendre(k, x, column_share);
        for (double& share : column_share) share /= 2;
        const std::size_t kk = size(k), length = size(row_length(W));
        cos_theta.resize(kk * size(H));
        sin_theta = row_share = cos_theta;
        for (int i = 0; i < H; ++i) {
            double sum = 0;
            for (std::size_t a = 0; a < kk; ++a) {
                const double theta = pi / H * (i + 0.5 * (1 + x[a]));
                const std::size_t node = size(i) * kk + a;
                cos_theta[node] = std::cos(theta);
                sin_theta[node] = std::sin(theta);
                row_share[node] = column_share[a] * sin_theta[node];
                sum += row_share[node];
            }
            for (std::size_t a = 0; a < kk; ++a) row_share[size(i) * kk + a] /= sum;
        }
        cos_phi.resize(kk * length);
        sin_phi.resize(kk * length);
        for (std::size_t b = 0; b < kk; ++b)
            for (std::size_t j = 0; j < length; ++j) {
                const std::size_t column = b * length + j;
                const double phi = pi - 2 * pi / W * (static_cast<double>(j) + 0.5 * (1 + x[b]));
                cos_phi[column] = j < size(W) ? std::cos(phi) : cos_phi[column - size(W)];
                sin_phi[column] = j < size(W) ? std::sin(phi) : sin_phi[column - size(W)];
            }
    }
};

// a cos(phi) + b sin(phi) + c of all columns of nodes, [k][row_length(W)].
inline void along_columns(const Nodes& nodes, double a, double b, double c, std::vector<float>& out) {
    out.resize(nodes.cos_phi.size());
    const std::size_t length = size(row_length(nodes.W)), period = size(nodes.W);
    for (std::size_t row = 0; row < out.size(); row += length) {
        for (std::size_t j = row; j < row + period; ++j)
            out[j] = static_cast<float>(a * nodes.cos_phi[j] + b * nodes.sin_phi[j] + c);
        for (std::size_t j = row + period; j < row + length; ++j) out[j] = out[j - period];
    }
}

// ---- Which texels to visit: rings and arcs, never a test per texel

struct Arc {
    int begin, end;  // columns, 0 <= begin < W, end - begin <= W
};

struct Arcs {
    Arc arc[2];
    int count = 0;
};

// A center (theta_C, phi_C). The haversine form sin^2(d/2) = ring(theta) + span(theta)
// sin^2((phi - phi_C)/2) of the distance d keeps its accuracy for small d in single precision.
struct Center {
    double cos_theta, sin_theta, phi;

    explicit Center(const glm::dvec3& c) : phi(std::atan2(c.y, c.x)) {
        const double across = std::hypot(c.x, c.y), length = std::hypot(across, c.z);
        cos_theta = c.z / length;
        sin_theta = across / length;
    }
    double ring(const Nodes& nodes, std::size_t row) const {
        return std::max(0.0, 0.5 * (1 - nodes.cos_theta[row] * cos_theta - nodes.sin_theta[row] * sin_theta));
    }
    double span(const Nodes& nodes, std::size_t row) const { return sin_theta * nodes.sin_theta[row]; }
};

// asin(sqrt(v)) to 1e-11 for v in [0, 1], without a branch, so that a loop over it is in lanes.
inline double asin_sqrt(double v) {
    // Chebyshev's interpolant of asin(sqrt(x)) / sqrt(x) on [0, 1/2], where that is smooth.
    constexpr double a[] = {0.99999999999373,      0.16666667019626058,  0.07499967234020394,
                            0.044654713815160126,  0.030161635086481904, 0.024767921566285628,
                            0.0010204557728229688, 0.08608627534995324,  -0.19570322231156756,
                            0.38705344982445244,   -0.3930207148194313,  0.20553722381591796};
    const double x = std::min(v, 1 - v);
    double series = 0;
    for (int n = 11; n >= 0; --n) series = series * x + a[n];
    const double angle = std::sqrt(x) * series;
    return v < 0.5 ? angle : pi / 2 - angle;
}

// Half the arc of azimuth within the angle `within` of the center, for rows of nodes; -1 if none.
inline void half_arcs(const Nodes& nodes, const Center& center, double within, std::size_t first,
                      std::size_t last, std::vector<double>& half) {
    half.resize(nodes.cos_theta.size());
    double* __restrict out = half.data();
    if (within >= pi) {
        std::fill(out + first, out + last, pi);
        return;
    }
    const double s = std::sin(0.5 * within), s2 = s * s;
    for (std::size_t row = first; row < last; ++row) {
        const double span = center.span(nodes, row), rest = s2 - center.ring(nodes, row);
        const double part = rest / (span > 1e-300 ? span : 1e-300);
        const double inside = 2 * asin_sqrt(part < 1 ? (part > 0 ? part : 0) : 1);
        out[row] = rest < 0 ? -1 : inside;
    }
}

// The columns of each row of texels inside a band. With several nodes to a texel, texels that the band
// touches are taken whole, so that what is left out is never more than was asked for.
class Reach {
    std::vector<double> outer_, inner_;  // half arcs of rows of nodes [H * k], then of texels
    std::vector<int> begin_, end_, hole_begin_, hole_end_;  // columns [H], not yet turned into [0, W)

    // The widest or narrowest of a texel's rows of nodes.
    template <class Choose>
    void of_texels(const Nodes& nodes, std::vector<double>& half, const Choose& choose) const {
        const std::size_t k = size(nodes.k);
        for (std::size_t i = size(first); i < size(last) && k > 1; ++i) {
            double chosen = half[i * k];
            for (std::size_t a = 1; a < k; ++a) chosen = choose(chosen, half[i * k + a]);
            half[i] = chosen;
        }
    }

  public:
    int first = 0, last = 0;  // rows that there is anything in, and maybe their neighbors

    void find(const Nodes& nodes, const Center& about, const Band& band) {
        const double per_radian = nodes.W / (2 * pi), touch = nodes.k > 1 ? 0.5 : 1e-9;
        const double center = (pi - about.phi) * per_radian - 0.5, half_turn = 0.5 * nodes.W;
        const double theta = std::atan2(about.sin_theta, about.cos_theta), rows_per_radian = nodes.H / pi;
        first = std::max(0, static_cast<int>(std::floor((theta - band.outer) * rows_per_radian)));
        last = std::min(nodes.H, static_cast<int>(std::ceil((theta + band.outer) * rows_per_radian)));
        // Arcs within the outer angle, as columns.
        const std::size_t from = size(first), to = size(last), k = size(nodes.k);
        half_arcs(nodes, about, band.outer, from * k, to * k, outer_);
        of_texels(nodes, outer_, [](double a, double b) { return std::max(a, b); });
        begin_.resize(size(nodes.H));
        end_.resize(size(nodes.H));
        const int whole = static_cast<int>(std::ceil(center - half_turn)), W = nodes.W;
        const double* __restrict outer = outer_.data();
        int* __restrict begins = begin_.data();
        int* __restrict ends = end_.data();
        for (std::size_t i = from; i < to; ++i) {
            const double half = outer[i] * per_radian + touch;
            const int begin = static_cast<int>(std::ceil(center - half));
            const int end = static_cast<int>(std::floor(center + half)) + 1;
            const bool all = end - begin >= W;
            begins[i] = all ? whole : begin;
            ends[i] = all ? whole + W : outer[i] < 0 ? begin : end;
        }
        // The part of the rows within the inner angle is left out.
        hole_begin_.resize(size(nodes.H));
        hole_end_.resize(size(nodes.H));
        for (std::size_t i = from; i < to; ++i) hole_begin_[i] = hole_end_[i] = end_[i];
        if (band.inner <= 0) return;
        half_arcs(nodes, about, band.inner, from * k, to * k, inner_);
        of_texels(nodes, inner_, [](double a, double b) { return std::min(a, b); });
        for (std::size_t i = from; i < to; ++i) {
            const double half = inner_[i] * per_radian - touch;
            const int begin = std::max(begin_[i], static_cast<int>(std::floor(center - half)) + 1);
            const int end = std::min(end_[i], static_cast<int>(std::ceil(center + half)));
            if (inner_[i] <= 0 || end <= begin) continue;
            hole_begin_[i] = begin;
            hole_end_[i] = end;
        }
    }

    SHRM_INLINE Arcs columns(const Nodes& nodes, int i) const {
        Arcs arcs;
        const auto add = [&](int from, int to) {
            if (from >= to) return;
            const int turn = from < 0 ? -nodes.W : from >= nodes.W ? nodes.W : 0;
            arcs.arc[arcs.count++] = {from - turn, to - turn};
        };
        add(begin_[size(i)], hole_begin_[size(i)]);
        add(hole_end_[size(i)], end_[size(i)]);
        return arcs;
    }
};

}  // namespace shrm::angular
