#include "shrm/brdf/angle_table.hpp"

#include "shrm/brdf/direction_lanes.hpp"
#include "shrm/core.hpp"
#include "shrm/simd/trigonometry.hpp"

namespace shrm {
namespace {

void difference_angles(const d8vec3& wi, const d8vec3& wo, d8 (&angles)[3]) {
    angles[0] = arc_tangent(length(wi.x, wi.y), wi.z);
    angles[1] = arc_tangent(length(wo.x, wo.y), wo.z);
    const d8 across = wi.x * wo.y - wi.y * wo.x, along = wi.x * wo.x + wi.y * wo.y;
    angles[2] = arc_tangent(across < 0 ? -across : across, along);
}

void half_angles(const d8vec3& wi, const d8vec3& wo, d8 (&angles)[3]) {
    const d8vec3 h{wi.x + wo.x, wi.y + wo.y, wi.z + wo.z}, d{wi.x - wo.x, wi.y - wo.y, wi.z - wo.z};
    const d8 across = length(h.x, h.y), length_h = length(across, h.z), length_d = square_root(dot(d, d));
    angles[0] = arc_tangent(across, h.z);
    angles[1] = arc_tangent(length_d, length_h);  // |L - V| / |L + V| = tan(theta_d)
    // The azimuth of H; that of L where H is the normal, which makes phi_d 0 and keeps isotropy exact.
    const auto tilted = across > 1e-14;
    d8 x = tilted ? h.x : wi.x, y = tilted ? h.y : wi.y;
    const d8 horizontal = length(x, y), divisor = horizontal > 0 ? horizontal : 1 + d8{};
    x /= divisor;
    y /= divisor;
    const d8 scale = length_h > 0 ? length_h : 1 + d8{};
    const d8 cos_h = length_h > 0 ? h.z / scale : 1 + d8{}, sin_h = across / scale;
    d8 d_x = (wi.x * x + wi.y * y) * cos_h - wi.z * sin_h, d_y = wi.y * x - wi.x * y;
    const auto apart = length_d > 1e-14;  // where L is V, phi_d is 0 too, not what rounding makes of it
    d_x = apart ? d_x : d8{};
    d_y = apart ? d_y : d8{};
    angles[2] = arc_tangent(d_y < 0 ? -d_y : d_y, d_x);
}

// The places of eight pairs among the nodes of the three axes, clamped to [0, n - 1].
class Positions {
  public:
    explicit Positions(const AngleAxes& axes) : axes_(axes) {
        for (int axis = 0; axis < 3; ++axis) {
            const int n = axes.n[axis];
            scale_[axis] = axes.centers ? n : n - 1;
            shift_[axis] = axes.centers ? -0.5 : 0;
            last_[axis] = n - 1;
        }
    }

    void operator()(const DirectionPairs& pairs, std::size_t first, d8 (&positions)[3]) const {
        const d8vec3 wi = load(pairs.wi, pairs.count, first), wo = load(pairs.wo, pairs.count, first);
        if (axes_.angles == Angles::half)
            half_angles(wi, wo, positions);
        else
            difference_angles(wi, wo, positions);
        constexpr double ends[3] = {pi / 2, pi / 2, pi};
        for (int axis = 0; axis < 3; ++axis) {
            d8 part = positions[axis] * (1 / ends[axis]);
            if (axis == 0 && axes_.square_root) part = square_root(part);
            const d8 position = part * scale_[axis] + shift_[axis], zero{}, last = zero + last_[axis];
            positions[axis] = position > last ? last : position > 0 ? position : zero;
        }
    }

  private:
    AngleAxes axes_;
    double scale_[3], shift_[3], last_[3];
};

template <int channels, class T>
SHRM_KERNEL void interpolate_channels(const AngleAxes& axes, const T* table, const DirectionPairs& pairs,
                                      double* values) {
    const Positions positions(axes);
    const std::size_t stride[2] = {size(axes.n[1]) * size(axes.n[2]) * channels, size(axes.n[2]) * channels};
    each_eight(pairs.count, [&](std::size_t first, std::size_t count) {
        d8 at[3];
        positions(pairs, first, at);
        for (std::size_t lane = 0; lane < count; ++lane) {
            int cell[3];
            double t[3];
            for (int axis = 0; axis < 3; ++axis) {
                const double position = at[axis][static_cast<int>(lane)];
                cell[axis] = std::min(static_cast<int>(position), axes.n[axis] - 2);
                t[axis] = position - cell[axis];
            }
            const T* corner = table + size(cell[0]) * stride[0] + size(cell[1]) * stride[1] +
                              size(cell[2]) * size(channels);
            double* to = values + (first + lane) * channels;
            for (int c = 0; c < channels; ++c) {
                const auto along_phi = [&](const T* from) {
                    return (1 - t[2]) * double(from[c]) + t[2] * double(from[c + channels]);
                };
                const auto along_theta = [&](const T* from) {
                    return (1 - t[1]) * along_phi(from) + t[1] * along_phi(from + stride[1]);
                };
                to[c] = (1 - t[0]) * along_theta(corner) + t[0] * along_theta(corner + stride[0]);
            }
        }
    });
}

}  // namespace

template <class T>
void interpolate(const AngleAxes& axes, int channels, std::span<const T> table, const DirectionPairs& pairs,
                 std::span<double> values) {
    if (channels == 1)
        interpolate_channels<1>(axes, table.data(), pairs, values.data());
    else
        interpolate_channels<3>(axes, table.data(), pairs, values.data());
}

template void interpolate(const AngleAxes&, int, std::span<const float>, const DirectionPairs&,
                          std::span<double>);
template void interpolate(const AngleAxes&, int, std::span<const double>, const DirectionPairs&,
                          std::span<double>);

void nearest_nodes(const AngleAxes& axes, const DirectionPairs& pairs, std::span<std::int64_t> nodes) {
    const Positions positions(axes);
    each_eight(pairs.count, [&](std::size_t first, std::size_t count) {
        d8 at[3];
        positions(pairs, first, at);
        for (std::size_t lane = 0; lane < count; ++lane) {
            std::int64_t index = 0;
            for (int axis = 0; axis < 3; ++axis)
                index = index * axes.n[axis] + std::int64_t(at[axis][static_cast<int>(lane)] + 0.5);
            nodes[first + lane] = index;
        }
    });
}

}  // namespace shrm
