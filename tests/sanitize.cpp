// Every stage of the core on small and odd sizes, built and run under ASan and UBSan by
// test_sanitizers.py. Values are the business of the Python tests; here memory and undefined
// behaviour are watched, so a stage needs just a few calls whose sizes are awkward.
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include <glm/glm.hpp>

#include "shrm/angular/angular.hpp"
#include "shrm/brdf/adaptive_parameterization.hpp"
#include "shrm/brdf/angle_table.hpp"
#include "shrm/brdf/brdf_analysis.hpp"
#include "shrm/core.hpp"
#include "shrm/hierarchical/hierarchical.hpp"
#include "shrm/pictures/grid.hpp"
#include "shrm/pictures/layouts.hpp"
#include "shrm/reflection/explicit_maps.hpp"
#include "shrm/reflection/local_form.hpp"
#include "shrm/reflection/map_coefficients.hpp"
#include "shrm/reflection/radiance.hpp"
#include "shrm/reflection/view_map.hpp"
#include "shrm/sh/analysis.hpp"
#include "shrm/sh/cube_synthesis.hpp"
#include "shrm/sh/evaluation.hpp"
#include "shrm/sh/rotation.hpp"
#include "shrm/sh/synthesis.hpp"
#include "shrm/sh/wigner.hpp"
#include "shrm/transfer/lighting.hpp"
#include "shrm/transfer/tent_basis.hpp"

namespace {

using shrm::basis_size;

std::mt19937 generator(1);

template <class T>
std::vector<T> random_values(std::size_t count) {
    std::uniform_real_distribution<T> uniform(0, 1);
    std::vector<T> values(count);
    for (T& value : values) value = uniform(generator);
    return values;
}

std::vector<glm::dvec3> random_directions(std::size_t count) {
    std::normal_distribution<double> normal;
    std::vector<glm::dvec3> directions(count);
    for (glm::dvec3& w : directions)
        w = glm::normalize(glm::dvec3(normal(generator), normal(generator), normal(generator)));
    directions.front() = {0, 0, 1};
    directions.back() = {0, 0, -1};
    return directions;
}

constexpr std::size_t size(int n) {
    return static_cast<std::size_t>(n);
}

struct Extent {
    int H, W;
};
constexpr Extent extents[] = {{1, 1}, {1, 2}, {3, 5}, {5, 7}, {7, 16}, {16, 32}, {17, 33}};

// Every layout at its smallest sizes, into and out of a lat-long picture.
void pictures() {
    struct Named {
        const char* name;
        int height, width;
    };
    const Named pictures[] = {
        {"latlong", 2, 4},         {"latlong", 5, 9},          {"openexr-latlong", 3, 5},
        {"vertical-cross", 4, 3},  {"vertical-cross", 20, 15}, {"horizontal-cross", 9, 12},
        {"strip", 3, 18},          {"strip", 18, 3},           {"openexr-cube", 18, 3},
        {"angular", 2, 2},         {"angular", 7, 7},          {"mirror-ball", 5, 5},
        {"dual-paraboloid", 4, 8}, {"octahedral", 1, 1},       {"octahedral", 5, 5}};
    const shrm::Picture latlong{shrm::make_layout("latlong", 6, 11), 6, 11};
    const glm::dmat3 turn(0.8, 0.6, 0, -0.6, 0.8, 0, 0, 0, 1);
    for (const auto& [name, height, width] : pictures) {
        const shrm::Picture picture{shrm::make_layout(name, height, width), height, width};
        shrm::solid_angles(picture.layout, height, width);
        auto here = random_values<float>(size(height) * size(width) * 3);
        auto there = random_values<float>(size(6 * 11 * 3));
        shrm::Conversion(picture, latlong, turn).apply(here, 3, there);
        shrm::Conversion(latlong, picture, glm::dmat3(1)).apply(there, 3, here);
    }
}

void harmonics() {
    for (const auto [H, W] : extents)
        for (int channels : {1, 3, 4, 27})
            for (int F : {0, 1, 5}) {
                const auto pixels = random_values<float>(size(H) * size(W) * size(channels));
                std::vector<double> coefficients(basis_size(F) * size(channels));
                std::vector<float> rings(pixels.size());
                for (auto tables : {shrm::Tables::kept, shrm::Tables::transient}) {
                    for (auto texel : {shrm::Texel::sample, shrm::Texel::area}) {
                        shrm::Analysis analysis(H, W, channels, F, texel, tables);
                        for (int run = 0; run < 2; ++run) analysis.run(pixels, coefficients);
                    }
                    shrm::Synthesis synthesis(H, W, channels, F, tables);
                    for (int run = 0; run < 2; ++run) synthesis.run(coefficients, rings);
                }
                const int side = H + H % 2 + 2 * shrm::cube_border;
                std::vector<float> cube(size(6 * side) * size(channels) * size(side));
                shrm::CubeSynthesis(H + H % 2, channels, F).run(coefficients, cube);

                for (std::size_t n : {1u, 5u, 67u}) {
                    const auto directions = random_directions(n);
                    std::vector<double> values(n * size(channels));
                    shrm::evaluate(coefficients, channels, F, directions, values);
                }
            }

    // past the caches
    const int H = 64, W = 250, channels = 137;
    std::vector<float> rings(size(H * W * channels));
    shrm::Synthesis(H, W, channels, 1, shrm::Tables::transient)
        .run(random_values<double>(basis_size(1) * size(channels)), rings);
}

void rotation() {
    for (int F : {0, 1, 6, 40})
        for (const glm::dmat3& R : {glm::dmat3(1), glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1),
                                    glm::dmat3(0.8, 0.6, 0, 0, 0, 1, 0.6, -0.8, 0)}) {
            const auto coefficients = random_values<double>(basis_size(F) * 3);
            std::vector<double> rotated(coefficients.size());
            shrm::Rotation(F, 3).run(coefficients, R, rotated);
        }
}

