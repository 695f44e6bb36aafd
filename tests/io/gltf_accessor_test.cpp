// SPDX-License-Identifier: Apache-2.0
#include "gltf_encoder.hpp"

namespace swiftgs::test::gltf_accessor_test {

using nlohmann::json;

namespace {

/// Replaces an attribute of one mesh.
void replace(GltfParts& parts, const std::string& attribute, const std::string& bytes, json accessor,
             std::size_t stride) {
  const std::size_t index = add_accessor(parts, bytes, std::move(accessor));
  parts.root["bufferViews"].back()["byteStride"] = stride;
  parts.primitive()["attributes"]["KHR_gaussian_splatting:" + attribute] = index;
}

/// Replaces an attribute by integers of type T, which are `times` the numbers.
template <class T, class Number>
void replace_by(GltfParts& parts, const std::string& attribute, int components, std::size_t stride,
                const Number& number, double times = double(std::numeric_limits<T>::max())) {
  std::string bytes;
  for (std::size_t i = 0; i < 30; ++i) {
    for (int c = 0; c < components; ++c) append(bytes, T(std::lround(times * number(i, c))));
    bytes.resize((i + 1) * stride);
  }
  json accessor = {{"componentType", 5119 + 2 * sizeof(T) - std::is_signed_v<T>},
                   {"count", 30},
                   {"type", components == 1 ? "SCALAR" : "VEC" + std::to_string(components)}};
  if (times != 1) accessor["normalized"] = true;
  replace(parts, attribute, bytes, accessor, stride);
}

template <class Signed, class Unsigned>
void check_integers() {
  const Scene scene = some_scene(30, 0);
  const auto rotation = [&](std::size_t i, int c) {
    const Quaternion& q = scene.rotations[i];
    return double(std::array{-q.x, -q.y, q.z, q.w}[std::size_t(c)]);
  };
  const auto opacity = [&](std::size_t i, int) { return double(scene.opacities[i]); };
  const auto scale = [&](std::size_t i, int c) { return std::min(1.0, double(scene.scales[i][c])); };
  constexpr bool wide = sizeof(Signed) == 2;
  const double largest = std::numeric_limits<Signed>::max(), most = std::numeric_limits<Unsigned>::max();
  GltfParts parts = encode_gltf(scene);
  replace_by<Signed>(parts, "ROTATION", 4, wide ? 12 : 4, rotation);
  replace_by<Unsigned>(parts, "OPACITY", 1, 4, opacity);
  replace_by<Unsigned>(parts, "SCALE", 3, wide ? 8 : 4, scale);
  const Scene got = read(glb(parts)).scene;
  for (std::size_t i = 0; i < 30; ++i) {
    const Quaternion a = scene.rotations[i], b = got.rotations[i];
    // Half a step, and as much again for the length.
    for (const float difference : {a.w - b.w, a.x - b.x, a.y - b.y, a.z - b.z})
      CHECK(std::abs(double(difference)) < 1 / largest);
    CHECK(double(got.opacities[i]) == doctest::Approx(std::round(opacity(i, 0) * most) / most).epsilon(1e-6));
    for (int c = 0; c < 3; ++c)
      CHECK(double(got.scales[i][c]) == doctest::Approx(std::round(scale(i, c) * most) / most).epsilon(1e-6));
  }
  // Whole numbers.
  const double step = wide ? 2000 : 8;
  replace_by<Unsigned>(
      parts, "SCALE", 3, wide ? 8 : 4, [&](std::size_t i, int c) { return step * double(i) + c; }, 1);
  CHECK(read(glb(parts)).scene.scales[29] == vec3(float(step) * 29) + vec3(0, 1, 2));
}

}  // namespace

TEST_CASE("gltf: integers of every type that the extension allows are decoded") {
  check_integers<std::int8_t, std::uint8_t>();
  check_integers<std::int16_t, std::uint16_t>();
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
  REQUIRE(file.notes.size() == 1);
  CHECK(contains(file.notes[0], "logarithms"));
  REQUIRE(file.scene.size() == 40);
  for (std::size_t i = 0; i < 20; ++i) {
    CHECK(file.scene.means[i] == scene.means[i]);
    for (int c = 0; c < 3; ++c) {
      CHECK(file.scene.scales[i][c] == std::exp(scene.scales[i][c]));
      CHECK(file.scene.scales[20 + i][c] == (i == 7 && c == 0 ? std::exp(-1.0f) : 1.0f));
    }
  }
}

}  // namespace swiftgs::test::gltf_accessor_test
