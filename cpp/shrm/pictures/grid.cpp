#include "shrm/pictures/grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace shrm {

namespace {

constexpr double most_bend = 1.0 / 32;  // of the edges of a quadrilateral taken as straight, in its widths
constexpr double most_twist = 0.25;     // from a parallelogram, in diagonals: more means a seam
constexpr int most_splits = 6;          // of a texel where the other picture has a seam
constexpr double accuracy = 1e-4;       // of the marginals that is enough
constexpr double relaxation = 1.5;      // of the fitting: errors that span many texels fall faster

std::size_t index(int i, int j, int width) {
    return size(i) * size(width) + size(j);
}

// A convex polygon of at most eight corners: a quadrilateral cut by a square. (One that is folded, at
// a pole, could have more: they are dropped.)
struct Polygon {
    std::array<glm::dvec2, 8> corner;
    std::size_t count = 0;

    // The part of the polygon where sign * (p[axis] - bound) >= 0.
    Polygon cut(int axis, double bound, double sign) const {
        Polygon kept;
        for (std::size_t k = 0; k < count; ++k) {
            const glm::dvec2 p = corner[k], q = corner[(k + 1) % count];
            const double dp = sign * (p[axis] - bound), dq = sign * (q[axis] - bound);
            if (dp >= 0) kept.add(p);
            if ((dp < 0) != (dq < 0)) kept.add(p + dp / (dp - dq) * (q - p));
        }
        return kept;
    }

    void add(const glm::dvec2& p) {
        if (count < corner.size()) corner[count++] = p;
    }

    double area() const {
        double twice = 0;
        for (std::size_t k = 1; k + 1 < count; ++k) {
            const glm::dvec2 a = corner[k] - corner[0], b = corner[k + 1] - corner[0];
            twice += a.x * b.y - a.y * b.x;
        }
        return std::abs(twice) / 2;
    }

    glm::dvec2 mean() const {
        glm::dvec2 sum{0};
        for (std::size_t k = 0; k < count; ++k) sum += corner[k];
        return sum / static_cast<double>(count);
    }
};

// The overlaps of one texel with those texels of the other picture that are no smaller.
template <class Own, class Other>
class Cutter {
  public:
    struct Part {
        std::size_t texel;
        double solid_angle;
    };

    Cutter(const Own& own, const Other& other, const glm::dmat3& other_from_own, int other_width,
           const std::vector<double>& other_areas)
        : own_(own),
          other_(other),
          other_from_own_(other_from_own),
          other_width_(other_width),
          other_areas_(other_areas) {}

    // The parts of texel (i, j), of solid angle `area`, in texels whose solid angles are at least `smallest`.
    const std::vector<Part>& cut(int i, int j, double area, double smallest) {
        constexpr double edge = 1e-7;  // stays off the edges, where seams may be
        parts_.clear();
        found_ = 0;
        const Box box = own_.box(i, j);
        const double inset_x = edge * (box.x1 - box.x0), inset_y = edge * (box.y1 - box.y0);
        const double x0 = box.x0 + inset_x, x1 = box.x1 - inset_x, y0 = box.y0 + inset_y,
                     y1 = box.y1 - inset_y;
        quad(x0, y0, x1, y1, {point(x0, y0), point(x1, y0), point(x1, y1), point(x0, y1)}, most_splits);
        const auto small = [&](const Part& part) { return other_areas_[part.texel] < smallest; };
        std::erase_if(parts_, small);
        for (Part& part : parts_) part.solid_angle *= area / found_;
        return parts_;
    }

  private:
    struct Point {
        glm::dvec2 at;   // in the other picture
        double density;  // -1 outside the own layout's domain
    };

    Point point(double x, double y) const {
        const Ray ray = own_.ray(x, y);
        return {other_.position(other_from_own_ * ray.direction), ray.density};
    }

    std::size_t texel(const glm::dvec2& at) const {
        return index(static_cast<int>(at.y), static_cast<int>(at.x), other_width_);
    }

    void add(std::size_t where, double solid_angle) {
        if (other_areas_[where] <= 0) return;
        found_ += solid_angle;
        const auto same = [where](const Part& part) { return part.texel == where; };
        const auto found = std::find_if(parts_.begin(), parts_.end(), same);
        if (found == parts_.end())
            parts_.push_back({where, solid_angle});
        else
            found->solid_angle += solid_angle;
    }