void material_analysis() {
    for (int channels : {1, 3})
        for (const auto [L, Q] : {Extent{0, 0}, Extent{1, 1}, Extent{9, 4}}) {
            const int views = 3, I = 5, K = 7;
            const auto grid = size(views) * size(I);
            const auto rho_hat = random_values<double>(grid * size(K) * size(channels));
            const auto theta = random_values<double>(grid), theta_weight = random_values<double>(grid);
            const auto arc = random_values<double>(grid), share = random_values<double>(size(K)),
                       share_weight = random_values<double>(size(K));
            const auto gamma = random_values<double>(size(views)),
                       theta_v = random_values<double>(size(views));
            std::vector<double> wi(3 * grid * size(K)), wo(wi.size());
            shrm::directions({I, theta, arc, share}, theta_v, gamma, wi, wo);
            std::vector<double> g(size(channels) * size(Q + 1) * size(L + 1) * size(views));
            std::vector<double> energy(size(channels) * size(views));
            shrm::project({views, K, I, channels, rho_hat, theta, theta_weight, arc, share, share_weight}, L,
                          Q, g, energy);

            std::vector<double> values(size(L + 1) * theta.size());
            shrm::legendre(L, std::min(Q, L), theta, values);
        }
}

// Tables over pairs of directions with odd strides and counts, among them the poles and the horizon.
void measured_materials() {
    for (std::size_t n : {0, 1, 7, 8, 9, 700}) {
        std::vector<glm::dvec3> wi = random_directions(n + 2), wo = random_directions(n + 3);
        wo[n / 2] = {1, 0, 0};
        wi[n / 2] = -wo[n / 2];
        const shrm::DirectionPairs pairs{{&wi.back().x, -3, 1}, {&wo.front().x, 3, 1}, n};
        std::vector<double> values(3 * n);
        std::vector<std::int64_t> nodes(n);
        for (auto angles : {shrm::Angles::difference, shrm::Angles::half})
            for (bool centers : {false, true}) {
                const shrm::AngleAxes axes{angles, {2, 3, 4}, centers, centers};
                const auto grey = random_values<double>(2 * 3 * 4),
                           colors = random_values<double>(2 * 3 * 4 * 3);
                shrm::interpolate<double>(axes, 1, grey, pairs, std::span<double>(values).first(n));
                shrm::interpolate<double>(axes, 3, colors, pairs, values);
                shrm::nearest_nodes(axes, pairs, nodes);
            }
        for (int slices : {1, 2, 5}) {
            const auto theta_i = slices == 5 ? std::vector{0., 0.3, 0.5, 1.2, 1.5} : std::vector{0.2, 1.};
            const auto vndf = random_values<float>(size(slices) * 3 * 4);
            const auto samples = random_values<float>(size(slices) * 2 * 5 * 3),
                       ndf = random_values<float>(6);
            for (bool has_ndf : {false, true}) {
                const shrm::AdaptiveParameterization table(
                    std::span<const double>(theta_i).first(size(slices)), vndf, {3, 4}, samples, {2, 5},
                    std::span<const float>(ndf).first(has_ndf ? 6 : 0), {2, 3}, ndf);
                table.evaluate(pairs, values);
                table.samples(pairs, values);
            }
        }
    }
}

