// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/pages/paged_scene.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs::pages {

/// Gaussians of leaves, or nodes that stand for some.
struct Nodes {
  Scene scene;
  /// Mean square distance of the Gaussians' means from the node's, weighted by what each shows.
  /// @units{scene^2}
  std::vector<float> spread;
};

/// The axis along which most of the means spread farthest. The outermost do not count, so that strays do not
/// decide.
int longest_axis(std::vector<vec3> means);

/// Puts `order`, some of `means`, in the order of a kd tree: halves at a multiple of `page` where that leaves
/// both some, else at a multiple of `least`, down to `least`. Ties keep the order of indices, and the result
/// does not depend on `threads`.
void order_by_halves(const std::vector<vec3>& means, std::span<std::uint32_t> order, std::size_t page,
                     std::size_t least, int threads);

/// Merges the nodes of `left` and `right` to half as many, rounded up. Neighbours merge in the order in which
/// the picture changes least. Harmonics are rounded to halves, since nobody trained these Gaussians. The
/// result does not depend on `threads`.
Nodes merge(const Nodes& left, const Nodes& right, int threads);

/// Sets `finest` and `errors` of a page by its nodes.
void set_errors(Page& page, const Nodes& nodes);

/// How much a Gaussian of opacity 1 and these standard deviations shows: its projection's area but for a
/// factor, averaged over directions.
template <class Vector>
double shown_area(const Vector& scale) {
  return double(scale.x) * double(scale.y) + double(scale.y) * double(scale.z) +
         double(scale.z) * double(scale.x);
}

}  // namespace swiftgs::pages
