// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/sh.hpp>

#include "gltf_encoder.hpp"
#include "scenes.hpp"
#include "spz_encoder.hpp"

using namespace swiftgs;
using namespace swiftgs::test;
using nlohmann::json;

namespace {

SceneFile read(const std::string& content, const SceneReadOptions& options = {}) {
  return read_scene(as_bytes(content), "test.gltf", options);
}

void check_same(const Scene& a, const Scene& b) {
  CHECK_NOTHROW(validate(a));
  CHECK(a.means == b.means);
  CHECK(a.scales == b.scales);
  CHECK(a.opacities == b.opacities);
  CHECK(a.sh0 == b.sh0);
  CHECK(a.sh_rest == b.sh_rest);
  REQUIRE(a.rotations.size() == b.rotations.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(a.rotations[i].w == doctest::Approx(b.rotations[i].w).epsilon(1e-6));
    CHECK(a.rotations[i].x == doctest::Approx(b.rotations[i].x).epsilon(1e-6));
    CHECK(a.rotations[i].y == doctest::Approx(b.rotations[i].y).epsilon(1e-6));
    CHECK(a.rotations[i].z == doctest::Approx(b.rotations[i].z).epsilon(1e-6));
  }
}

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

GltfParts with_spz(const std::string& spz, const std::string& extension) {
  GltfParts parts = encode_gltf(some_scene(1, 0));
  parts.buffer = spz;
  parts.root["buffers"][0]["byteLength"] = spz.size();
  parts.root["bufferViews"] = json::array({{{"buffer", 0}, {"byteLength", spz.size()}}});
  for (json& accessor : parts.root["accessors"]) accessor.erase("bufferView");
  parts.extension()["extensions"][extension] = {{"bufferView", 0}};
  parts.root["extensionsUsed"].push_back(extension);
  parts.root["extensionsRequired"] = parts.root["extensionsUsed"];
  return parts;
}

}  // namespace

TEST_CASE("gltf: every degree is read from text and from binary") {
  for (int degree = 0; degree <= 3; ++degree) {
    CAPTURE(degree);
    const Scene scene = some_scene(40, degree);
    const GltfParts parts = encode_gltf(scene);
    for (const bool binary : {false, true}) {
      const SceneFile file = read(binary ? glb(parts) : gltf(parts));
      CHECK(file.format == (binary ? "glTF (binary)" : "glTF (text)"));
      CHECK(file.stored == 40);
      CHECK(file.dropped_nonfinite == 0);
      CHECK(file.notes.empty());
      check_same(file.scene, scene);
    }
  }
}