void reflection_maps() {
    for (const auto [F, P] : {Extent{0, 0}, Extent{3, 0}, Extent{2, 3}, Extent{7, 2}})
        for (const auto [H, W] : extents) {
            const int channels = 3;
            const auto light = random_values<double>(basis_size(F) * size(channels));
            const auto rho = random_values<double>(size(F + 1) * size(P + 1) * size(P + 1) * size(channels));
            std::vector<float> local(size(H) * size(W) * basis_size(P) * size(channels)),
                global(local.size());
            shrm::local_reflection_map(light, rho, F, P, channels, H, W, local);
            shrm::global_from_local(local, P, channels, H, W, global);
            std::vector<double> coefficients(basis_size(F + P) * basis_size(P) * size(channels));
            for (bool zonal : {false, true}) {
                shrm::MapCoefficients map(F, P, channels, zonal);
                map.set_material(rho);
                map.run(light, coefficients);
            }
        }
}

void radiance() {
    const auto gamma = random_values<double>(257);
    const auto normals = random_directions(33), views = random_directions(33);
    for (const auto layout : {shrm::MapLayout::latlong, shrm::MapLayout::cube})
        for (const auto [N, P] : {Extent{1, 0}, Extent{3, 1}, Extent{4, 3}})
            for (bool zonal : {false, true})
                for (bool bilinear : {false, true}) {
                    const bool cube = layout == shrm::MapLayout::cube;
                    const int H = cube ? 6 * (N + 2 * shrm::cube_border) : N;
                    const int W = cube ? N + 2 * shrm::cube_border : 2 * N;
                    shrm::ReflectionMapView map{layout, H, W, W, P, zonal, {}, {}};
                    const auto rings = random_values<float>(size(H) * size(map.maps()) * 3 * size(W));
                    map.rings = rings;
                    std::vector<float> values(normals.size() * 3), pixels(size(H) * size(W) * 3);
                    for (auto center : {shrm::Center::reflection, shrm::Center::normal, shrm::Center::tangent,
                                        shrm::Center::lobe}) {
                        shrm::add_radiance(map, center, gamma, normals, views, bilinear, values);
                        shrm::add_radiance(map, center, gamma, normals, std::span(views).first(1), bilinear,
                                           values);
                    }
                    shrm::add_looked_up(map, normals, views, bilinear, values);
                    shrm::view_map(map, views[1], pixels);
                    if (!zonal) {
                        std::vector<float> many(2 * 2 * pixels.size());
                        shrm::explicit_maps(map, 2, many);
                    }
                    shrm::largest_magnitude(rings);
                    map.rings = {};
                    map.pitch = W + 3;
                    std::vector<std::uint16_t> halves(rings.size() / size(W) * size(map.pitch));
                    shrm::to_half(rings, W, halves.data(), map.pitch);
                    map.halves = halves;
                    shrm::view_map(map, views[1], pixels);
                    shrm::add_radiance(map, shrm::Center::normal, gamma, normals, views, bilinear, values);
                }
}

