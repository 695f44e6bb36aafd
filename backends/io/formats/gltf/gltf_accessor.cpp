// SPDX-License-Identifier: Apache-2.0
#include "gltf_accessor.hpp"

namespace swiftgs::io {
namespace {

std::uint64_t component_size(const JsonEntry& entry, std::uint64_t type) {
  switch (type) {
    case GltfAccessor::i8:
    case GltfAccessor::u8:
      return 1;
    case GltfAccessor::i16:
    case GltfAccessor::u16:
      return 2;
    case GltfAccessor::f32:
      return 4;
    default:
      entry.fail("a 'componentType' of 5120 to 5123 or 5126, found " + std::to_string(type));
  }
}

}  // namespace

GltfAccessor find_accessor(const GltfDocument& document, GltfBuffers& buffers, std::uint64_t index,
                           const JsonEntry& user, const std::string& attribute, int components) {
  const JsonEntry entry = document.item("accessors", index, user);
  const std::string type = components == 1 ? "SCALAR" : "VEC" + std::to_string(components);
  if (entry.string("type") != type)
    entry.fail(attribute + " to be of type " + type + ", found " + shown(entry.member("type")));
  if (entry.has("sparse")) entry.fail(attribute + " without 'sparse', which is not supported");
  if (!entry.has("bufferView")) entry.fail(attribute + " with a 'bufferView'");

  GltfAccessor accessor{.offset = entry.offset()};
  const std::uint64_t component = whole_number(entry, "componentType");
  const std::uint64_t size = component_size(entry, component) * std::uint64_t(components);
  accessor.type = GltfAccessor::Type(component);
  if (entry.has("normalized")) {
    const nlohmann::json& normalised = entry.member("normalized");
    if (!normalised.is_boolean()) entry.fail("'normalized' to be true or false");
    accessor.normalised = normalised.get<bool>();
  }
  accessor.count = whole_number(entry, "count");
  if (accessor.count == 0) entry.fail(attribute + " of at least one Gaussian");

  const auto view = buffers.view(whole_number(entry, "bufferView"), entry);
  accessor.stride = view.stride == 0 ? size : view.stride;
  if (accessor.stride < size)
    entry.fail(attribute + " of " + std::to_string(size) +
               " bytes in a 'byteStride' of at least that, found " + std::to_string(view.stride));
  const std::uint64_t offset = whole_number(entry, "byteOffset", 0), room = view.bytes.size();
  if (offset > room || size > room - offset || accessor.count - 1 > (room - offset - size) / accessor.stride)
    entry.fail(attribute + " of " + std::to_string(accessor.count) + " Gaussians inside its buffer view of " +
               std::to_string(room) + " bytes");
  accessor.data = view.bytes.data() + offset;
  return accessor;
}

}  // namespace swiftgs::io
