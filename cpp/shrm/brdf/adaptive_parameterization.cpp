#include "shrm/brdf/adaptive_parameterization.hpp"

#include <cmath>

#include "shrm/brdf/direction_lanes.hpp"
#include "shrm/core.hpp"
#include "shrm/simd/trigonometry.hpp"

namespace shrm {
namespace {

double mix(double a, double b, double t) {
    return a + t * (b - a);
}

// A place on an axis of n nodes on [0, 1].
struct Place {
    int cell;
    double t;
    Place(double u, int n) {
        const double position = std::clamp(u, 0., 1.) * (n - 1);
        cell = std::min(static_cast<int>(position), n - 2);
        t = position - cell;
    }
};

// Columns are `step` apart in memory, rows `stride`.
double bilinear(const float* from, int step, std::size_t stride, double tx, double ty) {
    return mix(mix(from[0], from[step], tx), mix(from[stride], from[stride + size(step)], tx), ty);
}

}  // namespace

struct AdaptiveParameterization::Sample {
    int slice, next;
    double t, x, y;
};

struct AdaptiveParameterization::Eight {
    d8 theta_i, u, v;
    Eight(const DirectionPairs& pairs, std::size_t first) {
        const d8vec3 i = load(pairs.wo, pairs.count, first), o = load(pairs.wi, pairs.count, first);
        const d8vec3 h{i.x + o.x, i.y + o.y, i.z + o.z};
        const d8 theta_m = arc_tangent(length(h.x, h.y), h.z);
        const d8 phi = arc_tangent(i.x * h.y - i.y * h.x, i.x * h.x + i.y * h.y);  // phi_m - phi_i
        theta_i = arc_tangent(length(i.x, i.y), i.z);
        u = square_root(theta_m * (2 / pi));
        v = (phi + pi) * (0.5 / pi);
    }
};

AdaptiveParameterization::AdaptiveParameterization(std::span<const double> theta_i,
                                                   std::span<const float> vndf, Square vndf_square,
                                                   std::span<const float> values, Square values_square,
                                                   std::span<const float> ndf, Square ndf_square,
                                                   std::span<const float> sigma)
    : theta_i_(theta_i.begin(), theta_i.end()),
      vndf_(vndf.size()),
      marginal_(theta_i.size() * size(vndf_square.rows)),
      values_(values.begin(), values.end()),
      ndf_(ndf.begin(), ndf.end()),
      sigma_(sigma.begin(), sigma.end()),
      vndf_square_(vndf_square),
      values_square_(values_square),
      ndf_square_(ndf_square) {
    // Integrals of each slice's density by the trapezoidal rule: along rows, then over them; scaled to 1.
    const std::size_t rows = size(vndf_square.rows), columns = size(vndf_square.columns);
    std::vector<double> cumulative(rows * columns), marginal(rows);
    for (std::size_t slice = 0; slice < theta_i.size(); ++slice) {
        const float* density = &vndf[slice * rows * columns];
        for (std::size_t row = 0; row < rows; ++row) {
            const float* of_row = density + row * columns;
            double* sum = &cumulative[row * columns];
            sum[0] = 0;
            for (std::size_t k = 1; k < columns; ++k)
                sum[k] = sum[k - 1] + 0.5 * (double(of_row[k - 1]) + double(of_row[k]));
        }
        const auto total = [&](std::size_t row) { return cumulative[(row + 1) * columns - 1]; };
        marginal[0] = 0;
        for (std::size_t row = 1; row < rows; ++row)
            marginal[row] = marginal[row - 1] + 0.5 * (total(row - 1) + total(row));
        const double scale = 1 / marginal.back();
        for (std::size_t row = 0; row < rows; ++row)
            marginal_[slice * rows + row] = static_cast<float>(scale * marginal[row]);
        for (std::size_t k = 0; k < rows * columns; ++k)
            vndf_[slice * rows * columns + k] = {static_cast<float>(scale * density[k]),
                                                 static_cast<float>(scale * cumulative[k])};
    }
}

AdaptiveParameterization::Sample AdaptiveParameterization::sample(double theta_i, double u, double v) const {
    // Between which two slices.
    Sample s;
    const int slices = static_cast<int>(theta_i_.size());
    s.slice = 0;
    while (s.slice < slices - 2 && theta_i_[size(s.slice + 1)] <= theta_i) ++s.slice;
    s.next = std::min(s.slice + 1, slices - 1);
    const double start = theta_i_[size(s.slice)], step = theta_i_[size(s.next)] - start;
    s.t = step > 0 ? std::clamp((theta_i - start) / step, 0., 1.) : 0;

    // Values of the density's table at (u, v), mixed between rows and slices.
    const std::size_t rows = size(vndf_square_.rows), columns = size(vndf_square_.columns);
    const Place at_u(u, vndf_square_.columns), at_v(v, vndf_square_.rows);
    const std::size_t row = size(at_v.cell), column = size(at_u.cell);
    const std::size_t first = (size(s.slice) * rows + row) * columns;
    const std::size_t second = (size(s.next) * rows + row) * columns;
    const auto at_row = [&](float Node::*what, std::size_t k) {  // at v, between the rows and the slices
        const auto of_slice = [&](std::size_t from) {
            return mix(vndf_[from + k].*what, vndf_[from + columns + k].*what, at_v.t);
        };
        return mix(of_slice(first), of_slice(second), s.t);
    };
    const auto row_total = [&](std::size_t k) {
        const std::size_t last = (k + 1) * columns - 1;
        return mix(vndf_[first + last].cumulative, vndf_[second + last].cumulative, s.t);
    };
    // The cumulative distributions there: along the row for x, over the rows for y.
    const double left = at_row(&Node::density, column), right = at_row(&Node::density, column + 1);
    const double total0 = row_total(0), total1 = row_total(1), total = mix(total0, total1, at_v.t);
    const double up_to = at_row(&Node::cumulative, column) + at_u.t * mix(left, right, 0.5 * at_u.t);
    s.x = total > 0 ? up_to / total : u;  // no facet is visible in this row
    s.y = mix(marginal_[size(s.slice) * rows + row], marginal_[size(s.next) * rows + row], s.t) +
          at_v.t * mix(total0, total1, 0.5 * at_v.t);
    return s;
}

template <class Body>
SHRM_KERNEL void AdaptiveParameterization::each(const DirectionPairs& pairs, const Body& body) const {
    each_eight(pairs.count, [&](std::size_t first, std::size_t count) {
        const Eight eight(pairs, first);
        for (std::size_t k = 0; k < count; ++k) {
            const int lane = static_cast<int>(k);
            const double theta_i = eight.theta_i[lane], u = eight.u[lane], v = eight.v[lane];
            body(first + k, theta_i, u, v, sample(theta_i, u, v));
        }
    });
}

void AdaptiveParameterization::evaluate(const DirectionPairs& pairs, std::span<double> values) const {
    const std::size_t stride = size(values_square_.columns) * 3, slice = stride * size(values_square_.rows);
    each(pairs, [&](std::size_t n, double theta_i, double u, double v, const Sample& s) {
        double scale = 1;
        if (!ndf_.empty()) {
            const Place at_u(u, ndf_square_.columns), at_v(v, ndf_square_.rows);
            const std::size_t columns = size(ndf_square_.columns);
            const double ndf =
                bilinear(&ndf_[size(at_v.cell) * columns + size(at_u.cell)], 1, columns, at_u.t, at_v.t);
            const Place at_i(std::sqrt(theta_i * (2 / pi)), static_cast<int>(sigma_.size()));
            const float* sigma = &sigma_[size(at_i.cell)];
            scale = ndf / (4 * mix(sigma[0], sigma[1], at_i.t));
        }
        const Place at_x(s.x, values_square_.columns), at_y(s.y, values_square_.rows);
        const std::size_t cell = size(at_y.cell) * stride + size(at_x.cell) * 3;
        const float *a = &values_[size(s.slice) * slice + cell], *b = &values_[size(s.next) * slice + cell];
        for (int c = 0; c < 3; ++c)
            values[3 * n + size(c)] = scale * std::max(mix(bilinear(a + c, 3, stride, at_x.t, at_y.t),
                                                           bilinear(b + c, 3, stride, at_x.t, at_y.t), s.t),
                                                       0.);
    });
}

void AdaptiveParameterization::samples(const DirectionPairs& pairs, std::span<double> samples) const {
    each(pairs, [&](std::size_t n, double, double, double, const Sample& s) {
        samples[3 * n] = s.slice + s.t;
        samples[3 * n + 1] = s.y;
        samples[3 * n + 2] = s.x;
    });
}

}  // namespace shrm