void integrators() {
    namespace angular = shrm::angular;
    const int nodes = 5;
    const auto axes = random_directions(9);
    std::vector<glm::dvec3> views(axes.size());
    for (std::size_t k = 0; k < axes.size(); ++k) {
        const double side = glm::dot(axes[k], axes[(k + 1) % axes.size()]) < 0 ? -1 : 1;
        views[k] = glm::normalize(axes[k] + 0.9 * side * axes[(k + 1) % axes.size()]);
    }
    for (const auto [H, W] : {Extent{1, 1}, Extent{2, 4}, Extent{7, 13}, Extent{16, 32}})
        for (int channels : {1, 3})
            for (int subsamples : {1, 2}) {
                const auto planes = random_values<float>(3 * size(H) * size(angular::row_length(W)));
                const angular::Picture picture{planes, H, W, subsamples};
                std::vector<float> out(axes.size() * 3);
                const std::vector<angular::Cap> caps(size(3), {0.2, 1.6});

                for (int segments : {32, 64}) {  // held in registers, looked up
                    const auto values = random_values<float>(size(channels * 4 * segments));
                    const angular::RadialProfile profile{values, channels, segments, 21, 100, 2.5};
                    for (double outer : {0.3, shrm::pi}) {
                        angular::integrate_radial(picture, profile, outer, axes, out);
                        const shrm::Pyramid pyramid(random_values<float>(size(H) * size(W) * 3), H, W);
                        for (double threshold : {0., 0.1})
                            shrm::hierarchical::integrate_radial(pyramid, profile, outer, {threshold, 1, 0.2},
                                                                 axes, out);
                        for (int map_W : {5, 8})
                            for (bool symmetry : {false, true}) {
                                std::vector<float> map(size(3 * map_W * 3));
                                angular::integrate_radial_map(picture, profile, outer, 3, map_W, symmetry,
                                                              map);
                            }
                    }
                    if (channels == 3) continue;
                    angular::integrate_half_angle(picture, profile, caps, axes, views, false, out);
                    const std::vector<glm::dvec3> one_view(axes.size(), views[1]);
                    angular::integrate_half_angle(picture, profile, caps, axes, one_view, true, out);
                }

                const auto zonal = random_values<float>(size(3 * channels * (nodes + 2)));
                const std::vector<angular::Band> bands{{0, 1}, {0.5, 2}, {0, shrm::pi}};
                const std::vector<double> theta_o{0, 0.1, 0.7, 1.2, 1.6, 2, 2.5, 3, shrm::pi};
                angular::integrate_zonal(picture, {zonal, bands, 3, channels, nodes}, axes, theta_o, out);
                const shrm::Pyramid pyramid(random_values<float>(size(H) * size(W) * 3), H, W);
                for (double threshold : {0., 0.1})
                    shrm::hierarchical::integrate_zonal(pyramid, {zonal, bands, 3, channels, nodes}, bands,
                                                        {threshold, 1, 0.2}, axes, theta_o, out);

                const auto envelope = random_values<float>(size(nodes + 2));
                const auto ratio =
                    random_values<float>(size(3) * size(channels) * size((nodes + 2) * (nodes + 2)));
                angular::integrate_isotropic(
                    picture, {envelope, ratio, caps, channels, nodes, 2, nodes, nodes}, axes, views, out);
                for (const shrm::hierarchical::Heights& heights :
                     {shrm::hierarchical::Heights{}, shrm::hierarchical::Heights{0.1, 2}})
                    shrm::hierarchical::integrate_isotropic(
                        pyramid, {envelope, ratio, caps, channels, nodes, 2, nodes, nodes}, heights,
                        {0.1, 1, 0.2}, axes, views, out);
            }
}

void tent_basis() {
    for (int M : {2, 3, 8})
        for (int channels : {1, 3, 25}) {
            auto directions = random_directions(33);
            for (double u : {0., 0.5, 1.})
                for (double v : {0., 0.5, 1.}) directions.push_back(shrm::hemisphere_from_square({u, v}));
            const auto coefficients = random_values<double>(size(M * M * channels));
            std::vector<double> values(directions.size() * size(channels)), sums(coefficients.size());
            shrm::evaluate_tents(coefficients, channels, M, directions, values);
            shrm::accumulate_tents(values, channels, M, directions, sums);
        }
}

