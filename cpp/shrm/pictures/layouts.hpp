// Pictures of the sphere: where a point of a picture looks, where a direction falls in it, and
// the exact solid angle of each texel.
//
// A position (x, y) is in texels, x to the right and y down; texel (i, j) is the square
// [j, j + 1] x [i, i + 1]. Every layout maps positions to unit directions one to one, except on
// seams. What lies outside a layout's domain (the empty part of a cross, the corners round a
// disc) has density -1, and a texel that the domain's edge cuts counts only for its part.
// Seen from inside the sphere no layout is mirrored.
//
// Debevec's axes, X right, Y up, -Z forward, are (x, y, z) here = (-Z, -X, Y) there: forward is
// the center of the lat-long picture, +x; right is -y.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "shrm/core.hpp"

namespace shrm {

// A direction, and the solid angle per area of picture there, in steradians per texel.
struct Ray {
    glm::dvec3 direction;
    double density;
};

// The smallest rectangle round the part of a texel that is inside the layout's domain.
struct Box {
    double x0, y0, x1, y1;
};

// Latitude and longitude as core.hpp states them. `inset` is 0, or 1/2 for OpenEXR's `envmap`
// files, whose texel *centers* lie on the edges: their outermost texels are cut in half, and the
// first and the last column show the same meridian.
class LatLong {
  public:
    LatLong(int height, int width, double inset);
    Ray ray(double x, double y) const;
    glm::dvec2 position(const glm::dvec3& direction) const;
    double solid_angle(int i, int j) const;
    Box box(int i, int j) const;

  private:
    double height_, width_, inset_;
    double theta(double y) const;
};

// Six squares, each the view through one face of a cube: direction ~ forward + s right + t up
// with s and t in [-1, 1]. `inset` as above.
class Cube {
  public:
    // The face that looks along one axis: its upward direction, and the cell of the picture it fills.
    // The direction to its right is cross(forward, up).
    struct Face {
        glm::dvec3 up;
        int column, row;
    };
    using Faces = std::array<Face, 6>;  // looking along +x, -x, +y, -y, +z, -z

    Cube(const Faces& faces, int size, double inset);
    Ray ray(double x, double y) const;
    glm::dvec2 position(const glm::dvec3& direction) const;
    double solid_angle(int i, int j) const;
    Box box(int i, int j) const;

  private:
    struct Frame {
        glm::dvec3 forward, right, up;
        int column, row;
    };
    std::array<Frame, 6> frames_;
    std::array<int, 36> face_of_cell_;  // [row * 6 + column], -1 where the picture is empty
    int size_;
    double inset_;
    int face_at(double x, double y) const;
};

// Discs of diameter `size`, in which the angle from the axis grows with the radius r in [0, 1].
class Disc {
  public:
    // angular       Debevec's light probe, angle = pi r: the center looks along +x, right is
    //               -y, up is +z, the rim is -x.
    // mirror_ball   angle = 2 asin r, as on a mirrored ball, with the axes of the light probe; every
    //               texel of the disc has the same solid angle. (A photograph of a real ball shows
    //               the world mirrored: flip it left to right, and its front is behind the camera.)
    // paraboloids   two side by side, angle = 2 atan r: the left looks along +z (right -y,
    //               up -x), the right along -z (right -y, up +x). [HS98]
    enum class Kind { angular, mirror_ball, paraboloids };

    Disc(Kind kind, int size);
    Ray ray(double x, double y) const;
    glm::dvec2 position(const glm::dvec3& direction) const;
    double solid_angle(int i, int j) const;
    Box box(int i, int j) const;

  private:
    Kind kind_;
    int size_;
    double density(double r_squared) const;  // steradians per unit of area of the unit disc
    double center(double x) const { return size_ * (x < size_ || kind_ != Kind::paraboloids ? 0.5 : 1.5); }
    double quadrature(double x0, double x1, double y0, double y1) const;
};

// The octahedron |x| + |y| + |z| = 1 unfolded into a square [ED08]: the center looks along +z,
// right is -y, up is -x, the corners are -z.
class Octahedral {
  public:
    explicit Octahedral(int size) : size_(size) {}
    Ray ray(double x, double y) const;
    glm::dvec2 position(const glm::dvec3& direction) const;
    double solid_angle(int i, int j) const;
    Box box(int i, int j) const { return {1.0 * j, 1.0 * i, j + 1.0, i + 1.0}; }

  private:
    int size_;
};

using Layout = std::variant<LatLong, Cube, Disc, Octahedral>;

// The names, in the order in which they are documented:
//   latlong             H x W, core.hpp
//   openexr-latlong     H x W, the same axes, texel centers on the edges
//   vertical-cross      4n x 3n: top / left front right / bottom / back turned by 180 degrees
//   horizontal-cross    3n x 4n: top / left front right back / bottom
//   strip               n x 6n or 6n x n in OpenGL's order +X -X +Y -Y +Z -Z with its pictures;
//                       +Z is front (+x here), +X is right (-y), +Y is up (+z)
//   openexr-cube        6n x n, the same order, OpenEXR's axes and pictures, (x, y, z) here =
//                       (Z, X, Y) there, texel centers on the edges
//   angular, mirror-ball, octahedral   n x n
//   dual-paraboloid     n x 2n
//
// Throws std::invalid_argument for an unknown name, and for a size that the layout cannot have.
Layout make_layout(std::string_view name, int height, int width);

// The exact solid angle of every texel, (H, W); their sum is 4 pi.
std::vector<double> solid_angles(const Layout& layout, int height, int width);

}  // namespace shrm
