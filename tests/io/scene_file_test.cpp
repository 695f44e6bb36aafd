// SPDX-License-Identifier: Apache-2.0
#include <system_error>

#include <swiftgs/io/scene_file.hpp>

#include "ply_text.hpp"
#include "scenes.hpp"
#include "spz_encoder.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

TEST_CASE("scene file: the content decides the format and not the name") {
  const TemporaryFolder folder;
  CHECK(read_scene(folder.write("a.spz", ply(plain_gaussian()))).format ==
        "INRIA PLY (binary_little_endian)");
  CHECK(read_scene(folder.write("b", ply(plain_gaussian(), {.line_break = "\r\n"}))).scene.size() == 1);
  const SpzParts v3 = encode_spz(some_scene(3, 0), 3), v4 = encode_spz(some_scene(3, 0), 4);
  CHECK(read_scene(folder.write("c.ply", gzip_spz(v3))).format == "SPZ version 3");
  CHECK(read_scene(folder.write("d.ply", stream_spz(v4))).format == "SPZ version 4");
  CHECK(load_scene(folder.write("e.jpg", plain_spz(v3))).size() == 3);
}

TEST_CASE("scene file: options reach the SPZ reader") {
  const TemporaryFolder folder;
  const Scene scene = some_scene(3, 0);
  const auto path = folder.write("a.spz", gzip_spz(encode_spz(scene, 3)));
  const vec3 raw = load_scene(path, {.spz_frame = SpzFrame::raw}).means[1];
  CHECK(load_scene(path).means[1] == vec3(1, -1, -1) * raw);
}

TEST_CASE("scene file: foreign files are refused at byte 0 and named where they are well known") {
  const auto complaint_about = [](const std::string& content) {
    return complaint([&] { read_scene(as_bytes(content), "a file"); });
  };
  const std::string start = "a file: byte 0: expected a scene of Gaussians, found ";
  CHECK(complaint_about("") == start + "an empty file");
  CHECK(complaint_about("PK\3\4") == start + "a ZIP archive");
  CHECK(complaint_about("PK\3\4 scene.usdc") == start + "a USD archive");
  CHECK(complaint_about("PXR-USDC") == start + "a USD scene");
  CHECK(complaint_about("#usda 1.0\n") == start + "a USD scene");
  CHECK(complaint_about("{\"frames\": [{\"transform_matrix\": []}]}") ==
        start + "JSON of cameras (transforms.json)");
  CHECK(complaint_about("{\"frames\": [], \"camera_angle_x\": 0.7}") ==
        start + "JSON of cameras (transforms.json)");
  CHECK(complaint_about("[{\"img_name\": 1}]") == start + "JSON of cameras (cameras.json)");
  CHECK(complaint_about("{}") == start + "JSON");
  CHECK(complaint_about("\x89PNG\r\n") == start + "a PNG image");
  CHECK(complaint_about("<!DOCTYPE html><html>") == start + "a page of HTML");
  CHECK(complaint_about("version https://git-lfs.github.com/spec/v1\noid") ==
        start + "a pointer of Git LFS, whose content is not there");
  CHECK(complaint_about("\xff\xd8\xff\xe0") == start + "a JPEG image");
  CHECK(complaint_about(std::string(64, '\0')) == start + "something else");
  CHECK(complaint_about("plywood\n") == start + "something else");
}

TEST_CASE("scene file: a glTF without Gaussians is refused as one") {
  const auto complaint_about = [](const std::string& content, const std::string& name) {
    return complaint([&] { read_scene(as_bytes(content), name); });
  };
  const std::string expected = "expected a glTF with Gaussians";
  CHECK(contains(complaint_about("glTF", "a"), "byte 4: expected 4 bytes for a version"));
  CHECK(contains(complaint_about("{\"asset\": 1, \"meshes\": []}", "a"), expected));
  CHECK(contains(complaint_about("\n {\"asset\": 1, \"accessors\": []}", "a"), expected));
  CHECK(contains(complaint_about("{\"extensionsUsed\": [\"KHR_gaussian_splatting\"]}", "a"), expected));
  CHECK(contains(complaint_about("{}", "a.gltf"), expected));
}

TEST_CASE("scene file: formats without a beginning of their own go by the ending") {
  const auto complaint_about = [](const std::string& name, std::size_t size) {
    const std::string content(size, '\1');
    return complaint([&] { read_scene(as_bytes(content), name); });
  };
  CHECK(complaint_about("a.splat", 64) == "");
  CHECK(complaint_about("a.SPLAT", 64) == "");
  CHECK(contains(complaint_about("a.KSplat", 64), "headers of a .ksplat scene"));
  CHECK(contains(complaint([&] { read_scene(as_bytes(std::string("{}")), "a.GLTF"); }), "a glTF"));
  CHECK(contains(complaint_about("a.splats", 64), "found something else"));
  CHECK(read_scene(as_bytes(ply(plain_gaussian())), "a.splat").format == "INRIA PLY (binary_little_endian)");
  CHECK(contains(complaint([&] { read_scene(as_bytes(std::string("{\"fl_x\": 1}")), "a.json"); }),
                 "found JSON of cameras (transforms.json)"));
}

TEST_CASE("scene file: what cannot be opened is an error with its path and reason") {
  const TemporaryFolder folder;
  const auto message = [](const std::filesystem::path& path) {
    try {
      read_scene(path);
    } catch (const std::system_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(message(folder / "missing.ply") == (folder / "missing.ply").string() + ": No such file or directory");
  CHECK_THROWS_WITH_AS(
      read_scene(folder / ""),
      ((folder / "").string() + ": expected a capture, a folder with one .spz, .ply or .sog in it, or else "
                                "one .ksplat, .splat, .glb or .gltf, found none")
          .c_str(),
      std::invalid_argument);
  CHECK(message("/dev/null") == "/dev/null: expected a regular file");
}

TEST_CASE("scene file: more Gaussians than one thread decodes keep their order") {
  const TemporaryFolder folder;
  const Scene scene = some_scene(200'000, 0);
  write_scene(folder / "a.ply", scene);
  const SceneFile ply_file = read_scene(folder / "a.ply");
  CHECK(ply_file.scene.means == scene.means);
  CHECK(ply_file.scene.sh0 == scene.sh0);
  SpzParts parts = encode_spz(scene, 4);
  const Scene spz = read_scene(as_bytes(stream_spz(parts)), "spz", {.spz_frame = SpzFrame::raw}).scene;
  float worst = 0;
  for (std::size_t i = 0; i < scene.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      worst = std::max(worst, std::abs(spz.means[i][axis] - scene.means[i][axis]));
  CHECK(worst <= 0.5f / 4096 + 1e-6f);
}
