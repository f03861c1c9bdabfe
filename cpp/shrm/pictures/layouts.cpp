#include "shrm/pictures/layouts.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace shrm {

using glm::dvec2;
using glm::dvec3;

namespace {

constexpr dvec3 X{1, 0, 0}, Y{0, 1, 0}, Z{0, 0, 1};

double square(double x) {
    return x * x;
}

// A coordinate in a cell of the picture, kept off its far edge, where the next cell begins.
double within(double x, double size) {
    return std::clamp(x, 0.0, size - 1e-9);
}

}  // namespace

// ---- latitude and longitude

LatLong::LatLong(int height, int width, double inset) : height_(height), width_(width), inset_(inset) {}

double LatLong::theta(double y) const {
    return pi * std::clamp((y - inset_) / (height_ - 2 * inset_), 0.0, 1.0);
}

Ray LatLong::ray(double x, double y) const {
    const double u = (x - inset_) / (width_ - 2 * inset_), v = (y - inset_) / (height_ - 2 * inset_);
    if (u < 0 || u > 1 || v < 0 || v > 1) return {X, -1};
    const double phi = pi - 2 * pi * u, angle = pi * v, sine = std::sin(angle);
    const double scale = 2 * pi * pi / ((width_ - 2 * inset_) * (height_ - 2 * inset_));
    return {{sine * std::cos(phi), sine * std::sin(phi), std::cos(angle)}, scale * sine};
}

dvec2 LatLong::position(const dvec3& d) const {
    const double u = 0.5 - std::atan2(d.y, d.x) / (2 * pi);
    const double v = std::atan2(std::sqrt(d.x * d.x + d.y * d.y), d.z) / pi;
    return {within(inset_ + u * (width_ - 2 * inset_), width_),
            within(inset_ + v * (height_ - 2 * inset_), height_)};
}

Box LatLong::box(int i, int j) const {
    return {std::max<double>(j, inset_), std::max<double>(i, inset_),
            std::min<double>(j + 1, width_ - inset_), std::min<double>(i + 1, height_ - inset_)};
}

double LatLong::solid_angle(int i, int j) const {
    const double first = std::max<double>(j, inset_), last = std::min<double>(j + 1, width_ - inset_);
    // cos a - cos b without cancellation
    const double a = theta(i), b = theta(i + 1);
    return 2 * pi * (last - first) / (width_ - 2 * inset_) * 2 * std::sin((a + b) / 2) *
           std::sin((b - a) / 2);
}

// ---- cubes

Cube::Cube(const Faces& faces, int size, double inset) : size_(size), inset_(inset) {
    const std::array<dvec3, 6> axes{X, -X, Y, -Y, Z, -Z};
    face_of_cell_.fill(-1);
    for (std::size_t f = 0; f < 6; ++f) {
        const Face& face = faces[f];
        frames_[f] = {axes[f], glm::cross(axes[f], face.up), face.up, face.column, face.row};
        face_of_cell_[static_cast<std::size_t>(face.row * 6 + face.column)] = static_cast<int>(f);
    }
}

int Cube::face_at(double x, double y) const {
    const int column = static_cast<int>(x / size_), row = static_cast<int>(y / size_);
    const bool inside = x >= 0 && y >= 0 && column < 6 && row < 6;
    return inside ? face_of_cell_[size(row * 6 + column)] : -1;
}

Ray Cube::ray(double x, double y) const {
    const int face = face_at(x, y);
    if (face < 0) return {X, -1};
    const Frame& f = frames_[size(face)];
    const double scale = 2 / (size_ - 2 * inset_);
    const double s = scale * (x - f.column * size_ - inset_) - 1,
                 t = 1 - scale * (y - f.row * size_ - inset_);
    const double r2 = 1 + s * s + t * t, r = std::sqrt(r2);
    const bool inside = std::abs(s) <= 1 && std::abs(t) <= 1;
    return {(f.forward + s * f.right + t * f.up) / r, inside ? square(scale) / (r2 * r) : -1};
}

dvec2 Cube::position(const dvec3& d) const {
    const double ax = std::abs(d.x), ay = std::abs(d.y), az = std::abs(d.z);
    const std::size_t face = ax >= ay && ax >= az ? (d.x < 0) : ay >= az ? 2 + (d.y < 0) : 4 + (d.z < 0);
    const Frame& f = frames_[face];
    const double depth = glm::dot(d, f.forward), half = size_ / 2.0 - inset_;
    return {f.column * size_ + within(inset_ + half * (1 + glm::dot(d, f.right) / depth), size_),
            f.row * size_ + within(inset_ + half * (1 - glm::dot(d, f.up) / depth), size_)};
}

