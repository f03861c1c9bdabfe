// Gauss-Legendre quadrature, which is exact for polynomials of degree 2n - 1.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "shrm/core.hpp"

namespace shrm {

// Nodes on (-1, 1), in rising order, and weights that sum to 2, by Newton's method on P_n.
inline void gauss_legendre(int n, std::vector<double>& nodes, std::vector<double>& weights) {
    nodes.resize(size(n));
    weights.resize(size(n));
    for (int k = 0; k < n; ++k) {
        double x = -std::cos(pi * (k + 0.75) / (n + 0.5)), slope = 1;
        for (int step = 0; step < 50; ++step) {
            double p = 1, before = 0;
            for (int l = 1; l <= n; ++l)
                before = std::exchange(p, ((2 * l - 1) * x * p - (l - 1) * before) / l);
            slope = n * (x * p - before) / (x * x - 1);
            const double dx = p / slope;
            x -= dx;
            if (std::abs(dx) < 1e-15) break;
        }
        nodes[size(k)] = x;
        weights[size(k)] = 2 / ((1 - x * x) * slope * slope);
    }
}

}  // namespace shrm
