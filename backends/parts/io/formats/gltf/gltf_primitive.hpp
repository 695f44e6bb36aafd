// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <swiftgs/scene.hpp>

#include "gltf_document.hpp"
#include "mapped_file.hpp"
#include "scene_building.hpp"
#include "tasks.hpp"

namespace swiftgs::io {

/// The bytes that a glTF file's accessors lie in. A buffer is opened or decoded when it is first asked for.
/// Each function throws `FormatError` for an index or a range that does not exist; `user` is what asks.
class GltfBuffers {
 public:
  struct View {
    std::span<const std::byte> bytes;
    std::uint64_t stride;  ///< 0: elements lie back to back
  };

  /// `progress` is told of the part of the file that was decoded.
  GltfBuffers(const GltfDocument& document, const ProgressMeter& progress)
      : document_(document), progress_(progress) {}

  View view(std::uint64_t index, const JsonEntry& user);

  /// Bytes of all buffers that were asked for; those of a file that several name count once.
  std::uint64_t size() const { return size_; }

  /// Bytes of other files that were opened.
  std::uint64_t size_beside() const { return size_beside_; }

  bool has_decoded() const { return !decoded_.empty(); }

 private:
  std::span<const std::byte> buffer(std::uint64_t index, const JsonEntry& user);
  std::span<const std::byte> open(std::uint64_t index, const JsonEntry& entry);
  std::span<const std::byte> decode(const GltfDocument::DataUri& uri);
  std::span<const std::byte> counted(std::span<const std::byte> bytes) {
    size_ += bytes.size();
    return bytes;
  }

  const GltfDocument& document_;
  const ProgressMeter progress_;
  std::map<std::uint64_t, std::span<const std::byte>> buffers_{};
  std::map<std::filesystem::path, std::unique_ptr<MappedFile>> files_{};
  std::set<FileIdentity> opened_{};
  std::vector<std::unique_ptr<std::byte[]>> decoded_{};
  std::uint64_t size_ = 0, size_beside_ = 0;
  std::uint64_t characters_ = 0;  ///< that were decoded
};

/// The path that a relative URI names, percent-decoded; empty unless it stays in the folder that it is
/// relative to.
SWIFTGS_API std::filesystem::path path_of_uri(std::string_view uri);

/// Vectors of numbers in a buffer.
struct GltfAccessor {
  /// glTF's numbers for the types of components.
  enum Type { i8 = 5120, u8 = 5121, i16 = 5122, u16 = 5123, f32 = 5126 };

  const std::byte* data = nullptr;
  std::uint64_t count = 0;
  std::uint64_t stride = 0;
  Type type = f32;
  bool normalised = false;
  std::uint64_t offset = 0;  ///< of its JSON, for errors
};

/// Accessor `index`, which has `components` components and lies inside its buffer. `user` is what refers to
/// it, by the name `attribute`.
GltfAccessor find_accessor(const GltfDocument& document, GltfBuffers& buffers, std::uint64_t index,
                           const JsonEntry& user, const std::string& attribute, int components);

/// Calls `store(i, numbers)` for vectors [begin, end), integers as glTF converts them to floats. The accessor
/// has `Components` components.
template <int Components, class Store>
void for_vectors(const GltfAccessor& accessor, std::size_t begin, std::size_t end, const Store& store) {
  const auto all = [&]<class T>(T, float unit) {
    float numbers[Components];
    for (std::size_t i = begin; i < end; ++i) {
      const std::byte* at = accessor.data + i * accessor.stride;
      for (int c = 0; c < Components; ++c) {
        numbers[c] = float(load<T>(at + std::size_t(c) * sizeof(T)));
        // Division, as the reciprocal of the largest integer would not make it 1. The least is below -1.
        if (unit != 0) numbers[c] = std::max(numbers[c] / unit, -1.0f);
      }
      store(i, numbers);
    }
  };
  const auto unit = [&](float largest) { return accessor.normalised ? largest : 0.0f; };
  switch (accessor.type) {
    case GltfAccessor::i8:
      return all(std::int8_t(), unit(127));
    case GltfAccessor::u8:
      return all(std::uint8_t(), unit(255));
    case GltfAccessor::i16:
      return all(std::int16_t(), unit(32767));
    case GltfAccessor::u16:
      return all(std::uint16_t(), unit(65535));
    case GltfAccessor::f32:
      return all(float(), 0);
  }
}

/// What holds Gaussians as SPZ: the latest name, and those of drafts.
inline constexpr const char* gltf_spz_extensions[] = {"KHR_gaussian_splatting_compression_spz_2",
                                                      "KHR_gaussian_splatting_compression_spz",
                                                      "KHR_spz_gaussian_splats_compression"};

/// Where the Gaussians of a primitive are: in accessors, or in an SPZ file of its own.
struct GltfPrimitive {
  GltfAccessor mean{}, rotation{}, scale{}, opacity{}, sh0{};
  std::vector<GltfAccessor> sh_rest{};  ///< for bands 1 and up
  std::uint64_t count = 0;
  int sh_degree = 0;  ///< of what is kept
  RenderingModel model{};
  std::optional<std::uint64_t> spz_view{};  ///< then the accessors are not set
  std::span<const std::byte> spz{};

  /// The SPZ file, as errors name it.
  Source spz_source(const Source& document) const {
    return {spz, document.name + ": buffer view " + std::to_string(*spz_view)};
  }
};

/// Some Gaussians of a primitive, and where they go in a scene of the same or a higher degree.
struct GltfRange {
  std::size_t first, count, to;
};

/// `primitive` if it has Gaussians. `mesh` is the mesh that it is of, for errors. `notes` are told of what is
/// stored and not read.
std::optional<GltfPrimitive> find_gaussians(const GltfDocument& document, GltfBuffers& buffers,
                                            const JsonEntry& mesh, const nlohmann::json& primitive,
                                            std::vector<std::string>& notes);

/// Whether the scales are logarithms, as drafts of the extension had them: one is below 0, which a scale
/// itself cannot be.
bool has_scale_below_zero(const GltfPrimitive& primitive, const ProgressMeter& progress);

/// Decodes Gaussians of accessors, whose scales may be `logarithmic`.
void decode(const GltfPrimitive& primitive, const AxisFlip& flip, bool logarithmic, const GltfRange& range,
            const ProgressMeter& progress, Scene& scene);

}  // namespace swiftgs::io
