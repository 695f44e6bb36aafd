// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How much each Gaussian adds to frames of a backend that is chosen at run time, and which ones
/// score highest. `subset` makes a smaller scene of them.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>
#include <string_view>
#include <utility>
#include <vector>

#include <swiftgs/contribution.hpp>
#include <swiftgs/edit/select.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

/// `Contributions` on a backend that is chosen at run time.
class SWIFTGS_API AnyContributions {
 public:
  virtual ~AnyContributions() = default;
  /// As `Contributions::add`.
  virtual void add(const Camera& camera, const Conventions& conventions) = 0;
  /// As `Contributions::sums`.
  virtual std::vector<std::uint64_t> sums() const = 0;
};

/// `AnyContributions` on backend `B`.
template <BackendPolicy B>
class ContributionsOn final : public AnyContributions {
 public:
  explicit ContributionsOn(std::shared_ptr<const Scene> scene) : contributions_(std::move(scene)) {}
  void add(const Camera& camera, const Conventions& conventions) override {
    contributions_.add(camera, conventions);
  }
  std::vector<std::uint64_t> sums() const override { return contributions_.sums(); }

 private:
  Contributions<B> contributions_;
};

/// One row of the table of backends with contributions.
struct ContributionsEntry {
  std::string_view backend;  ///< its `name`
  bool usable = false;       ///< whether it can run on this machine

  /// Makes sums of a scene, all 0. Throws as `Contributions`.
  std::unique_ptr<AnyContributions> (*make)(std::shared_ptr<const Scene>) = nullptr;
};

/// Every backend of this build, whether or not it can run here, the preferred first. Defined in the library
/// that joins the backends.
SWIFTGS_API const std::vector<ContributionsEntry>& contribution_backends();

/// The row called `backend`; if that is empty, the first row that can run here. Throws
/// `InvalidArgument` with the valid words if the backend is not known, and `Unavailable` if it
/// cannot run here.
SWIFTGS_API const ContributionsEntry& contribution_backend(std::string_view backend);

/// Opacity times the product of the three scales: a score that needs no view. @shape{Gaussians}
inline std::vector<double> opacity_volumes(const Scene& scene) {
  validate(scene);
  std::vector<double> scores(scene.size());
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const vec3 s = scene.scales[i];
    scores[i] = double(scene.opacities[i]) * double(s.x) * double(s.y) * double(s.z);
  }
  return scores;
}

/// `fraction` of `count` Gaussians, rounded: at least one if `count` is at least one. Throws
/// `InvalidArgument` unless the fraction is above 0 and at most 1.
inline std::size_t kept_count(double fraction, std::size_t count) {
  if (!(fraction > 0 && fraction <= 1))
    detail::refuse("pruning: expected a fraction above 0 and at most 1, got ", fraction);
  const std::size_t kept = std::size_t(std::llround(fraction * double(count)));
  return count == 0 ? 0 : std::clamp<std::size_t>(kept, 1, count);
}

/// Indices of the `count` highest of `scores`, ascending; of equal scores the lower index comes first. No
/// score may be NaN. Throws `InvalidArgument` where there are fewer scores, and `CapacityError` beyond
/// 2^32 - 1 of them.
template <class Score>
std::vector<std::uint32_t> highest(const std::vector<Score>& scores, std::size_t count) {
  const std::size_t most = std::numeric_limits<std::uint32_t>::max();
  if (scores.size() > most) throw CapacityError("Gaussians", scores.size(), most);
  if (count > scores.size())
    detail::refuse("pruning: expected at most ", scores.size(), " Gaussians to keep, got ", count);
  std::vector<std::uint32_t> order(scores.size());
  std::iota(order.begin(), order.end(), 0u);
  std::nth_element(order.begin(), order.begin() + std::ptrdiff_t(count), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     return scores[a] != scores[b] ? scores[a] > scores[b] : a < b;
                   });
  order.resize(count);
  std::sort(order.begin(), order.end());
  return order;
}

}  // namespace swiftgs