TEST_CASE("gltf: a Gaussian keeps its colour from every side when the axes turn") {
  const Scene scene = some_scene(5, 3);
  const GltfParts parts = encode_gltf(scene);
  // The file's own numbers, by the names of attributes.
  const auto stored = [&](std::size_t i, int degree, int n, int channel) {
    const auto& attributes = parts.root["meshes"][0]["primitives"][0]["attributes"];
    const std::string name =
        "KHR_gaussian_splatting:SH_DEGREE_" + std::to_string(degree) + "_COEF_" + std::to_string(n);
    const auto& accessor = parts.root["accessors"][attributes[name].get<std::size_t>()];
    const auto& view = parts.root["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    float value;
    std::memcpy(
        &value,
        parts.buffer.data() + view["byteOffset"].get<std::size_t>() + 4 * (3 * i + std::size_t(channel)), 4);
    return double(value);
  };
  const Scene got = read(glb(parts)).scene;
  const dvec3 direction(0.48, -0.6, 0.64);
  double here[15], there[15];
  sh_basis(3, direction, here);
  sh_basis(3, dvec3(-direction.x, -direction.y, direction.z), there);
  for (std::size_t i = 0; i < scene.size(); ++i)
    for (int channel = 0; channel < 3; ++channel) {
      double colour = 0, colour_there = 0;
      for (int degree = 1, k = 0; degree <= 3; ++degree)
        for (int n = 0; n <= 2 * degree; ++n, ++k) {
          colour += here[k] * double(got.sh_rest[i * 45 + std::size_t(3 * k + channel)]);
          colour_there += there[k] * stored(i, degree, n, channel);
        }
      CHECK(colour == doctest::Approx(colour_there).epsilon(1e-6));
    }
}

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

TEST_CASE("gltf: an early splat-transform is known by its name") {
  Scene scene = some_scene(20, 3);
  GltfParts parts = encode_gltf(scene);
  for (const char* name : {"splat-transform 1.10.1", "splat-transform 0.16.1"}) {
    parts.root["asset"]["generator"] = name;
    const SceneFile file = read(glb(parts));
    REQUIRE(file.notes.size() == 1);
    CHECK(contains(file.notes[0], "early splat-transform"));
    CHECK(file.scene.means[3] == vec3(-1, -1, 1) * scene.means[3]);
    CHECK(file.scene.scales[3].x == doctest::Approx(std::exp(scene.scales[3].x)));
    CHECK(file.scene.sh_rest[3] == scene.sh_rest[3]);
    CHECK(file.scene.sh_rest[0] == -scene.sh_rest[0]);
  }
  parts.root["asset"]["generator"] = "splat-transform 2.7.1";
  check_same(read(glb(parts)).scene, scene);
}

TEST_CASE("gltf: SPZ inside is read under its names and with the axes of glTF") {
  const Scene scene = some_scene(25, 2);
  const std::string spz = gzip_spz(encode_spz(scene, 2));
  const Scene luf = read_scene(as_bytes(spz), "spz", {.spz_frame = SpzFrame::luf}).scene;
  const Scene raw = read_scene(as_bytes(spz), "spz", {.spz_frame = SpzFrame::raw}).scene;
  for (const char* name : {"KHR_gaussian_splatting_compression_spz_2",
                           "KHR_gaussian_splatting_compression_spz", "KHR_spz_gaussian_splats_compression"}) {
    CAPTURE(name);
    GltfParts parts = with_spz(spz, name);
    const SceneFile file = read(glb(parts));
    CHECK(file.format == "glTF (binary, SPZ version 2 inside)");
    CHECK(file.stored == 25);
    CHECK(file.notes.empty());
    check_same(file.scene, luf);
    check_same(read(glb(parts), {.spz_frame = SpzFrame::raw}).scene, raw);
    parts.primitive()["extensions"] = {{name, {{"bufferView", 0}}}};
    check_same(read(gltf(parts)).scene, luf);
  }
}

TEST_CASE("gltf: an error inside SPZ names the buffer view") {
  SpzParts spz = encode_spz(some_scene(3, 0), 2);
  spz.sh_degree = 9;
  const GltfParts parts = with_spz(plain_spz(spz), "KHR_gaussian_splatting_compression_spz_2");
  CHECK(contains(complaint([&] { read(glb(parts)); }),
                 "test.gltf: buffer view 0: byte 12: expected SH degree"));
}

TEST_CASE("gltf: what a scene does not carry is noted once") {
  GltfParts parts = encode_gltf(some_scene(3, 3));
  parts.extension() = {{"kernel", "customShape"},
                       {"colorSpace", "lin_rec709_display"},
                       {"projection", "fish\neye"},
                       {"sortingMethod", "zDepth"}};
  parts.primitive()["attributes"]["COLOR_0"] = 0;
  parts.primitive()["attributes"]["_LABEL"] = 0;
  parts.primitive()["attributes"]["KHR_gaussian_splatting:SH_DEGREE_4_COEF_0"] = 0;
  parts.root["animations"] = json::array({json::object()});
  parts.root["extensionsUsed"].push_back("EXT_unheard_of");
  parts.root["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}});
  parts.root["meshes"].push_back(parts.root["meshes"][0]);
  parts.root["nodes"].push_back({{"mesh", 1}});
  parts.root["scenes"] = {{{"nodes", {0, 1}}}, json::object()};
  const SceneFile file = read(glb(parts));
  CHECK(file.stored == 6);
  std::string all;
  for (const std::string& note : file.notes) all += note + "\n";
  for (const char* part :
       {"\"lin_rec709_display\"", "\"customShape\"", "\"fish\\neye\"", "\"zDepth\"", "\"_LABEL\"",
        "above degree 3", "Animations", "\"EXT_unheard_of\"", "left out: 2.", "2 scenes"}) {
    CAPTURE(part);
    CHECK(contains(all, part));
    CHECK(all.find(part) == all.rfind(part));
  }
  CHECK(file.notes.size() == 10);
}

TEST_CASE("gltf: opacities outside their range are clamped and counted") {
  Scene scene = some_scene(4, 0);
  scene.opacities = {-0.5f, 0, 1, 1.5f};
  const SceneFile file = read(glb(encode_gltf(scene)));
  CHECK(file.scene.opacities == std::vector<float>{0, 0, 1, 1});
  CHECK(file.notes == std::vector<std::string>{"Opacities outside [0, 1] were clamped: 2."});
}

TEST_CASE("gltf: Gaussians that are not finite are dropped") {
  Scene scene = some_scene(4, 1);
  scene.means[1].y = std::numeric_limits<float>::quiet_NaN();
  scene.sh_rest[2 * 9 + 4] = std::numeric_limits<float>::infinity();
  const SceneFile file = read(glb(encode_gltf(scene)));
  CHECK(file.stored == 4);
  CHECK(file.dropped_nonfinite == 2);
  CHECK(file.scene.means[1] == scene.means[3]);
}

TEST_CASE("gltf: buffers in other files are found in the folder of the file alone") {
  const TemporaryFolder folder;
  const Scene scene = some_scene(9, 1);
  GltfParts parts = encode_gltf(scene);
  const auto text = [&](const std::string& uri) {
    parts.root["buffers"][0]["uri"] = uri;
    return parts.root.dump();
  };
  folder.write("scene/my data.bin", parts.buffer), folder.write("scene/parts/b.bin", parts.buffer);
  folder.write("outside.bin", parts.buffer);
  const auto complaint_about = [&](const std::string& uri) {
    return complaint([&] { read_scene(folder.write("scene/a.gltf", text(uri))); });
  };
  for (const char* uri : {"my%20data.bin", "my data.bin", "parts/b.bin", "./parts/b.bin", "parts%2fb.bin"})
    check_same(read_scene(folder.write("scene/a.gltf", text(uri))).scene, scene);
  for (const std::string& uri :
       {std::string("../outside.bin"), std::string("parts/../../outside.bin"),
        std::string("%2e%2E/outside.bin"), (folder / "outside.bin").string(),
        "file://" + (folder / "outside.bin").string(), std::string("a%00b"),
        std::string("http://example.com/a.bin"), std::string("..\\outside.bin"), std::string(""),
        std::string("%2"), std::string("%zz"), std::string("parts/")}) {
    CAPTURE(uri);
    CHECK(contains(complaint_about(uri), "'uri' of a file in the folder of this one"));
  }
  CHECK_THROWS_AS(read_scene(folder.write("scene/a.gltf", text("missing.bin"))), std::system_error);
  CHECK(contains(complaint([&] { read(text("my%20data.bin")); }), "read from memory"));
}

TEST_CASE("gltf: progress grows to 1 and can cancel") {
  const std::string text = gltf(encode_gltf(some_scene(100, 3)));
  double last = 0;
  const Progress watch = [&](double part) {
    CHECK(part >= last);
    last = part;
    return true;
  };
  read(text, {.progress = watch});
  CHECK(last == 1);
  CHECK_THROWS_AS(read(text, {.progress = [](double) { return false; }}), Cancelled);
  const GltfParts spz =
      with_spz(gzip_spz(encode_spz(some_scene(9, 1), 2)), "KHR_gaussian_splatting_compression_spz_2");
  last = 0;
  read(glb(spz), {.progress = watch});
  CHECK(last == 1);
  CHECK_THROWS_AS(read(glb(spz), {.progress = [](double) { return false; }}), Cancelled);
}