// Turns by quarters, and one about no axis.
std::vector<float> frames(int vertices) {
    const float turns[][9] = {{1, 0, 0, 0, 1, 0, 0, 0, 1},
                              {0, 0, 1, 1, 0, 0, 0, 1, 0},
                              {0.36f, 0.48f, -0.8f, -0.8f, 0.6f, 0, 0.48f, 0.64f, 0.6f}};
    std::vector<float> values;
    for (int p = 0; p < vertices; ++p) values.insert(values.end(), turns[p % 3], turns[p % 3] + 9);
    return values;
}

// Values once as floats, once as halves from 0 to 1.
template <class Light>
void for_floats_and_halves(std::size_t count, Light&& light) {
    const auto floats = random_values<float>(count);
    light(shrm::TransferValues{floats, {}});
    std::vector<std::uint16_t> halves(count);
    for (std::uint16_t& value : halves) value = static_cast<std::uint16_t>(generator() % 0x3c00);
    light(shrm::TransferValues{{}, halves});
}

void transfer_lighting() {
    struct {
        int vertices, n;
    } const sizes[] = {{1, 1}, {131, 1}, {63, 2}, {64, 3}, {131, 5}, {5, 10}};
    for (const auto [vertices, n] : sizes)
        for (int channels : {1, 3}) {
            const auto V = size(vertices), terms = size(n * n), C = size(channels);
            const auto points = random_values<float>(3 * V), light = random_values<float>(3 * terms);
            const shrm::TransferSurface surface(points, frames(vertices));
            std::vector<float> radiance(3 * V);
            const shrm::Eye near{{points[0], points[1], points[2]}, false}, far{{0, 0.6f, -0.8f}, true};

            for_floats_and_halves(V * C * terms, [&](const shrm::TransferValues& rows) {
                shrm::light_rows(rows, vertices, channels, light, radiance);
            });
            for (int M : {2, 5}) {
                const auto tents = size(M * M);
                for_floats_and_halves(V * tents * C * terms, [&](const shrm::TransferValues& matrices) {
                    shrm::light_tents(surface, matrices, M, channels, light, near, radiance);
                });
                const auto coefficients = random_values<float>(V * tents * 3);
                shrm::light_fixed_tents(surface, coefficients, M, far, radiance);
                std::vector<std::int32_t> clusters(V);
                for (std::size_t p = 0; p < V; ++p) clusters[p] = static_cast<std::int32_t>(p % 3);
                const auto components = random_values<float>(3 * 6 * tents * C * terms);
                for (int K : {1, 6})
                    for_floats_and_halves(V * 6, [&](const shrm::TransferValues& weights) {
                        shrm::CompressedTransfer(weights, clusters, components, vertices, 3, 6, K, M,
                                                 channels, n * n)
                            .light(surface, light, near, radiance);
                    });
            }

            std::size_t bands = 0;
            for (int l = 0; l < n; ++l) bands += size((2 * l + 1) * (2 * l + 1));
            const auto rotations = random_values<float>(V * bands + size(shrm::rotation_room));
            const auto samples = random_values<float>(9 * C * terms);
            const auto kernel = random_values<float>(size(n) * C);
            const auto earlier = [&](const shrm::TransferValues& transfer) {
                for (bool either : {false, true}) {
                    shrm::light_projected(surface, samples, 3, either, channels, rotations, transfer, light,
                                          near, radiance);
                    shrm::light_projected(surface, samples, 3, either, channels, {}, transfer, light, far,
                                          radiance);
                    shrm::light_convolved(surface, kernel, channels, either, transfer, light, near, radiance);
                }
            };
            for_floats_and_halves(V * terms * terms, earlier);
            earlier({});
        }
}

}  // namespace

int main() {
    pictures();
    harmonics();
    rotation();
    material_analysis();
    measured_materials();
    reflection_maps();
    radiance();
    integrators();
    tent_basis();
    transfer_lighting();
    std::puts("sanitize: done");
}
