// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include <swiftgs/api.hpp>
#include <swiftgs/contribution.hpp>

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
template <FunctorBackend B>
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

}  // namespace swiftgs
