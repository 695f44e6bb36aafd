// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "scenes.hpp"

namespace swiftgs::test {

/// A glTF file taken apart. A test may falsify any part before `glb` or `gltf` puts it together.
struct GltfParts {
  nlohmann::json root;
  std::string buffer;

  nlohmann::json& primitive() { return root["meshes"][0]["primitives"][0]; }
  nlohmann::json& extension() { return primitive()["extensions"]["KHR_gaussian_splatting"]; }
  nlohmann::json& accessor_of(const std::string& attribute) {
    return root["accessors"][primitive()["attributes"]["KHR_gaussian_splatting:" + attribute].get<int>()];
  }
};

/// Adds a buffer view of `bytes` and an accessor of them, and returns the accessor's index.
inline std::size_t add_accessor(GltfParts& parts, const std::string& bytes, nlohmann::json accessor) {
  accessor["bufferView"] = parts.root["bufferViews"].size();
  parts.root["bufferViews"].push_back(
      {{"buffer", 0}, {"byteOffset", parts.buffer.size()}, {"byteLength", bytes.size()}});
  parts.buffer += bytes;
  parts.root["buffers"][0]["byteLength"] = parts.buffer.size();
  parts.root["accessors"].push_back(std::move(accessor));
  return parts.root["accessors"].size() - 1;
}

/// What glTF's axes make of the coefficients above band 0 of a scene whose x and y point the other way.
inline constexpr std::array<float, 15> luf_signs = {-1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1};

/// One mesh of points, all numbers floats, with the axes of glTF.
inline GltfParts encode_gltf(const Scene& scene) {
  const auto array = [](nlohmann::json::initializer_list_t items) { return nlohmann::json::array(items); };
  GltfParts parts;
  parts.root = {{"asset", {{"version", "2.0"}}},
                {"extensionsUsed", array({"KHR_gaussian_splatting"})},
                {"scene", 0},
                {"scenes", array({{{"nodes", array({0})}}})},
                {"nodes", array({{{"mesh", 0}}})},
                {"accessors", array({})},
                {"bufferViews", array({})},
                {"buffers", array({nlohmann::json::object()})}};
  const std::size_t rest = std::size_t(sh_rest_count(scene.sh_degree));
  nlohmann::json attributes;
  const auto add = [&](const std::string& name, int components, const auto& number) {
    std::string bytes;
    for (std::size_t i = 0; i < scene.size(); ++i)
      for (int c = 0; c < components; ++c) append(bytes, float(number(i, c)));
    attributes[name] =
        add_accessor(parts, bytes,
                     {{"componentType", 5126},
                      {"count", scene.size()},
                      {"type", components == 1 ? "SCALAR" : "VEC" + std::to_string(components)}});
  };
  const std::string prefix = "KHR_gaussian_splatting:";
  add("POSITION", 3, [&](std::size_t i, int c) { return (c == 2 ? 1 : -1) * scene.means[i][c]; });
  add(prefix + "ROTATION", 4, [&](std::size_t i, int c) {
    const Quaternion& q = scene.rotations[i];
    return std::array{-q.x, -q.y, q.z, q.w}[std::size_t(c)];
  });
  add(prefix + "SCALE", 3, [&](std::size_t i, int c) { return scene.scales[i][c]; });
  add(prefix + "OPACITY", 1, [&](std::size_t i, int) { return scene.opacities[i]; });
  add(prefix + "SH_DEGREE_0_COEF_0", 3, [&](std::size_t i, int c) { return scene.sh0[i][c]; });
  std::size_t k = 0;
  for (int degree = 1; degree <= scene.sh_degree; ++degree)
    for (int n = 0; n <= 2 * degree; ++n, ++k)
      add(prefix + "SH_DEGREE_" + std::to_string(degree) + "_COEF_" + std::to_string(n), 3,
          [&](std::size_t i, int c) {
            return luf_signs[k] * scene.sh_rest[(i * rest + k) * 3 + std::size_t(c)];
          });
  const nlohmann::json extension = {{"kernel", "ellipse"}, {"colorSpace", "srgb_rec709_display"}};
  const nlohmann::json primitive = {
      {"mode", 0}, {"attributes", attributes}, {"extensions", {{"KHR_gaussian_splatting", extension}}}};
  parts.root["meshes"] = array({{{"primitives", array({primitive})}}});
  return parts;
}

/// One primitive whose Gaussians are in an SPZ, which `extension` names.
inline GltfParts gltf_with_spz(const std::string& spz, const std::string& extension) {
  GltfParts parts = encode_gltf(some_scene(1, 0));
  parts.buffer = spz;
  parts.root["buffers"][0]["byteLength"] = spz.size();
  parts.root["bufferViews"] = nlohmann::json::array({{{"buffer", 0}, {"byteLength", spz.size()}}});
  for (nlohmann::json& accessor : parts.root["accessors"]) accessor.erase("bufferView");
  parts.extension()["extensions"][extension] = {{"bufferView", 0}};
  parts.root["extensionsUsed"].push_back(extension);
  parts.root["extensionsRequired"] = parts.root["extensionsUsed"];
  return parts;
}

inline std::string chunk(std::string_view type, std::string content, char padding) {
  content.resize((content.size() + 3) / 4 * 4, padding);
  std::string bytes;
  append(bytes, std::uint32_t(content.size()));
  return bytes + std::string(type) + content;
}

inline std::string glb(const GltfParts& parts) {
  const std::string chunks =
      chunk("JSON", parts.root.dump(), ' ') + chunk(std::string_view("BIN\0", 4), parts.buffer, '\0');
  std::string file = "glTF";
  append(file, std::uint32_t(2)), append(file, std::uint32_t(12 + chunks.size()));
  return file + chunks;
}

inline std::string to_base64(const std::string& bytes) {
  constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (i + k < bytes.size() ? std::uint8_t(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? alphabet[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

/// Text that holds the buffer as a data URI.
inline std::string gltf(GltfParts parts) {
  parts.root["buffers"][0]["uri"] = "data:application/octet-stream;base64," + to_base64(parts.buffer);
  return parts.root.dump();
}

}  // namespace swiftgs::test
