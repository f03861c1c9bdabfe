// The nodes of a picture's texels, and which texels an integral visits: rings and arcs about a
// centre, so that nothing outside a lobe's width is even tested. Private to angular.cpp.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "angular.hpp"
#include "quadrature.hpp"

namespace shrm::angular {

// ---- The nodes of a picture

// Directions of all nodes: k nodes to each row of texels and k to each column.
struct Nodes {
    int H, W, k;
    std::vector<double> cos_theta, sin_theta;  // [H * k]
    std::vector<double> solid_angle;           // [H * k], of one texel's share in this row of nodes
    std::vector<double> cos_phi, sin_phi;      // [k][row_length(W)]
    std::vector<double> column_weight;         // [k], sums to 1

    explicit Nodes(const Picture& picture) : H(picture.H), W(picture.W), k(picture.subsamples) {
        std::vector<double> x;
        gauss_legendre(k, x, column_weight);
        for (double& weight : column_weight) weight /= 2;
        const std::size_t kk = size(k), length = size(row_length(W));
        cos_theta.resize(kk * size(H));
        sin_theta = solid_angle = cos_theta;
        for (int i = 0; i < H; ++i) {
            // cos(i pi/H) - cos((i+1) pi/H) without cancellation.
            const double texel = 2 * pi / W * 2 * std::sin(pi * (i + 0.5) / H) * std::sin(0.5 * pi / H);
            double sum = 0;
            for (std::size_t a = 0; a < kk; ++a) {
                const double theta = pi / H * (i + 0.5 * (1 + x[a]));
                const std::size_t node = size(i) * kk + a;
                cos_theta[node] = std::cos(theta);
                sin_theta[node] = std::sin(theta);
                solid_angle[node] = column_weight[a] * sin_theta[node];
                sum += solid_angle[node];
            }
            for (std::size_t a = 0; a < kk; ++a) solid_angle[size(i) * kk + a] *= texel / sum;
        }
        cos_phi.resize(kk * length);
        sin_phi.resize(kk * length);
        for (std::size_t b = 0; b < kk; ++b)
            for (std::size_t j = 0; j < length; ++j) {
                const double phi = pi - 2 * pi / W * (static_cast<double>(j) + 0.5 * (1 + x[b]));
                cos_phi[b * length + j] = std::cos(phi);
                sin_phi[b * length + j] = std::sin(phi);
            }
    }
};

// ---- Which texels to visit: rings and arcs, never a test per texel

struct Arc {
    int begin, end;  // columns, 0 <= begin < W, end - begin <= W
};

struct Arcs {
    Arc arc[2];
    int count = 0;
};

// A centre (theta_C, phi_C). The haversine form sin^2(d/2) = ring(theta) + span(theta)
// sin^2((phi - phi_C)/2) of the distance d keeps its accuracy for small d in single precision.
struct Centre {
    double theta, sin_theta, phi;

    explicit Centre(const glm::dvec3& c)
        : theta(std::atan2(std::hypot(c.x, c.y), c.z)),
          sin_theta(std::hypot(c.x, c.y)),
          phi(std::atan2(c.y, c.x)) {}
    double ring(const Nodes& nodes, std::size_t row) const {
        const double s = std::sin(0.5 * (std::atan2(nodes.sin_theta[row], nodes.cos_theta[row]) - theta));
        return s * s;
    }
    double span(const Nodes& nodes, std::size_t row) const { return sin_theta * nodes.sin_theta[row]; }
};

// Half the arc of azimuth within the angle `within` of the centre on a ring; negative if none.
inline double half_arc(double ring, double span, double within) {
    if (within >= pi) return pi;
    const double s = std::sin(0.5 * within), rest = s * s - ring;
    if (rest < 0) return -1;
    return rest >= span ? pi : 2 * std::asin(std::sqrt(rest / span));
}

// The columns of texel row i inside a band. With several nodes to a texel, texels that the band
// touches are taken whole, so that what is left out is never more than was asked for.
inline Arcs columns(const Nodes& nodes, const Centre& centre, const Band& band, int i) {
    double outer = -1, inner = pi;
    for (int a = 0; a < nodes.k; ++a) {
        const std::size_t row = size(i * nodes.k + a);
        const double ring = centre.ring(nodes, row), span = centre.span(nodes, row);
        outer = std::max(outer, half_arc(ring, span, band.outer));
        inner = std::min(inner, band.inner > 0 ? half_arc(ring, span, band.inner) : -1);
    }
    Arcs arcs;
    if (outer < 0) return arcs;
    const double per_radian = nodes.W / (2 * pi), touch = nodes.k > 1 ? 0.5 : 1e-9;
    const double c = (pi - centre.phi) * per_radian - 0.5;
    int begin = static_cast<int>(std::ceil(c - outer * per_radian - touch));
    int end = static_cast<int>(std::floor(c + outer * per_radian + touch)) + 1;
    if (end - begin >= nodes.W) {
        begin = static_cast<int>(std::ceil(c - 0.5 * nodes.W));
        end = begin + nodes.W;
    }
    int hole_begin = end, hole_end = end;
    if (inner > 0) {
        hole_begin = std::max(begin, static_cast<int>(std::floor(c - inner * per_radian + touch)) + 1);
        hole_end = std::min(end, static_cast<int>(std::ceil(c + inner * per_radian - touch)));
        if (hole_end <= hole_begin) hole_begin = hole_end = end;
    }
    const auto add = [&](int from, int to) {
        if (from >= to) return;
        const int turn = static_cast<int>(std::floor(static_cast<double>(from) / nodes.W)) * nodes.W;
        arcs.arc[arcs.count++] = {from - turn, to - turn};
    };
    add(begin, hole_begin);
    add(hole_end, end);
    return arcs;
}

}  // namespace shrm::angular
