// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string_view>

#include "scene_format.hpp"
#include "watched_read.hpp"

namespace {

using namespace swiftgs;

/// Of the program of this name. One object serves them all, as it takes longer to compile than to link.
struct Target {
  std::string_view program;
  const io::SceneFormat* format;
  test::MemoryFactor memory;
};

constexpr Target targets[] = {
    {"fuzz_gltf", &io::gltf_format, test::gltf_spz_memory},
    {"fuzz_ksplat", &io::ksplat_format, test::ksplat_memory},
    {"fuzz_ply", &io::ply_format, test::ply_memory},
    {"fuzz_splat", &io::splat_format, test::splat_memory},
};
const Target* target = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char*** arguments) {
  for (const Target& each : targets)
    if (std::string_view((*arguments)[0]).ends_with(each.program)) target = &each;
  if (!target) std::abort();
  return 0;
}

/// Any bytes are a scene or a `FormatError`. No other file is opened.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  fuzz::read_watched(bytes, target->memory, [&](const auto& options) {
    return target->format->read({bytes, "fuzz"}, options);
  });
  return 0;
}
