// SPDX-License-Identifier: Apache-2.0
#include <functional>
#include <stdexcept>

#include <swiftgs/io/cameras.hpp>
#include <swiftgs/io/capture.hpp>
#include <swiftgs/io/replace_file.hpp>
#include <swiftgs/io/scene_list.hpp>

#include "io/files.hpp"

namespace swiftgs::test::capture_test {

namespace fs = std::filesystem;

namespace {

constexpr const char* cameras_json =
    R"([{"id": 0, "img_name": "a.jpg", "width": 32, "height": 16, "fx": 30, "fy": 30, "position": [0, 0, -5],
         "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}])";

constexpr const char* transforms_json =
    R"({"w": 32, "h": 16, "fl_x": 30, "frames": [{"file_path": "of-transforms",
        "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 5], [0, 0, 0, 1]]}]})";

void write_colmap(const TemporaryFolder& place, const std::string& folder, const std::string& image) {
  place.write(folder + "/cameras.txt", "1 PINHOLE 32 16 30 30 16 8\n");
  place.write(folder + "/images.txt", "1 1 0 0 0 0 0 5 1 " + image + "\n\n");
}

/// Empty files.
void write_all(const TemporaryFolder& place, const Strings& names) {
  for (const std::string& name : names) place.write(name, "");
}

void check_scene(const fs::path& folder, const fs::path& scene, const std::string& name) {
  CAPTURE(folder);
  const Capture found = find_capture(folder);
  CHECK(found.scene.lexically_normal() == scene);
  CHECK(found.name == name);
}

std::string camera_in(const fs::path& path) { return load_cameras(path).at(0).name; }

}  // namespace

TEST_CASE("capture: a folder has the scene that is called as it is or its only one") {
  const TemporaryFolder place;
  write_all(place, {"garden/other.ply", "garden/third.ply"});
  CHECK_THROWS_WITH_AS(find_capture(place / "garden"), doctest::Contains("found other.ply, third.ply"),
                       std::invalid_argument);
  place.write("garden/garden.ply", "");
  for (const std::string name : {"garden", "garden/", "garden/.", "garden/../garden"})
    check_scene(place / name, place / "garden/garden.ply", "garden");
  place.write("garden/garden.spz", "");
  check_scene(place / "garden", place / "garden/garden.spz", "garden");
  write_all(place, {"fox/scan.spz", "fox/input.ply", "fox/scan.spz.sort.json"});
  check_scene(place / "fox", place / "fox/scan.spz", "scan");
}

TEST_CASE("capture: a folder may be a SOG or hold one") {
  const TemporaryFolder place;
  place.write("scan/meta.json", "");
  check_scene(place / "scan/meta.json", place / "scan/meta.json", "scan");
  // Each is preferred to those before.
  for (const auto& [file, name] : {std::pair{"meta.json", "scan"},
                                   {"lod-meta.json", "scan"},
                                   {"room.sog", "room"},
                                   {"scan.ply", "scan"}}) {
    place.write(std::string("scan/") + file, "");
    check_scene(place / "scan", place / "scan" / file, name);
  }
}

TEST_CASE("capture: a folder may have a scene of any format and endings in capitals") {
  const TemporaryFolder place;
  for (const std::string file : {"scan.splat", "scan.KSPLAT", "scan.glb", "scan.gltf", "scan.SPZ", "scan.Ply",
                                 "scan.sog", "scan.compressed.ply", "scan.Compressed.PLY"})
    for (const std::string& folder : {"only-" + file, "named-" + file + "/scan"}) {
      place.write(folder + "/" + file, "");
      if (folder.ends_with("/scan")) write_all(place, {folder + "/a.splat", folder + "/b.glb"});
      check_scene(place / folder, place / (folder + "/" + file), "scan");
    }
  write_all(place, {"two/a.splat", "two/b.GLB"});
  CHECK_THROWS_WITH_AS(find_capture(place / "two"), doctest::Contains("found a.splat, b.GLB"),
                       std::invalid_argument);
  place.write("two/meta.json", "");
  check_scene(place / "two", place / "two/meta.json", "two");
  place.write("two/c.SOG", "");
  check_scene(place / "two", place / "two/c.SOG", "c");
}

TEST_CASE("capture: of a training the last iteration counts and the folder names it") {
  const TemporaryFolder place;
  for (const std::string iteration : {"7000", "30000", "x", "99999x"})
    place.write("output/point_cloud/iteration_" + iteration + "/point_cloud.ply", "");
  write_all(place, {"output/point_cloud/iteration_90000/other.txt", "output/input.ply"});
  place.write("output/cameras.json", cameras_json);
  const Capture capture = find_capture(place / "output");
  CHECK(capture.scene == place / "output/point_cloud/iteration_30000/point_cloud.ply");
  CHECK(capture.name == "output");
  CHECK(capture.cameras == place / "output/cameras.json");
  CHECK(capture.photos.empty());
}

TEST_CASE("capture: a scene's file has the cameras and photographs beside it") {
  const TemporaryFolder place;
  place.write("a/one.ply", ""), place.write("a/two.ply", "");
  CHECK(find_capture(place / "a/one.ply").cameras.empty());
  place.write("a/photos/x.jpg", "");
  write_colmap(place, "a/sparse/0", "x.jpg");
  for (const std::string name : {"one", "two", "missing"}) {
    const Capture capture = find_capture(place / ("a/" + name + ".ply"));
    CHECK(capture.name == name);
    CHECK(capture.scene == place / ("a/" + name + ".ply"));
    CHECK(capture.cameras == place / "a/sparse/0");
    CHECK(capture.photos == place / "a/photos");
  }
}

TEST_CASE("capture: cameras are found in a folder in one order") {
  const TemporaryFolder place;
  CHECK_THROWS_WITH_AS(load_cameras(place.path()),
                       doctest::Contains("expected cameras.json, transforms.json, or a COLMAP model"),
                       std::invalid_argument);
  place.write("nerf/transforms.json", transforms_json);
  CHECK_THROWS_WITH_AS(find_capture(place / "nerf"), doctest::Contains("found transforms.json"),
                       std::invalid_argument);
  CHECK(camera_in(place / "nerf") == "of-transforms");
  place.write("transforms.json", transforms_json);
  CHECK(camera_in(place.path()) == "of-transforms");
  CHECK(find_capture(place / "missing.ply").cameras == place / "transforms.json");
  for (const std::string folder : {"0", "sparse", "sparse/0"}) {
    write_colmap(place, folder, "of-" + folder);
    CHECK(camera_in(place.path()) == "of-" + folder);
  }
  place.write("cameras.json", cameras_json);
  CHECK(camera_in(place.path()) == "a.jpg");
  write_colmap(place, ".", "of-itself");
  CHECK(camera_in(place.path()) == "of-itself");
}

// Blender's scenes of NeRF, and those of nerfstudio's blender data.
TEST_CASE("capture: the cameras of a training split are found and those of a test split are told") {
  const TemporaryFolder place;
  const auto split = [](const std::string& name) {
    return with(transforms_json, "of-transforms", "./" + name + "/r_0");
  };
  place.write("lego/lego.ply", "");
  place.write("lego/transforms_test.json", split("test"));
  CHECK(find_capture(place / "lego").cameras == place / "lego/transforms_test.json");
  CHECK(read_cameras(place / "lego").notes.empty());
  CHECK(camera_in(place / "lego") == "./test/r_0");
  place.write("lego/transforms_train.json", split("train"));
  CHECK(find_capture(place / "lego").cameras == place / "lego/transforms_train.json");
  CHECK(camera_in(place / "lego") == "./train/r_0");
  CHECK(read_cameras(place / "lego").notes ==
        Strings{"The cameras of transforms_train.json were read, those of transforms_test.json were not."});
  for (const std::string typed : {"train", "test"})
    CHECK(read_cameras(place / ("lego/transforms_" + typed + ".json")).notes.empty());
  place.write("lego/transforms_val.json", split("val"));
  CHECK(contains(read_cameras(place / "lego").notes.at(0), "_test.json, transforms_val.json were not"));
  place.write("lego/transforms.json", transforms_json);
  CHECK(camera_in(place / "lego") == "of-transforms");
  CHECK(read_cameras(place / "lego").notes.empty());
  place.write("ship/transforms_val.json", split("val"));
  CHECK(camera_in(place / "ship") == "./val/r_0");
  place.write("nerf/transforms_train.json", split("train"));
  CHECK_THROWS_WITH_AS(find_capture(place / "nerf"), doctest::Contains("found transforms_train.json"),
                       std::invalid_argument);
}

TEST_CASE("capture: a folder without a scene says what it holds instead") {
  const auto found_in = [](const std::function<void(const TemporaryFolder&)>& fill) -> std::string {
    const TemporaryFolder place;
    fill(place);
    try {
      find_capture(place.path());
    } catch (const std::invalid_argument& error) {
      const std::string told = error.what();
      return told.substr(told.rfind("found ") + 6);
    }
    return "no error";
  };
  using Place = const TemporaryFolder&;
  CHECK(found_in([](Place place) { write_all(place, {"a.txt", "b.jpg", "input.ply"}); }) == "none");
  CHECK(found_in([](Place place) {
          place.write("tileset.json", R"({"geometricError": 1, "root": {"content": {"uri": "t/0.glb"}}})");
          place.write("t/0.glb", "glTF");
        }) == "tileset.json, a 3D Tiles tileset; give t/0.glb");
  CHECK(found_in([](Place place) {
          write_all(place, {"data.bin", "index.bin"});
          place.write("scan.lcc", R"({"totalSplats": 1, "fileType": "Quality"})");
        }) == "scan.lcc, an LCC scene of XGRIDS; export a PLY with the program that made it");
  CHECK(found_in([](Place place) { place.write("nerfstudio_models/step-000029999.ckpt", ""); }) ==
        "nerfstudio_models, checkpoints of nerfstudio; export a PLY with 'ns-export gaussian-splat'");
  CHECK(found_in([](Place place) { place.write("ckpts/ckpt_29999_rank0.pt", ""); }) ==
        "ckpts, checkpoints of gsplat; train with --save_ply and give a PLY of its folder 'ply'");
  CHECK(found_in([](Place place) { place.write("step.ckpt", "x"); }) ==
        "step.ckpt, a checkpoint of PyTorch; export a PLY with the program that trained it");
  CHECK(found_in([](Place place) { place.write("cameras.json", cameras_json); }) ==
        "cameras.json, which holds cameras alone");
  CHECK(found_in([](Place place) { place.write("transforms_train.json", transforms_json); }) ==
        "transforms_train.json, which holds cameras alone");
  CHECK(found_in([](Place place) { write_colmap(place, "sparse/0", "a.jpg"); }) ==
        "sparse/0, which holds cameras alone");
  CHECK(found_in([](Place place) { write_colmap(place, ".", "a.jpg"); }) ==
        "a COLMAP model, which holds cameras alone");
}

TEST_CASE("capture: what the system refuses and what a file lacks have codes") {
  const TemporaryFolder place, empty;
  const std::string loop = (place / "loop").string(), absent = (place / "absent.ply").string();
  fs::create_symlink("loop", loop);
  const auto check = [](ErrorCode code, const std::string& file, const auto& read) {
    CAPTURE(file);
    try {
      read(file);
      FAIL_CHECK("expected an error");
    } catch (const Error& error) {
      CHECK(error.code() == code);
      CHECK(std::string(error.what()).starts_with(file + ": "));
    }
  };
  check(ErrorCode::file, loop, [](const fs::path& file) { find_capture(file); });
  check(ErrorCode::file, loop, [](const fs::path& file) { load_cameras(file); });
  check(ErrorCode::file, loop, [](const fs::path& file) { is_scene_list(file); });
  check(ErrorCode::file, absent, [](const fs::path& file) { load_scene(file); });
  check(ErrorCode::file, (place / "none/a.ply").string(),
        [](const fs::path& file) { replace_file(file, ""); });
  check(ErrorCode::format, place.write("a.ply", "ply\n").string(),
        [](const fs::path& file) { load_scene(file); });
  check(ErrorCode::invalid_argument, empty.path().string(), [](const fs::path& file) { find_capture(file); });
}

}  // namespace swiftgs::test::capture_test
