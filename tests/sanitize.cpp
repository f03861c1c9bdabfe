// Every stage of the core on small and odd sizes, built and run under ASan and UBSan by
// test_sanitizers.py. Values are the business of the Python tests; here memory and undefined
// behaviour are watched, so a stage needs just a few calls whose sizes are awkward.
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include <glm/glm.hpp>

#include "shrm/brdf_analysis.hpp"
#include "shrm/core.hpp"
#include "shrm/reflection_map.hpp"
#include "shrm/sh.hpp"
#include "shrm/wigner.hpp"

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

void harmonics() {
    for (const auto [H, W] : extents)
        for (int channels : {1, 3, 4})
            for (int F : {0, 1, 5}) {
                const auto pixels = random_values<float>(size(H) * size(W) * size(channels));
                std::vector<double> coefficients(basis_size(F) * size(channels));
                for (auto texel : {shrm::Texel::sample, shrm::Texel::area})
                    shrm::analysis(pixels, H, W, channels, F, texel, coefficients);
                std::vector<float> rings(pixels.size());
                shrm::synthesis(coefficients, channels, F, H, W, rings);

                for (std::size_t n : {1u, 5u, 67u}) {
                    const auto directions = random_directions(n);
                    std::vector<double> values(n * size(channels));
                    shrm::evaluate<double>(coefficients, channels, F, directions, values);
                }
            }
}

void rotation() {
    for (int F : {0, 1, 6, 40})
        for (const glm::dmat3& R : {glm::dmat3(1), glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1),
                                    glm::dmat3(0.8, 0.6, 0, 0, 0, 1, 0.6, -0.8, 0)}) {
            const auto coefficients = random_values<double>(basis_size(F) * 3);
            std::vector<double> rotated(coefficients.size());
            shrm::rotate(coefficients, 3, F, R, rotated);
        }
}

void material_analysis() {
    for (int channels : {1, 3})
        for (const auto [L, Q] : {Extent{0, 0}, Extent{1, 1}, Extent{9, 4}}) {
            const int views = 3, I = 5, K = 7;
            const auto grid = size(views) * size(I);
            const auto rho_hat = random_values<double>(grid * size(K) * size(channels));
            const auto theta = random_values<double>(grid), theta_weight = random_values<double>(grid);
            const auto phi = random_values<double>(grid * size(K)),
                       phi_weight = random_values<double>(grid * size(K));
            std::vector<double> g(size(channels) * size(Q + 1) * size(L + 1) * size(views));
            std::vector<double> energy(size(channels) * size(views));
            shrm::project({views, I, K, channels, rho_hat, theta, theta_weight, phi, phi_weight}, L, Q, g,
                          energy);

            std::vector<double> values(size(L + 1) * theta.size());
            shrm::legendre(L, std::min(Q, L), theta, values);
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
            shrm::global_coefficients(light, rho, F, P, channels, coefficients);
        }
}

}  // namespace

int main() {
    harmonics();
    rotation();
    material_analysis();
    reflection_maps();
    std::puts("sanitize: done");
}
