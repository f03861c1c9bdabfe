// hierarchical: prefiltering by descent in a pyramid of the environment [KVHS00 section 5.1]. A judge and a
// rival like angular: it shares nothing with the frequency-space path.
//
// For a target a lobe is compared between a node of the pyramid and its four children: where the difference,
// weighted by the children's power, is below a threshold, the children stand for all below them; elsewhere
// each of them is entered. Lobes are the tables of angular.hpp.
#pragma once

#include <limits>
#include <span>

#include <glm/vec3.hpp>

#include "shrm/angular/angular.hpp"
#include "shrm/hierarchical/pyramid.hpp"

namespace shrm::hierarchical {

// Targets that descend together, and best lie close together: as many as the widest vectors have lanes.
inline constexpr int block = angular::most_lanes;

// The depth of a descent. A node is split while its children's kernels, weighted by their brightness, differ
// from its own by more than `threshold` times the mean over all targets: the `integral` of the lobe by the
// picture's mean brightness. Where a lobe could hide between samples, nodes are split down to `finest`
// radians whatever their kernels are. At threshold 0 every texel is visited that the lobe reaches.
struct Descent {
    double threshold;
    double integral;
    double finest;
};

// A lobe between two heights: u m / (above + m), then u below / (below + m), with m the mean over the
// channels of what is there. With 0 and infinity it is the lobe itself.
struct Heights {
    double above = 0;
    double below = std::numeric_limits<double>::infinity();
};

// The work of a descent: evaluations of the kernel for each target.
struct Effort {
    double evaluations;
};

// Reflected radiance for each center of a radial lobe, which could hide within `outer` of it: out
// [target][3].
Effort integrate_radial(const Pyramid& pyramid, const angular::RadialProfile& profile, double outer,
                        const Descent& descent, std::span<const glm::dvec3> centers, std::span<float> out);

// The same for each axis, the view at theta_o, in radians, from it. The lobe could hide within the profiles'
// bands, and is negligible outside of `supports`, one for each row too.
Effort integrate_zonal(const Pyramid& pyramid, const angular::ZonalProfiles& profiles,
                       std::span<const angular::Band> supports, const Descent& descent,
                       std::span<const glm::dvec3> axes, std::span<const double> theta_o,
                       std::span<float> out);

// The same for each normal and view, the view above the normal's horizon, of what lies between heights. It
// could hide within the table's caps. The table may have an envelope for each channel, one after the other.
Effort integrate_isotropic(const Pyramid& pyramid, const angular::IsotropicTable& table,
                           const Heights& heights, const Descent& descent,
                           std::span<const glm::dvec3> normals, std::span<const glm::dvec3> views,
                           std::span<float> out);

}  // namespace shrm::hierarchical
