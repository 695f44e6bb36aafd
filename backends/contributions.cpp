// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/any_contributions.hpp>
#include <swiftgs/message.hpp>
#include <swiftgs/serial.hpp>

#if defined(SWIFTGS_HAS_CPU)
#include <swiftgs/cpu.hpp>
#endif
#if defined(SWIFTGS_HAS_CUDA)
#include <swiftgs/cuda.hpp>
#endif

namespace swiftgs {
namespace {

template <class B>
ContributionsEntry entry_of() {
  return {B::name, B::usable(), [](std::shared_ptr<const Scene> scene) -> std::unique_ptr<AnyContributions> {
            return std::make_unique<ContributionsOn<B>>(std::move(scene));
          }};
}

}  // namespace

const std::vector<ContributionsEntry>& contribution_backends() {
  static const std::vector<ContributionsEntry> table {
#if defined(SWIFTGS_HAS_CUDA)
    entry_of<Cuda>(),
#endif
#if defined(SWIFTGS_HAS_CPU)
        entry_of<Cpu>(),
#endif
        entry_of<Serial>()
  };
  return table;
}

const ContributionsEntry& contribution_backend(std::string_view backend) {
  std::string names;
  for (const ContributionsEntry& entry : contribution_backends()) {
    if (entry.backend == backend && !entry.usable)
      throw Unavailable("backend '" + std::string(backend) + "' cannot run on this machine");
    if (entry.backend == backend || (backend.empty() && entry.usable)) return entry;
    names += (names.empty() ? "" : ", ") + std::string(entry.backend);
  }
#if !defined(SWIFTGS_HAS_CUDA)
  if (backend == "cuda") throw InvalidArgument("backend 'cuda': the library was built without CUDA");
#endif
  detail::refuse("backend '", backend, "' is not known; expected ", names);
}

}  // namespace swiftgs