    // Adds the rectangle [x0, x1] x [y0, y1] of the own picture, corners in turn from the top left.
    void quad(double x0, double y0, double x1, double y1, const std::array<Point, 4>& corners, int depth) {
        const double x = (x0 + x1) / 2, y = (y0 + y1) / 2, area = (x1 - x0) * (y1 - y0);
        const auto& [a, b, c, d] = corners;
        const Point top = point(x, y0), left = point(x0, y);
        const double least =
            std::min({a.density, b.density, c.density, d.density, top.density, left.density});
        if (least >= 0) {
            const std::size_t cell = texel(a.at);
            const auto same = [&](const Point& p) { return texel(p.at) == cell; };
            if (same(b) && same(c) && same(d) && same(top) && same(left))
                return add(cell, (a.density + b.density + c.density + d.density) / 4 * area);
            const Polygon shape{{a.at, b.at, c.at, d.at}, 4};
            if (straight(shape, bend(a, top, b) + bend(a, left, d)) && whole(corners))
                return cut_at_grid(shape);
        }
        const double most = std::max({a.density, b.density, c.density, d.density, top.density, left.density});
        if (most < 0 && depth < most_splits - 1) return;
        if (depth > 0) {
            const Point center = point(x, y), right = point(x1, y), bottom = point(x, y1);
            quad(x0, y0, x, y, {a, top, center, left}, depth - 1);
            quad(x, y0, x1, y, {top, b, right, center}, depth - 1);
            quad(x, y, x1, y1, {center, right, c, bottom}, depth - 1);
            quad(x0, y, x, y1, {left, center, bottom, d}, depth - 1);
            return;
        }
        // A seam of the other picture, or the edge of the own one's domain.
        for (const Point& p : corners)
            if (p.density >= 0) add(texel(p.at), p.density * area / 4);
    }

    static double bend(const Point& from, const Point& middle, const Point& to) {
        return glm::length(middle.at - 0.5 * (from.at + to.at));
    }

    // True if edges that bend by so much are straight, measured by the width: slivers are common where a
    // picture draws a single direction out to a line, as round the rim of a probe.
    static bool straight(const Polygon& quad, double bend) {
        const double length = std::max(glm::length(quad.corner[2] - quad.corner[0]),
                                       glm::length(quad.corner[3] - quad.corner[1]));
        return bend * length <= most_bend * quad.area();
    }

    // True if the corners are nearly those of a parallelogram: then none is beyond a seam.
    static bool whole(const std::array<Point, 4>& p) {
        const glm::dvec2 one = p[2].at - p[0].at, two = p[3].at - p[1].at;
        const glm::dvec2 twist = p[0].at + p[2].at - p[1].at - p[3].at;
        return glm::dot(twist, twist) <
               most_twist * most_twist * std::max(glm::dot(one, one), glm::dot(two, two));
    }

    // Cuts a quadrilateral of the other picture at its grid.
    void cut_at_grid(const Polygon& quad) {
        glm::dvec2 low = quad.corner[0], high = low;
        for (std::size_t k = 1; k < 4; ++k) {
            low = glm::min(low, quad.corner[k]);
            high = glm::max(high, quad.corner[k]);
        }
        for (int i = static_cast<int>(low.y); i <= static_cast<int>(high.y); ++i) {
            const Polygon row = between(quad, 1, i, low.y, high.y);
            for (int j = static_cast<int>(low.x); j <= static_cast<int>(high.x); ++j) {
                const std::size_t where = index(i, j, other_width_);
                const Polygon part = between(row, 0, j, low.x, high.x);
                if (part.count < 3) continue;
                const glm::dvec2 p = part.mean();
                add(where, part.area() * other_.ray(p.x, p.y).density);
            }
        }
    }

    // The part of a polygon, which reaches from low to high, that lies in [line, line + 1].
    static Polygon between(const Polygon& polygon, int axis, int line, double low, double high) {
        Polygon part = polygon;
        if (low < line) part = part.cut(axis, line, 1);
        if (high > line + 1) part = part.cut(axis, line + 1, -1);
        return part;
    }