Box Cube::box(int i, int j) const {
    const double left = j - j % size_, top = i - i % size_;
    return {std::max<double>(j, left + inset_), std::max<double>(i, top + inset_),
            std::min<double>(j + 1, left + size_ - inset_), std::min<double>(i + 1, top + size_ - inset_)};
}

double Cube::solid_angle(int i, int j) const {
    if (face_at(j + 0.5, i + 0.5) < 0) return 0;
    // The rectangle [0, s] x [0, t] of the plane at distance 1 has the solid angle corner(s, t).
    const auto corner = [](double s, double t) { return std::atan2(s * t, std::sqrt(s * s + t * t + 1)); };
    const auto edge = [this](int k) {
        return std::clamp(2 * (k - inset_) / (size_ - 2 * inset_) - 1, -1.0, 1.0);
    };
    const int row = i % size_, column = j % size_;
    const double s0 = edge(column), s1 = edge(column + 1), t0 = edge(row), t1 = edge(row + 1);
    return corner(s1, t1) - corner(s0, t1) - corner(s1, t0) + corner(s0, t0);
}

// ---- discs

namespace {

struct Frame {
    dvec3 forward, right, up;
};

Frame frame_of(Disc::Kind kind, bool second) {
    switch (kind) {
        case Disc::Kind::angular:
        case Disc::Kind::mirror_ball:
            return {X, -Y, Z};
        case Disc::Kind::paraboloids:
            break;
    }
    return second ? Frame{-Z, -Y, X} : Frame{Z, -Y, -X};
}

}  // namespace

Disc::Disc(Kind kind, int size) : kind_(kind), size_(size) {}

double Disc::density(double r2) const {
    switch (kind_) {
        case Kind::angular: {  // sin(angle) d angle / (r dr), angle = pi r
            const double angle = pi * std::sqrt(r2);
            return pi * pi * (angle < 1e-4 ? 1 - angle * angle / 6 : std::sin(angle) / angle);
        }
        case Kind::mirror_ball:
            return 4;
        case Kind::paraboloids:
            break;
    }
    return 4 / square(1 + r2);
}

Ray Disc::ray(double x, double y) const {
    const double radius = size_ / 2.0;
    const double s = (x - center(x)) / radius, t = 1 - y / radius, r2 = s * s + t * t;
    if (r2 > 1) return {X, -1};
    const double solid = density(r2);
    double cosine = 0, sine_over_r = 0;
    switch (kind_) {
        case Kind::angular:
            cosine = std::cos(pi * std::sqrt(r2));
            sine_over_r = solid / pi;
            break;
        case Kind::mirror_ball:
            cosine = 1 - 2 * r2;
            sine_over_r = 2 * std::sqrt(1 - r2);
            break;
        case Kind::paraboloids:
            cosine = (1 - r2) / (1 + r2);
            sine_over_r = 2 / (1 + r2);
            break;
    }
    const Frame f = frame_of(kind_, center(x) > size_);
    return {cosine * f.forward + sine_over_r * (s * f.right + t * f.up), solid / square(radius)};
}

dvec2 Disc::position(const dvec3& d) const {
    const bool second = kind_ == Kind::paraboloids && d.z < 0;
    const Frame f = frame_of(kind_, second);
    const double cosine = glm::dot(d, f.forward), a = glm::dot(d, f.right), b = glm::dot(d, f.up);
    const double sine = std::sqrt(a * a + b * b);
    double r = 0;
    switch (kind_) {
        case Kind::angular:
            r = std::atan2(sine, cosine) / pi;
            break;
        case Kind::mirror_ball:
            r = cosine > 0 ? sine / std::sqrt(2 * (1 + cosine)) : std::sqrt((1 - cosine) / 2);
            break;
        case Kind::paraboloids:
            r = sine / (1 + cosine);
            break;
    }
    r = std::min(r, 1.0);
    const double radius = size_ / 2.0, s = sine > 0 ? a / sine : 1, t = sine > 0 ? b / sine : 0;
    return {(second ? size_ : 0) + within(radius * (1 + r * s), size_), within(radius * (1 - r * t), size_)};
}

Box Disc::box(int i, int j) const {
    const double radius = size_ / 2.0, middle = center(j + 0.5);
    const double x0 = j - middle, x1 = x0 + 1, y0 = i - radius, y1 = y0 + 1;
    // The reach of the disc in x, at the texel's y that is nearest to the center, and likewise in y
    const double reach_x = std::sqrt(std::max(0.0, square(radius) - square(std::clamp(0.0, y0, y1))));
    const double reach_y = std::sqrt(std::max(0.0, square(radius) - square(std::clamp(0.0, x0, x1))));
    return {middle + std::max(x0, -reach_x), radius + std::max(y0, -reach_y), middle + std::min(x1, reach_x),
            radius + std::min(y1, reach_y)};
}

