// The methods before matrix radiance transfer, which take a vertex's whole matrix.
#include <algorithm>

#include "shrm/core.hpp"
#include "shrm/sh/view_harmonics.hpp"
#include "shrm/simd/shuffles.hpp"
#include "shrm/transfer/lighting.hpp"
#include "shrm/transfer/rows.hpp"

namespace shrm {
namespace {

constexpr int most_terms = 100;  // n = 10
static_assert(lanes <= rotation_room);

// A row for each channel, with room for the last vector.
struct Rows {
    float of[3][most_terms + lanes];
};

// Rows at the view: between four samples.   samples (side^2, C, n^2)
template <int known>
SHRM_KERNEL inline void interpolate(const float* samples, int side, int channels, Row<known> row,
                                    const Neighbours& at, int i, Rows& rows) {
    const std::size_t width = size(channels * row.count()), below = size(side) * width;
    const float* from = samples + size(at.first[i]) * width;
    for (int c = 0; c < channels; ++c, from += row.count())
        row.for_vectors([&](auto v) {
            const Floats sum =
                (at.weights[0][i] * row.load(from, v) + at.weights[1][i] * row.load(from + width, v)) +
                (at.weights[2][i] * row.load(from + below, v) +
                 at.weights[3][i] * row.load(from + below + width, v));
            store(rows.of[c] + row.begin(v), sum);
        });
}

// b R_p: rows of local coefficients as rows of global ones, band by band. Vectors read and write beyond the
// end of a band's row; what they write there the next band overwrites.
template <int known>
SHRM_KERNEL inline void rotate(const float* bands, int channels, Row<known> row, const Rows& local,
                               Rows& global) {
    row.for_degrees([&](auto l) {
        const int width = 2 * l + 1;
        for (int c = 0; c < channels; ++c)
            for (int v = 0; v < width; v += lanes) {
                Floats sum = {};
                for (int i = 0; i < width; ++i) sum += local.of[c][l * l + i] * load(bands + i * width + v);
                store(global.of[c] + l * l + v, sum);
            }
        bands += width * width;
    });
}

// sums[c] += b_c T_p light_c of one vertex, still apart in lanes. T_p is read in the order of memory.
//   transfer (n^2, n^2), b(c, i): coefficient i of channel c
template <int known, int channels, class Stored, class Coefficient>
SHRM_KERNEL inline void add_transferred(const Stored* transfer, Row<known> row, Coefficient&& b,
                                        const RowLight& light, Floats* sums) {
    Floats products[channels][vectors_of(known ? known : most_terms)] = {};
    for (int i = 0; i < row.count(); ++i)
        row.for_vectors([&](auto v) {
            const Floats of_row = row.load(transfer + i * row.count(), v);
            unrolled<channels>([&](auto c) { products[c][v] += b(c, i) * of_row; });
        });
    row.for_vectors([&](auto v) {
        unrolled<3>([&](auto c) {
            sums[c] += products[channels == 1 ? 0 : c][v] * light.channel(c, v, row.vectors());
        });
    });
}

template <int known, class Stored, class Coefficient>
inline void add_transferred(const Stored* transfer, Row<known> row, int channels, Coefficient&& b,
                            const RowLight& light, Floats* sums) {
    if (channels == 1)
        add_transferred<known, 1>(transfer, row, b, light, sums);
    else
        add_transferred<known, 3>(transfer, row, b, light, sums);
}

// The same where T_p is 1.
template <int known>
SHRM_KERNEL inline void add_untransferred(Row<known> row, int channels, const Rows& b, const RowLight& light,
                                          Floats* sums) {
    row.for_vectors([&](auto v) {
        unrolled<3>([&](auto c) {
            sums[c] += row.load(b.of[channels == 1 ? 0 : c], v) * light.channel(c, v, row.vectors());
        });
    });
}

// Calls body with the transfer's values, or with a null pointer.
template <class Body>
inline void for_stored(const TransferValues& transfer, Body&& body) {
    if (transfer.halves.empty())
        body(transfer.floats.data());
    else
        body(transfer.halves.data());
}

// The kernel's coefficient of each row's value: (n^2, C).
std::vector<float> kernel_of_terms(std::span<const float> kernel, int channels, int terms) {
    std::vector<float> of_terms(size(terms * channels));
    for (int l = 0; l * l < terms; ++l)
        for (int j = l * l; j < (l + 1) * (l + 1); ++j)
            std::copy_n(&kernel[size(l * channels)], channels, &of_terms[size(j * channels)]);
    return of_terms;
}

// Functions of these coefficients at the axes.   coefficients (n^2, 3), values (lanes, 4)
inline void evaluate_lanes(const std::vector<float>& coefficients, int terms, const Floats* Y,
                           float* values) {
    for (int c = 0; c < 3; ++c) {
        Floats sum = {};
        for (int j = 0; j < terms; ++j) sum += coefficients[size(3 * j + c)] * Y[j];
        for (int k = 0; k < lanes; ++k) values[4 * k + c] = sum[k];
    }
}

// Y_j at the axes of a vector of vertices.
inline void harmonics_at(const float* x, const float* y, const float* z, int n, Floats* Y) {
    const struct {
        Floats x, y, z;
    } axis{load(x), load(y), load(z)};
    real_harmonics(n - 1, axis, Y);
}

}  // namespace

void light_projected(const TransferSurface& surface, std::span<const float> samples, int side, bool parabolic,
                     int channels, std::span<const float> rotations, const TransferValues& transfer,
                     std::span<const float> light, const Eye& eye, std::span<float> radiance) {
    const RowLight packed(light);
    const auto elements = size(packed.terms() * packed.terms());
    const std::size_t bands =
        rotations.empty() ? 0 : (rotations.size() - rotation_room) / size(surface.vertices());
    for_stored(transfer, [&](const auto* matrices) {
        for_terms(packed.terms(), [&](auto known) {
            const Row<known> row{packed.terms()};
#pragma omp parallel for schedule(static)
            for (int block = 0; block < surface.blocks(); ++block) {
                Neighbours at;
                Quads found;
                if (parabolic)
                    parabolic_samples_of_views(surface, block, eye, side, at);
                else
                    tents_of_views(surface, block, eye, side, at);
                const int first = block * vertex_block, count = surface.count(block);
                for (int i = 0; i < count; i += vertex_group) {
                    Floats sums[lanes] = {};
                    for (int g = 0; g < vertex_group; ++g) {
                        const int p = std::min(i + g, count - 1);
                        const std::size_t vertex = size(first + p);
                        Rows local, global;
                        interpolate<known>(samples.data(), side, channels, row, at, p, local);
                        if (bands) rotate<known>(&rotations[vertex * bands], channels, row, local, global);
                        const Rows& b = bands ? global : local;
                        if (matrices)
                            add_transferred<known>(
                                matrices + vertex * elements, row, channels,
                                [&](int c, int k) { return b.of[c][k]; }, packed, sums + 4 * g);
                        else
                            add_untransferred<known>(row, channels, b, packed, sums + 4 * g);
                    }
                    store(found.values + 4 * i, sums_of<lanes>(sums));
                }
                found.copy(count, &radiance[3 * size(first)]);
            }
        });
    });
}

void light_convolved(const TransferSurface& surface, std::span<const float> kernel, int channels,
                     bool about_normal, const TransferValues& transfer, std::span<const float> light,
                     const Eye& eye, std::span<float> radiance) {
    const RowLight packed(light);
    const int terms = packed.terms();
    const auto elements = size(terms * terms);
    const std::vector<float> of_terms = kernel_of_terms(kernel, channels, terms);
    std::vector<float> filtered(size(terms * 3));  // light, where it is not transferred first
    for (int j = 0; j < terms; ++j)
        for (int c = 0; c < 3; ++c)
            filtered[size(3 * j + c)] =
                of_terms[size(j * channels + (channels == 1 ? 0 : c))] * light[size(3 * j + c)];
    for_stored(transfer, [&](const auto* matrices) {
        for_terms(terms, [&](auto known) {
            const Row<known> row{terms};
#pragma omp parallel for schedule(static)
            for (int block = 0; block < surface.blocks(); ++block) {
                Directions reflections;
                Quads found;
                const float *x = surface.plane(block, 9), *y = surface.plane(block, 10),
                            *z = surface.plane(block, 11);  // the normals
                if (!about_normal) {
                    reflections_of_views(surface, block, eye, reflections);
                    x = reflections.x, y = reflections.y, z = reflections.z;
                }
                const int first = block * vertex_block, count = surface.count(block);
                for (int i = 0; i < count; i += lanes) {
                    Floats Y[most_terms];
                    harmonics_at(x + i, y + i, z + i, row.n(), Y);
                    if (!matrices) {
                        evaluate_lanes(filtered, terms, Y, found.values + 4 * i);
                        continue;
                    }
                    Floats lobes[3][most_terms];
                    for (int c = 0; c < channels; ++c)
                        for (int j = 0; j < terms; ++j) lobes[c][j] = of_terms[size(j * channels + c)] * Y[j];
                    for (int k = 0; k < lanes; k += vertex_group) {
                        Floats sums[lanes] = {};
                        for (int g = 0; g < vertex_group; ++g) {
                            const auto vertex = size(first + std::min(i + k + g, count - 1));
                            add_transferred<known>(
                                matrices + vertex * elements, row, channels,
                                [&](int c, int j) { return lobes[c][j][k + g]; }, packed, sums + 4 * g);
                        }
                        store(found.values + 4 * (i + k), sums_of<lanes>(sums));
                    }
                }
                found.copy(count, &radiance[3 * size(first)]);
            }
        });
    });
}

}  // namespace shrm
