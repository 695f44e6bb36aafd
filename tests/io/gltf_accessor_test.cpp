// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <swiftgs/io/scene_file.hpp>

#include "gltf_encoder.hpp"
#include "scenes.hpp"

using namespace swiftgs;
using namespace swiftgs::test;
using nlohmann::json;

namespace {

SceneFile read(const std::string& content) { return read_scene(as_bytes(content), "test.glb"); }

/// The numbers of an attribute as integers of type T.
template <class T, class Number>
std::string integers(std::size_t count, int components, std::size_t stride, const Number& number) {
  std::string bytes;
  for (std::size_t i = 0; i < count; ++i) {
    for (int c = 0; c < components; ++c) append(bytes, T(std::lround(number(i, c))));
    bytes.resize((i + 1) * stride);
  }
  return bytes;
}

/// Replaces an attribute of one mesh.
void replace(GltfParts& parts, const std::string& attribute, const std::string& bytes, json accessor,
             std::size_t stride) {
  const std::size_t index = add_accessor(parts, bytes, std::move(accessor));
  parts.root["bufferViews"].back()["byteStride"] = stride;
  parts.primitive()["attributes"]["KHR_gaussian_splatting:" + attribute] = index;
}

}  // namespace

TEST_CASE("gltf: integers of every type that the extension allows are decoded") {
  const Scene scene = some_scene(30, 0);
  const auto rotation = [&](std::size_t i, int c) {
    const Quaternion& q = scene.rotations[i];
    return double(std::array{-q.x, -q.y, q.z, q.w}[std::size_t(c)]);
  };
  const auto opacity = [&](std::size_t i, int) { return double(scene.opacities[i]); };
  const auto scale = [&](std::size_t i, int c) { return std::min(1.0, double(scene.scales[i][c])); };
  const auto times = [](double by, const auto& number) {
    return [by, &number](std::size_t i, int c) { return by * number(i, c); };
  };
  for (const bool wide : {false, true}) {
    CAPTURE(wide);
    GltfParts parts = encode_gltf(scene);
    const json signed_type = {
        {"componentType", wide ? 5122 : 5120}, {"count", 30}, {"type", "VEC4"}, {"normalized", true}};
    const double largest = wide ? 32767 : 127, most = wide ? 65535 : 255;
    replace(parts, "ROTATION",
            wide ? integers<std::int16_t>(30, 4, 12, times(largest, rotation))
                 : integers<std::int8_t>(30, 4, 4, times(largest, rotation)),
            signed_type, wide ? 12 : 4);
    json unsigned_type = {
        {"componentType", wide ? 5123 : 5121}, {"count", 30}, {"type", "SCALAR"}, {"normalized", true}};
    replace(parts, "OPACITY",
            wide ? integers<std::uint16_t>(30, 1, 4, times(most, opacity))
                 : integers<std::uint8_t>(30, 1, 4, times(most, opacity)),
            unsigned_type, 4);
    unsigned_type["type"] = "VEC3";
    replace(parts, "SCALE",
            wide ? integers<std::uint16_t>(30, 3, 8, times(most, scale))
                 : integers<std::uint8_t>(30, 3, 4, times(most, scale)),
            unsigned_type, wide ? 8 : 4);
    Scene got = read(glb(parts)).scene;
    for (std::size_t i = 0; i < 30; ++i) {
      const Quaternion a = scene.rotations[i], b = got.rotations[i];
      // Half a step, and as much again for the length.
      for (const float difference : {a.w - b.w, a.x - b.x, a.y - b.y, a.z - b.z})
        CHECK(std::abs(double(difference)) < 1 / largest);
      CHECK(double(got.opacities[i]) ==
            doctest::Approx(std::round(opacity(i, 0) * most) / most).epsilon(1e-6));
      for (int c = 0; c < 3; ++c)
        CHECK(double(got.scales[i][c]) ==
              doctest::Approx(std::round(scale(i, c) * most) / most).epsilon(1e-6));
    }
    // Whole numbers.
    unsigned_type.erase("normalized");
    replace(
        parts, "SCALE",
        wide ? integers<std::uint16_t>(30, 3, 8, [](std::size_t i, int c) { return 2000.0 * double(i) + c; })
             : integers<std::uint8_t>(30, 3, 4, [](std::size_t i, int c) { return 8.0 * double(i) + c; }),
        unsigned_type, wide ? 8 : 4);
    got = read(glb(parts)).scene;
    CHECK(got.scales[29] == (wide ? vec3(58000, 58001, 58002) : vec3(232, 233, 234)));
  }
}