double Disc::solid_angle(int i, int j) const {
    // Texels are folded into the first quadrant; one across an axis is two mirror images.
    const double radius = size_ / 2.0;
    double x0 = (j - center(j + 0.5)) / radius, x1 = (j + 1 - center(j + 0.5)) / radius;
    double y0 = (i - radius) / radius, y1 = (i + 1 - radius) / radius;
    const auto fold = [](double& a, double& b) {
        if (b <= 0) a = -std::exchange(b, -a);
        const bool across = a < 0;
        if (across) a = 0;
        return across ? 2 : 1;
    };
    const double copies = fold(x0, x1) * fold(y0, y1);
    return x0 * x0 + y0 * y0 < 1 ? copies * quadrature(x0, x1, y0, y1) : 0;
}

double Disc::quadrature(double x0, double x1, double y0, double y1) const {
    // Gauss-Legendre on [0, 1]; over a texel the integrand is smooth and the error far below 1e-6.
    constexpr std::array<std::pair<double, double>, 5> nodes{{{0.046910077030668, 0.118463442528095},
                                                              {0.230765344947158, 0.239314335249683},
                                                              {0.5, 0.284444444444444},
                                                              {0.769234655052842, 0.239314335249683},
                                                              {0.953089922969332, 0.118463442528095}}};
    // With y = sin a as the variable, the rim x = cos a is smooth up to its top. It enters the columns
    // of the texel at the first of these heights and leaves them at the second.
    const double enters = std::acos(std::min(1.0, x1)), leaves = std::acos(x0);
    const double first = std::asin(y0), last = std::asin(std::min(1.0, y1));
    const std::array<double, 3> breaks{first, std::clamp(enters, first, last),
                                       std::clamp(leaves, first, last)};
    double sum = 0;
    for (std::size_t k = 0; k < 2; ++k) {
        const double range = breaks[k + 1] - breaks[k];
        for (const auto& [v, weight_y] : nodes) {
            const double a = breaks[k] + v * range, y = std::sin(a), rim = std::cos(a);
            const double width = std::min(x1, rim) - x0;
            for (const auto& [u, weight_x] : nodes)
                sum += weight_x * weight_y * range * rim * width * density(square(x0 + u * width) + y * y);
        }
    }
    return sum;
}

// ---- the octahedron

namespace {

// The solid angle of a triangle from the directions of its corners, of any length [OS83] eq. 8.
double triangle(const dvec3& a, const dvec3& b, const dvec3& c) {
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    const double volume = std::abs(glm::dot(a, glm::cross(b, c)));
    return 2 *
           std::atan2(volume, la * lb * lc + glm::dot(a, b) * lc + glm::dot(a, c) * lb + glm::dot(b, c) * la);
}

// The solid angle of [0, s] x [0, t] in the first quadrant of the unfolded octahedron; odd in
// both, so that differences of it hold for every rectangle.
double octahedral_corner(double s, double t) {
    const double a = std::abs(s), b = std::abs(t), sign = (s < 0) == (t < 0) ? 1 : -1;
    const auto below = [](double u) { return triangle({1, 0, 0}, {u, 1 - u, 0}, {u, 0, 1 - u}); };
    if (a + b <= 1)
        return sign * (triangle({0, 0, 1}, {a, 0, 1 - a}, {a, b, 1 - a - b}) +
                       triangle({0, 0, 1}, {a, b, 1 - a - b}, {0, b, 1 - b}));
    // The whole face above, less its two cut corners, and the triangle beyond the fold.
    return sign *
           (pi / 2 - below(a) - below(b) + triangle({a, 1 - a, 0}, {1 - b, 1 - a, a + b - 1}, {1 - b, b, 0}));
}

}  // namespace

Ray Octahedral::ray(double x, double y) const {
    const double s = 2 * x / size_ - 1, t = 1 - 2 * y / size_;
    if (std::abs(s) > 1 || std::abs(t) > 1) return {X, -1};
    double a = s, b = t;
    const double c = 1 - std::abs(s) - std::abs(t);
    if (c < 0) {
        a = std::copysign(1 - std::abs(t), s);
        b = std::copysign(1 - std::abs(s), t);
    }
    const double r2 = a * a + b * b + c * c, r = std::sqrt(r2);
    return {dvec3{-b, -a, c} / r, square(2.0 / size_) / (r2 * r)};
}

