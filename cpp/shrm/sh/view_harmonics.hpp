// The basis of the view at one direction: all Y_pq of a global map, or all Y_p0 of a zonal one.
#pragma once

#include <numbers>
#include <type_traits>

#include "shrm/core.hpp"
#include "shrm/sh/legendre.hpp"

namespace shrm {

inline constexpr int largest_P = 24;

// Serves every P: the constants do not depend on the last degree.
inline const LegendreRecurrence& view_recurrence() {
    static const LegendreRecurrence recurrence(largest_P);
    return recurrence;
}

// float or double, of a number or a vector of them.
template <class Value>
inline auto scalar_of(const Value& value) {
    if constexpr (std::is_arithmetic_v<Value>)
        return value;
    else
        return value[0];
}

// Y_pq(direction), real basis, for all p <= P: f_pq is sin^q times a polynomial in z, and
// sin^q e^{i q phi} = (x + i y)^q. Value is a number or a vector of them; of floats the degree should be low.
template <class Vector, class Value>
inline void real_harmonics(int P, const Vector& direction, Value* Y) {
    using Scalar = decltype(scalar_of(Value{}));
    const LegendreRecurrence& recurrence = view_recurrence();
    Value cosine_q = std::numbers::sqrt2_v<Scalar> + Value{}, sine_q{};
    for (int q = 0; q <= P; ++q) {
        Value f = static_cast<Scalar>(recurrence.start(q)) + Value{}, previous{};
        for (int p = q; p <= P; ++p) {
            Y[lm(p, q)] = q ? f * cosine_q : f;
            if (q) Y[lm(p, -q)] = f * sine_q;
            const auto [a, b] = recurrence.steps(q)[p - q];
            const Value next = static_cast<Scalar>(a) * direction.z * f - static_cast<Scalar>(b) * previous;
            previous = f;
            f = next;
        }
        const Value turned = cosine_q * direction.x - sine_q * direction.y;
        sine_q = sine_q * direction.x + cosine_q * direction.y;
        cosine_q = turned;
    }
}

// Y_p0 for all p <= P at the angle between C and V whose cosine is given: Y (P+1).
template <class Value>
inline void zonal_harmonics(int P, const Value& cosine, Value* Y) {
    const LegendreRecurrence& recurrence = view_recurrence();
    Value f = recurrence.start(0) + Value{}, previous{};
    for (int p = 0; p <= P; ++p) {
        Y[p] = f;
        const auto [a, b] = recurrence.steps(0)[p];
        const Value next = a * cosine * f - b * previous;
        previous = f;
        f = next;
    }
}

}  // namespace shrm
