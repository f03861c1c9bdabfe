// The basis of the view at one direction: all Y_pq of a global map, or all Y_p0 of a zonal one.
#pragma once

#include <cmath>

#include <glm/vec3.hpp>

#include "shrm/core.hpp"
#include "shrm/legendre.hpp"

namespace shrm {

inline constexpr int largest_P = 24;

// Serves every P: the constants do not depend on the last degree.
inline const LegendreRecurrence& view_recurrence() {
    static const LegendreRecurrence recurrence(largest_P);
    return recurrence;
}

// Y_pq(direction), real basis, for all p <= P.
inline void real_harmonics(int P, const glm::dvec3& direction, double* Y) {
    const LegendreRecurrence& recurrence = view_recurrence();
    const double sine = std::hypot(direction.x, direction.y);
    const double cos1 = sine > 0 ? direction.x / sine : 1, sin1 = sine > 0 ? direction.y / sine : 0;
    double cosine_q = std::numbers::sqrt2, sine_q = 0;
    for (int q = 0; q <= P; ++q) {
        double f = recurrence.start(q) * power(sine, q), previous = 0;
        for (int p = q; p <= P; ++p) {
            Y[lm(p, q)] = q ? f * cosine_q : f;
            if (q) Y[lm(p, -q)] = f * sine_q;
            const auto [a, b] = recurrence.steps(q)[p - q];
            const double next = a * direction.z * f - b * previous;
            previous = f;
            f = next;
        }
        const double turned = cosine_q * cos1 - sine_q * sin1;
        sine_q = sine_q * cos1 + cosine_q * sin1;
        cosine_q = turned;
    }
}

// Y_p0 at the angle between C and V.
inline void zonal_harmonics(int P, double cosine, double* Y) {
    const LegendreRecurrence& recurrence = view_recurrence();
    double f = recurrence.start(0), previous = 0;
    for (int p = 0; p <= P; ++p) {
        Y[p] = f;
        const auto [a, b] = recurrence.steps(0)[p];
        const double next = a * cosine * f - b * previous;
        previous = f;
        f = next;
    }
}

}  // namespace shrm