    const Own& own_;
    const Other& other_;
    const glm::dmat3& other_from_own_;
    int other_width_;
    const std::vector<double>& other_areas_;
    std::vector<Part> parts_;
    double found_ = 0;
};

// The overlaps of the own texels with texels of the other picture that are larger (or, if
// `ties`, as large).
template <class Own, class Other>
std::vector<OverlapRow> cut_picture(const Own& own, const Picture& own_picture,
                                    const std::vector<double>& own_areas, const Other& other,
                                    const Picture& other_picture, const std::vector<double>& other_areas,
                                    const glm::dmat3& other_from_own, bool ties) {
    std::vector<OverlapRow> rows(size(own_picture.height));
#pragma omp parallel
    {
        Cutter<Own, Other> cutter(own, other, other_from_own, other_picture.width, other_areas);
#pragma omp for schedule(dynamic, 4)
        for (int i = 0; i < own_picture.height; ++i) {
            auto& row = rows[size(i)];
            row.first.reserve(size(own_picture.width) + 1);
            for (int j = 0; j < own_picture.width; ++j) {
                row.first.push_back(static_cast<std::uint32_t>(row.overlaps.size()));
                const double area = own_areas[index(i, j, own_picture.width)];
                if (area <= 0) continue;
                const double smallest = ties ? area : std::nextafter(area, 2 * area);
                for (const auto& part : cutter.cut(i, j, area, smallest))
                    row.overlaps.push_back(
                        {static_cast<std::uint32_t>(part.texel), static_cast<float>(part.solid_angle)});
            }
            row.first.push_back(static_cast<std::uint32_t>(row.overlaps.size()));
            row.overlaps.shrink_to_fit();
        }
    }
    return rows;
}

// sums[i] = sum over j of overlap_ij values[j], i the texels of one picture, whose overlaps with
// larger texels are `own`, j those of the other.
void multiply(const std::vector<OverlapRow>& own, const std::vector<OverlapRow>& other,
              const std::vector<double>& values, std::vector<double>& sums) {
    const std::size_t width = sums.size() / own.size(), other_width = values.size() / other.size();
    const auto rows = static_cast<std::ptrdiff_t>(own.size());
#pragma omp parallel for if (sums.size() > 20'000)
    for (std::ptrdiff_t i = 0; i < rows; ++i) {
        const auto& row = own[static_cast<std::size_t>(i)];
        for (std::size_t j = 0; j < width; ++j) {
            double sum = 0;
            for (std::size_t k = row.first[j]; k < row.first[j + 1]; ++k)
                sum += static_cast<double>(row.overlaps[k].solid_angle) * values[row.overlaps[k].other];
            sums[static_cast<std::size_t>(i) * width + j] = sum;
        }
    }
    // Added up in order, so that the result does not depend on the number of threads.
    for (std::size_t i = 0; i < other.size(); ++i)
        for (std::size_t j = 0; j < other_width; ++j)
            for (std::size_t k = other[i].first[j]; k < other[i].first[j + 1]; ++k)
                sums[other[i].overlaps[k].other] +=
                    static_cast<double>(other[i].overlaps[k].solid_angle) * values[i * other_width + j];
}

}  // namespace

Conversion::Conversion(const Picture& source, const Picture& target, const glm::dmat3& target_from_source) {
    const std::vector<double> source_areas = solid_angles(source.layout, source.height, source.width);
    const std::vector<double> target_areas = solid_angles(target.layout, target.height, target.width);
    std::visit(
        [&](const auto& from, const auto& to) {
            source_smaller_ =
                cut_picture(from, source, source_areas, to, target, target_areas, target_from_source, true);
            target_smaller_ = cut_picture(to, target, target_areas, from, source, source_areas,
                                          glm::transpose(target_from_source), false);
        },
        source.layout, target.layout);

    // Iterative proportional fitting; it ends with the target's scales, so that a constant stays
    // constant to rounding.
    source_scale_.assign(source_areas.size(), 1);
    target_scale_.assign(target_areas.size(), 1);
    std::vector<double> sums(source_areas.size());
    const std::size_t most_rounds = 20 + 300'000 / (source_areas.size() + target_areas.size());
    for (std::size_t round = 0;; ++round) {
        multiply(source_smaller_, target_smaller_, target_scale_, sums);
        residual_ = 0;
        for (std::size_t i = 0; i < sums.size(); ++i)
            if (sums[i] > 0)
                residual_ = std::max(residual_, std::abs(source_scale_[i] * sums[i] / source_areas[i] - 1));
        if (round > 0 && (residual_ < accuracy || round == most_rounds)) break;
        for (std::size_t i = 0; i < sums.size(); ++i)
            if (sums[i] > 0) source_scale_[i] += relaxation * (source_areas[i] / sums[i] - source_scale_[i]);
        multiply(target_smaller_, source_smaller_, source_scale_, target_scale_);
        for (std::size_t j = 0; j < target_scale_.size(); ++j)
            target_scale_[j] = target_scale_[j] > 0 ? target_areas[j] / target_scale_[j] : 0;
    }
    for (std::size_t j = 0; j < target_scale_.size(); ++j)
        if (target_areas[j] > 0) target_scale_[j] /= target_areas[j];
}

void Conversion::apply(std::span<const float> source, int channels, std::span<float> target) const {
    std::vector<double> light(source_scale_.size()), sums(target_scale_.size());
    const auto stride = size(channels);
    for (std::size_t c = 0; c < stride; ++c) {
        for (std::size_t i = 0; i < light.size(); ++i)
            light[i] = source_scale_[i] * static_cast<double>(source[i * stride + c]);
        multiply(target_smaller_, source_smaller_, light, sums);
        for (std::size_t j = 0; j < sums.size(); ++j)
            target[j * stride + c] = static_cast<float>(target_scale_[j] * sums[j]);
    }
}

}  // namespace shrm
