// The frame of a normal and a view, and the cap of lights about a lobe that is cut at the horizon of the
// normal. Private to angular.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include <glm/geometric.hpp>

#include "shrm/angular/angular.hpp"

namespace shrm::angular {

// The view in the plane of x and the normal.
struct LocalFrame {
    glm::dvec3 x, y, n;
    double cos_v;

    LocalFrame(const glm::dvec3& normal, const glm::dvec3& view)
        : n(normal), cos_v(std::clamp(glm::dot(normal, view), 0.0, 1.0)) {
        const glm::dvec3 across = view - glm::dot(n, view) * n;
        const glm::dvec3 other = std::abs(n.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
        x = glm::length(across) > 1e-9 ? glm::normalize(across) : glm::normalize(glm::cross(n, other));
        y = glm::cross(n, x);
    }
};

// Between which of n + 1 view nodes a view lies, and where.
struct ViewPlace {
    int from;
    double t;

    ViewPlace(double cos_v, int n) {
        const double place = n * (1 - std::sqrt(std::asin(cos_v) * 2 / pi));
        from = std::min(static_cast<int>(place), n - 1);
        t = place - from;
    }
};

// The cap that a query visits: the lobe's or the hemisphere, whichever is smaller.
struct Visit {
    glm::dvec3 axis;
    double outer;

    Visit(const LocalFrame& frame, const ViewPlace& place, std::span<const Cap> caps) {
        const Cap& low = caps[size(place.from)];
        const Cap& high = caps[size(place.from) + 1];
        const double offset = low.center + place.t * (high.center - low.center);
        outer = std::max(low.outer, high.outer);
        axis = std::cos(offset) * frame.n - std::sin(offset) * frame.x;
        if (outer >= pi / 2) {
            outer = pi / 2;
            axis = frame.n;
        }
    }
};

}  // namespace shrm::angular
