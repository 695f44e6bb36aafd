// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/drivers/renderer_table.hpp>
#include <swiftgs/edit/pruning.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/serial.hpp>
#include <swiftgs/swiftgs.hpp>
#include <swiftgs/tools/processor.hpp>
#if defined(SWIFTGS_HAS_CPU)
#include <swiftgs/cpu.hpp>
#endif
#if defined(SWIFTGS_HAS_CUDA)
#include <swiftgs/cuda.hpp>
#endif
#if defined(SWIFTGS_HAS_VULKAN)
#include <swiftgs/vulkan.hpp>
#endif

namespace swiftgs {
namespace {

/// What the library was built without, if `name` or its first word is a backend that needs it; else empty.
std::string_view lacking_for([[maybe_unused]] std::string_view name) {
#if !defined(SWIFTGS_HAS_CUDA)
  if (name.substr(0, name.find('/')) == "cuda") return "CUDA";
#endif
#if !defined(SWIFTGS_HAS_VULKAN)
  if (name.substr(0, name.find('/')) == "vulkan") return "Vulkan";
#endif
  return {};
}

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
#if defined(SWIFTGS_HAS_VULKAN)
        entry_of<Vulkan>(),
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
  if (const std::string_view lacking = lacking_for(backend); !lacking.empty())
    detail::refuse("backend '", backend, "': the library was built without ", lacking);
  detail::refuse("backend '", backend, "' is not known; expected ", names);
}

namespace {

std::vector<RendererEntry> all_renderers() {
  std::vector<RendererEntry> table;
  append_renderers<Serial>(table, AllSorts{}, AllRasters{}, AllBounds{});
#if defined(SWIFTGS_HAS_VULKAN)
  append_renderers<Vulkan>(table, AllSorts{}, AllRasters{}, AllBounds{});
#endif
#if defined(SWIFTGS_HAS_CPU)
  append_renderers<Cpu>(table, AllSorts{}, AllRasters{}, AllBounds{});
#endif
#if defined(SWIFTGS_HAS_CUDA)
  append_renderers<Cuda>(table, AllSorts{}, AllRasters{}, AllBounds{});
#endif
  return table;
}

/// The words that stand at position `part` of the names in the table, each once.
std::string words_at(int part) {
  std::vector<std::string_view> words;
  for (const RendererEntry& entry : renderers()) {
    std::string_view rest = entry.name;
    for (int i = 0; i < part; ++i) rest.remove_prefix(rest.find('/') + 1);
    const std::string_view word = rest.substr(0, rest.find('/'));
    if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(word);
  }
  std::string joined;
  for (const std::string_view word : words) joined += (joined.empty() ? "" : ", ") + std::string(word);
  return joined;
}

/// Whether `entry` is the usual renderer of `backend`; of any that can run here, where that is empty.
bool is_usual(const RendererEntry& entry, std::string_view backend) {
  const std::string_view policies = Renderer<Serial>::name.substr(Serial::name.size());
  return entry.name.ends_with(policies) &&
         (backend.empty() ? entry.usable : entry.name == std::string(backend).append(policies));
}

InvalidArgument unknown(std::string_view name, const std::string& alternative) {
  const std::string begin = "renderer '" + std::string(name) + "'";
  if (const std::string_view lacking = lacking_for(name); !lacking.empty())
    return InvalidArgument(begin + ": the library was built without " + std::string(lacking));
  return InvalidArgument(begin + " is not known; expected " + alternative +
                         "BACKEND/SORT/RASTER/BOUNDS with BACKEND of " + words_at(0) + "; SORT of " +
                         words_at(1) + "; RASTER of " + words_at(2) + "; BOUNDS of " + words_at(3));
}

}  // namespace

const std::vector<RendererEntry>& renderers() {
  static const std::vector<RendererEntry> table = all_renderers();
  return table;
}

const RendererEntry& find_renderer(std::string_view name) {
  const RendererEntry* best = nullptr;  // the table lists backends from the simplest to the quickest
  for (const RendererEntry& entry : renderers()) {
    if (entry.name == name) return entry;
    if (is_usual(entry, name)) best = &entry;
  }
  if (best) return *best;
  throw unknown(name, "a BACKEND or ");
}

std::unique_ptr<AnyRenderer> make_renderer(std::string_view name, const BackendOptions& options) {
  require_thread_count(options.threads);
  for (const RendererEntry& entry : renderers()) {
    if (entry.name != name) continue;
    if (!entry.usable) throw Unavailable("renderer '" + std::string(name) + "' cannot run on this machine");
    return entry.make(options);
  }
  throw unknown(name, "");
}

}  // namespace swiftgs
