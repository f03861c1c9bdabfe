#include "shrm/transfer/views.hpp"

#include <algorithm>

#include "shrm/simd/vectors.hpp"

namespace shrm {
namespace {

struct View {
    Floats x, y, z;
};

inline Floats dot(const View& a, const View& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Planes of a block, from vertex i on.
class Planes {
  public:
    Planes(const TransferSurface& surface, int block) : first_(surface.plane(block, 0)) {}

    View triple(int which, int i) const {
        const float* from = first_ + 3 * which * vertex_block + i;
        return {load(from), load(from + vertex_block), load(from + 2 * vertex_block)};
    }
    View position(int i) const { return triple(0, i); }
    // An axis of the frames: tangent, bitangent, normal.
    View axis(int which, int i) const { return triple(1 + which, i); }

  private:
    const float* first_;
};

// The unit vector to the eye, in the frame. An eye at the vertex is above it.
inline View local_view(const Planes& planes, const Eye& eye, int i) {
    View d{eye.at.x + Floats{}, eye.at.y + Floats{}, eye.at.z + Floats{}};
    Floats length = 1 + Floats{};
    if (!eye.distant) {
        const View p = planes.position(i);
        d = {d.x - p.x, d.y - p.y, d.z - p.z};
        length = square_root(dot(d, d));
    }
    const Floats scale = 1 / larger(length, 1e-30f + Floats{});
    const Floats z = dot(planes.axis(2, i), d) * scale;
    return {dot(planes.axis(0, i), d) * scale, dot(planes.axis(1, i), d) * scale,
            length > 0 ? z : 1 + Floats{}};
}

// Views below the horizon are brought to it.
inline View above_horizon(const View& v) {
    const Floats scale = 1 / larger(square_root(v.x * v.x + v.y * v.y), 1e-30f + Floats{});
    const auto below = v.z < 0;
    return {below ? v.x * scale : v.x, below ? v.y * scale : v.y, below ? Floats{} : v.z};
}

// 4 / pi times the arc tangent of q in [0, 1]: to 3e-7. Odd, the relative error minimal at 8 terms.
inline Floats eighths_of_turn(Floats q) {
    const Floats square = q * q;
    Floats sum = -0.00597576471f + Floats{};
    for (const float term : {0.0308794975f, -0.0757410005f, 0.126233146f, -0.178501755f, 0.254262447f,
                             -0.424396098f, 1.27323937f})
        sum = sum * square + term;
    return sum * q;
}

// Stores the four samples around positions on the grid, in units of its cells, and their weights.
inline void store_neighbours(Floats u, Floats v, int side, int i, Neighbours& to) {
    u = larger(u, Floats{}), v = larger(v, Floats{});  // NaN, of vectors that overflowed, becomes 0
    const Ints last = side - 2 + Ints{};
    Ints column = truncated(u), row = truncated(v);
    column = column < last ? column : last;
    row = row < last ? row : last;
    const Floats s = smaller(u - floats_of(column), 1 + Floats{});
    const Floats t = smaller(v - floats_of(row), 1 + Floats{});
    const Floats both = s * t;
    *reinterpret_cast<Ints*>(to.first + i) = row * side + column;
    store(to.weights[0] + i, 1 - s - (t - both));
    store(to.weights[1] + i, s - both);
    store(to.weights[2] + i, t - both);
    store(to.weights[3] + i, both);
}

}  // namespace

TransferSurface::TransferSurface(std::span<const float> vertices, std::span<const float> frames)
    : vertices_(static_cast<int>(vertices.size() / 3)), planes_(size(blocks()) * planes * vertex_block) {
    for (std::size_t p = 0; p < size(vertices_); ++p) {
        float* to = &planes_[p / vertex_block * planes * vertex_block + p % vertex_block];
        for (std::size_t c = 0; c < 3; ++c) {
            to[c * vertex_block] = vertices[3 * p + c];
            for (std::size_t axis = 0; axis < 3; ++axis)
                to[(3 + 3 * axis + c) * vertex_block] = frames[9 * p + 3 * c + axis];
        }
    }
}

int TransferSurface::count(int block) const {
    return std::min(vertices_ - block * vertex_block, vertex_block);
}

void tents_of_views(const TransferSurface& surface, int block, const Eye& eye, int M, Neighbours& tents) {
    const Planes planes(surface, block);
    const float half = 0.5f * static_cast<float>(M - 1);
    for (int i = 0; i < surface.count(block); i += lanes) {
        const View v = local_view(planes, eye, i);
        // r^2 = 1 - z, without its loss of digits near the pole; 1 on the horizon and below
        const Floats squared = (v.x * v.x + v.y * v.y) / (1 + larger(v.z, Floats{}));
        const Floats r = v.z < 0 ? 1 + Floats{} : smaller(square_root(squared), 1 + Floats{});
        const Floats x = magnitude(v.x), y = magnitude(v.y);
        const Floats ratio = smaller(x, y) / larger(larger(x, y), 1e-30f + Floats{});
        const Floats across = r * eighths_of_turn(ratio);
        const auto along_x = x >= y;
        const Floats a = along_x ? r : across, b = along_x ? across : r;
        store_neighbours(half + half * (v.x < 0 ? -a : a), half + half * (v.y < 0 ? -b : b), M, i, tents);
    }
}

void parabolic_samples_of_views(const TransferSurface& surface, int block, const Eye& eye, int side,
                                Neighbours& samples) {
    const Planes planes(surface, block);
    const float half = 0.5f * static_cast<float>(side - 1);
    for (int i = 0; i < surface.count(block); i += lanes) {
        const View v = above_horizon(local_view(planes, eye, i));
        const Floats scale = half / (1 + v.z);
        store_neighbours(half + v.x * scale, half + v.y * scale, side, i, samples);
    }
}

void reflections_of_views(const TransferSurface& surface, int block, const Eye& eye,
                          Directions& reflections) {
    const Planes planes(surface, block);
    for (int i = 0; i < surface.count(block); i += lanes) {
        const View v = above_horizon(local_view(planes, eye, i));
        const View x = planes.axis(0, i), y = planes.axis(1, i), z = planes.axis(2, i);
        store(reflections.x + i, v.z * z.x - v.x * x.x - v.y * y.x);
        store(reflections.y + i, v.z * z.y - v.x * x.y - v.y * y.y);
        store(reflections.z + i, v.z * z.z - v.x * x.z - v.y * y.z);
    }
}

}  // namespace shrm