dvec2 Octahedral::position(const dvec3& d) const {
    const double sum = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
    const double a = -d.y / sum, b = -d.x / sum;
    const double s = d.z < 0 ? std::copysign(1 - std::abs(b), a) : a;
    const double t = d.z < 0 ? std::copysign(1 - std::abs(a), b) : b;
    return {within(size_ * (1 + s) / 2, size_), within(size_ * (1 - t) / 2, size_)};
}

double Octahedral::solid_angle(int i, int j) const {
    const double s0 = 2.0 * j / size_ - 1, s1 = 2.0 * (j + 1) / size_ - 1;
    const double t0 = 2.0 * i / size_ - 1, t1 = 2.0 * (i + 1) / size_ - 1;
    return octahedral_corner(s1, t1) - octahedral_corner(s0, t1) - octahedral_corner(s1, t0) +
           octahedral_corner(s0, t0);
}

// ---- by name

namespace {

// The pictures of OpenGL's cube map, seen from inside: the face that looks along +x here is its
// +Z, that along -y its +X. In OpenEXR's cube +Z is +x and +X is +y.
Layout opengl_strip(int size, bool vertical) {
    const auto cell = [vertical](dvec3 up, int k) {
        return Cube::Face{up, vertical ? 0 : k, vertical ? k : 0};
    };
    return Cube({cell(Z, 4), cell(Z, 5), cell(Z, 1), cell(Z, 0), cell(-X, 2), cell(X, 3)}, size, 0);
}

Layout openexr_cube(int size) {
    return Cube({{{Z, 0, 4}, {Z, 0, 5}, {Z, 0, 0}, {Z, 0, 1}, {X, 0, 2}, {-X, 0, 3}}}, size, 0.5);
}

Layout vertical_cross(int size) {
    return Cube({{{Z, 1, 1}, {-Z, 1, 3}, {Z, 0, 1}, {Z, 2, 1}, {-X, 1, 0}, {X, 1, 2}}}, size, 0);
}

Layout horizontal_cross(int size) {
    return Cube({{{Z, 1, 1}, {Z, 3, 1}, {Z, 0, 1}, {Z, 2, 1}, {-X, 1, 0}, {X, 1, 2}}}, size, 0);
}

}  // namespace

Layout make_layout(std::string_view name, int height, int width) {
    const int h = height, w = width;
    const auto need = [&](bool fits, const char* what) {
        if (fits && h >= 1 && w >= 1) return;
        throw std::invalid_argument("a picture of layout " + std::string(name) + " is " + what +
                                    ", but this one is " + std::to_string(h) + " x " + std::to_string(w) +
                                    " (height x width)");
    };
    if (name == "latlong") return need(true, "at least 1 x 1"), LatLong(h, w, 0);
    if (name == "openexr-latlong") return need(h > 1 && w > 1, "at least 2 x 2"), LatLong(h, w, 0.5);
    if (name == "vertical-cross")
        return need(w % 3 == 0 && h / 4 == w / 3 && h % 4 == 0, "4n x 3n"), vertical_cross(w / 3);
    if (name == "horizontal-cross")
        return need(h % 3 == 0 && w / 4 == h / 3 && w % 4 == 0, "3n x 4n"), horizontal_cross(h / 3);
    if (name == "strip")
        return need(w == 6 * h || h == 6 * w, "n x 6n or 6n x n"), opengl_strip(std::min(h, w), h > w);
    if (name == "openexr-cube") return need(h == 6 * w && w > 1, "6n x n, n > 1"), openexr_cube(w);
    if (name == "dual-paraboloid") return need(w == 2 * h, "n x 2n"), Disc(Disc::Kind::paraboloids, h);
    if (name == "angular") return need(w == h, "n x n"), Disc(Disc::Kind::angular, h);
    if (name == "mirror-ball") return need(w == h, "n x n"), Disc(Disc::Kind::mirror_ball, h);
    if (name == "octahedral") return need(w == h, "n x n"), Octahedral(h);
    throw std::invalid_argument("unknown layout " + std::string(name));
}

std::vector<double> solid_angles(const Layout& layout, int height, int width) {
    std::vector<double> result(size(height) * size(width));
    std::visit(
        [&](const auto& map) {
#pragma omp parallel for
            for (int i = 0; i < height; ++i)
                for (int j = 0; j < width; ++j)
                    result[size(i) * size(width) + size(j)] = map.solid_angle(i, j);
        },
        layout);
    return result;
}

}  // namespace shrm
