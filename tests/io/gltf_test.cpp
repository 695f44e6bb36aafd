// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/project/sh.hpp>

#include "gltf_encoder.hpp"
#include "spz_encoder.hpp"

namespace swiftgs::test::gltf_test {

using nlohmann::json;

TEST_CASE("gltf: every degree is read from text and from binary") {
  for (int degree = 0; degree <= 3; ++degree) {
    CAPTURE(degree);
    const Scene scene = some_scene(40, degree);
    const GltfParts parts = encode_gltf(scene);
    for (const bool binary : {false, true}) {
      const SceneFile file = read(binary ? glb(parts) : gltf(parts));
      check_whole(file, binary ? "glTF (binary)" : "glTF (text)", 40);
      check_same(file.scene, scene);
    }
  }
}

TEST_CASE("gltf: a Gaussian keeps its colour from every side when the axes turn") {
  const Scene scene = some_scene(5, 3);
  GltfParts parts = encode_gltf(scene);
  // The file's own numbers, by the names of attributes.
  const auto stored = [&](std::size_t i, int degree, int n, int channel) {
    const json& accessor =
        parts.accessor_of("SH_DEGREE_" + std::to_string(degree) + "_COEF_" + std::to_string(n));
    const std::size_t view = parts.root["bufferViews"][accessor["bufferView"].get<int>()]["byteOffset"];
    float value;
    std::memcpy(&value, parts.buffer.data() + view + 4 * (3 * i + std::size_t(channel)), 4);
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
  const Scene luf = read(spz, "spz", {.spz_frame = SpzFrame::luf}).scene;
  const Scene raw = read(spz, "spz", {.spz_frame = SpzFrame::raw}).scene;
  for (const char* name : {"KHR_gaussian_splatting_compression_spz_2",
                           "KHR_gaussian_splatting_compression_spz", "KHR_spz_gaussian_splats_compression"}) {
    CAPTURE(name);
    GltfParts parts = gltf_with_spz(spz, name);
    const SceneFile file = read(glb(parts));
    check_whole(file, "glTF (binary, SPZ version 2 inside)", 25);
    check_same(file.scene, luf);
    check_same(read(glb(parts), "a.glb", {.spz_frame = SpzFrame::raw}).scene, raw);
    parts.primitive()["extensions"] = {{name, {{"bufferView", 0}}}};
    check_same(read(gltf(parts)).scene, luf);
  }
}

TEST_CASE("gltf: an error inside SPZ names the buffer view") {
  SpzParts spz = encode_spz(some_scene(3, 0), 2);
  spz.sh_degree = 9;
  const GltfParts parts = gltf_with_spz(plain_spz(spz), "KHR_gaussian_splatting_compression_spz_2");
  CHECK(contains(complaint_about(glb(parts)), "a file: buffer view 0: byte 12: expected SH degree"));
}

TEST_CASE("gltf: what a scene does not carry is noted once") {
  GltfParts parts = encode_gltf(some_scene(3, 3));
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
  const std::string all = all_notes(file.notes);
  for (const char* part :
       {"\"_LABEL\"", "above degree 3", "Animations", "\"EXT_unheard_of\"", "left out: 2.", "2 scenes"}) {
    CAPTURE(part);
    CHECK(contains(all, part));
    CHECK(all.find(part) == all.rfind(part));
  }
  CHECK(file.notes.size() == 6);
}

TEST_CASE("gltf: the scene has the rendering model that the extension names") {
  const auto model_of = [](const json& extension) {
    GltfParts parts = encode_gltf(some_scene(3, 0));
    parts.extension() = extension;
    const SceneFile file = read(glb(parts));
    CHECK(file.notes.empty());
    return file.scene.model;
  };
  const RenderingModel by_distance{.order = SplatOrder::distance};
  const RenderingModel linear{.order = SplatOrder::distance, .colours = ColourSpace::linear};
  const json srgb = {{"kernel", "ellipse"}, {"colorSpace", "srgb_rec709_display"}};
  CHECK(model_of(srgb) == by_distance);
  CHECK(model_of({{"kernel", "ellipse"}}) == by_distance);
  CHECK(model_of({{"kernel", "ellipse"}, {"colorSpace", "lin_rec709_display"}}) == linear);
  CHECK(model_of({{"colorSpace", "BT.709-linear"}}) == linear);
  CHECK(model_of({{"sortingMethod", "zDepth"}, {"projection", "perspective"}}) == RenderingModel());
  CHECK(model_of({{"hints", {{"sortingMethod", "zDepth"}}}}) == RenderingModel());
}

TEST_CASE("gltf: a rendering model that no frame follows is refused by name") {
  for (const auto& [key, value] : std::map<std::string, std::string>{{"kernel", "customShape"},
                                                                     {"colorSpace", "Display-P3"},
                                                                     {"projection", "fish\neye"},
                                                                     {"sortingMethod", "none"}}) {
    CAPTURE(key);
    GltfParts parts = encode_gltf(some_scene(3, 0));
    parts.extension()[key] = value;
    const std::string complaint = complaint_about(glb(parts));
    CHECK(contains(complaint, "the " + key + " of Gaussians to be one of "));
    CHECK(contains(complaint, json(value).dump()));
  }
  GltfParts parts = encode_gltf(some_scene(3, 0));
  parts.extension()["sortingMethod"] = 3;
  CHECK(contains(complaint_about(glb(parts)), "'sortingMethod' to be a string"));
}

TEST_CASE("gltf: primitives of different models are joined as far as one frame can draw them") {
  GltfParts parts = encode_gltf(some_scene(3, 0));
  json second = parts.primitive();
  second["extensions"]["KHR_gaussian_splatting"]["sortingMethod"] = "zDepth";
  parts.root["meshes"][0]["primitives"].push_back(second);
  const SceneFile file = read(glb(parts));
  CHECK(file.scene.model.order == SplatOrder::distance);
  CHECK(contains(all_notes(file.notes), "all are by distance"));
  parts.root["meshes"][0]["primitives"][1]["extensions"]["KHR_gaussian_splatting"]["colorSpace"] =
      "lin_rec709_display";
  CHECK(contains(complaint_about(glb(parts)), "Gaussians of one 'colorSpace'"));
}

TEST_CASE("gltf: opacities outside their range are clamped and counted") {
  Scene scene = some_scene(4, 0);
  scene.opacities = {-0.5f, 0, 1, 1.5f};
  const SceneFile file = read(glb(encode_gltf(scene)));
  CHECK(file.scene.opacities == std::vector<float>{0, 0, 1, 1});
  CHECK(file.notes == Strings{"Opacities outside [0, 1] were clamped: 2."});
}

TEST_CASE(
    "gltf: zeros for a quaternion and what is not finite leave a Gaussian out, moved by a node or not") {
  Scene scene = some_scene(8, 1);
  scene.rotations[1] = scene.rotations[4] = {0, 0, 0, 0};
  scene.scales[2].x = INFINITY, scene.means[6].y = NAN, scene.sh_rest[7 * 9 + 4] = INFINITY;
  GltfParts parts = encode_gltf(scene);
  const auto check = [&](const vec3& offset) {
    const SceneFile file = read(glb(parts));
    CHECK(file.stored == 8);
    CHECK(file.left_out.no_rotation == 2);
    CHECK(file.left_out.not_finite == 3);
    REQUIRE(file.scene.size() == 3);
    const std::array<std::size_t, 3> kept = {0, 3, 5};
    for (std::size_t k = 0; k < 3; ++k) CHECK(file.scene.means[k] == scene.means[kept[k]] + offset);
  };
  check({0, 0, 0});
  // glTF's x points the other way.
  parts.root["nodes"][0]["translation"] = {-2, 0, 0};
  check({2, 0, 0});
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
  const auto complaint_of_uri = [&](const std::string& uri) {
    return complaint([&] { read_scene(folder.write("scene/a.gltf", text(uri))); });
  };
  for (const char* uri : {"my%20data.bin", "my data.bin", "parts/b.bin", "./parts/b.bin", "parts%2fb.bin"})
    check_same(read_scene(folder.write("scene/a.gltf", text(uri))).scene, scene);
  const SceneFile file = read_scene(folder.write("scene/a.gltf", text("parts/b.bin")));
  CHECK(file.bytes == text("parts/b.bin").size() + parts.buffer.size());
  const std::string outside = (folder / "outside.bin").string();
  for (const std::string& uri :
       {std::string("../outside.bin"), std::string("parts/../../outside.bin"),
        std::string("%2e%2E/outside.bin"), outside, "file://" + outside, std::string("a%00b"),
        std::string("http://example.com/a.bin"), std::string("..\\outside.bin"), std::string(),
        std::string("%2"), std::string("%zz"), std::string("parts/")}) {
    CAPTURE(uri);
    CHECK(contains(complaint_of_uri(uri), "'uri' of a file in the folder of this one"));
  }
  CHECK_THROWS_AS(read_scene(folder.write("scene/a.gltf", text("missing.bin"))), std::system_error);
  CHECK(contains(complaint_about(text("my%20data.bin")), "read from memory"));
}

}  // namespace swiftgs::test::gltf_test