TEST_CASE("gltf: the least integer stands for -1") {
  GltfParts parts = encode_gltf(some_scene(1, 0));
  const json accessor = {{"componentType", 5120}, {"count", 1}, {"type", "VEC4"}, {"normalized", true}};
  replace(parts, "ROTATION", std::string("\x80\x81\x00\x00", 4), accessor, 4);
  const Quaternion q = read(glb(parts)).scene.rotations[0];
  CHECK(q.x == q.y);
}

TEST_CASE("gltf: interleaved attributes are read by their stride") {
  const Scene scene = some_scene(7, 0);
  GltfParts parts = encode_gltf(scene);
  std::string rows;
  for (std::size_t i = 0; i < 7; ++i) {
    append(rows, scene.opacities[i]);
    for (int c = 0; c < 3; ++c) append(rows, scene.scales[i][c]);
  }
  const std::size_t opacity =
      add_accessor(parts, rows, {{"componentType", 5126}, {"count", 7}, {"type", "SCALAR"}});
  parts.root["bufferViews"].back()["byteStride"] = 16;
  json scale = parts.root["accessors"].back();
  scale["type"] = "VEC3", scale["byteOffset"] = 4;
  parts.root["accessors"].push_back(scale);
  parts.primitive()["attributes"]["KHR_gaussian_splatting:OPACITY"] = opacity;
  parts.primitive()["attributes"]["KHR_gaussian_splatting:SCALE"] = opacity + 1;
  check_same(read(glb(parts)).scene, scene);
}

TEST_CASE("gltf: scales below 0 are logarithms") {
  Scene scene = some_scene(20, 1);
  GltfParts parts = encode_gltf(scene);
  std::string logarithms;
  for (const vec3& scale : scene.scales)
    for (int c = 0; c < 3; ++c) append(logarithms, std::log(scale[c]));
  replace(parts, "SCALE", logarithms, {{"componentType", 5126}, {"count", 20}, {"type", "VEC3"}}, 12);
  const SceneFile file = read(glb(parts));
  REQUIRE(file.notes.size() == 1);
  CHECK(contains(file.notes[0], "logarithms"));
  CHECK(file.scene.means == scene.means);
  for (std::size_t i = 0; i < 20; ++i)
    for (int c = 0; c < 3; ++c)
      CHECK(file.scene.scales[i][c] == doctest::Approx(scene.scales[i][c]).epsilon(1e-6));
}

TEST_CASE("gltf: one scale below 0 makes all of a file logarithms") {
  Scene scene = some_scene(20, 0);
  for (vec3& scale : scene.scales) scale = glm::abs(scale);
  GltfParts parts = encode_gltf(scene);
  const json positive = parts.primitive();
  std::string below(20 * 12, '\0');
  below[12 * 7 + 3] = '\xbf', below[12 * 7 + 2] = '\x80';  // -1
  parts.primitive()["attributes"]["KHR_gaussian_splatting:SCALE"] =
      add_accessor(parts, below, {{"componentType", 5126}, {"count", 20}, {"type", "VEC3"}});
  json& primitives = parts.root["meshes"][0]["primitives"];
  primitives = json::array({positive, primitives[0]});
  const SceneFile file = read(glb(parts));
  CHECK(file.notes.size() == 1);
  REQUIRE(file.scene.size() == 40);
  for (std::size_t i = 0; i < 20; ++i) {
    CHECK(file.scene.scales[i].y == std::exp(scene.scales[i].y));
    CHECK(file.scene.scales[20 + i].x == (i == 7 ? std::exp(-1.0f) : 1.0f));
  }
}
