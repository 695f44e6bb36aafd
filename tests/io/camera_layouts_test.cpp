// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "camera_files.hpp"

/// @file
/// What other programs write about cameras, each in a few lines: read with the right values, noted or refused
/// by name.

namespace swiftgs::test::camera_layouts_test {

using nlohmann::json;

namespace {

/// A camera at (1, 2, 3) without a turn, with OpenGL's axes.
const json matrix = {{1, 0, 0, 1}, {0, 1, 0, 2}, {0, 0, 1, 3}, {0, 0, 0, 1}};

/// A transforms.json with these members around its frames and in each of them.
json transforms(const std::string& members, const Strings& frames = {R"("file_path": "a.png")"}) {
  json file = json::parse("{" + members + "}");
  for (const std::string& frame : frames) {
    file["frames"].push_back(json::parse("{" + frame + "}"));
    file["frames"].back()["transform_matrix"] = matrix;
  }
  return file;
}

/// A cameras.json of INRIA's keys and these.
json inria(const std::string& members = "") {
  const std::string keys =
      R"([{"id": 0, "img_name": "a", "width": 640, "height": 480, "fx": 500, "fy": 510, "position": [1, 2, 3],
           "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]])";
  return json::parse(keys + (members.empty() ? "" : ", ") + members + "}]");
}

CameraFile read(const json& file, const std::string& name = "transforms.json") {
  const TemporaryFolder folder;
  return read_cameras(folder.write(name, file.dump()));
}

/// What is wrong with it, without the folder.
std::string refusal(const json& file, const std::string& name = "transforms.json") {
  const std::string told = complaint([&] { read(file, name); });
  return told.substr(told.find(name));
}

void check_pose(const Camera& camera) {
  CHECK(camera.centre() == dvec3(1, 2, 3));
  CHECK(camera.rotation * dvec3(0, 1, 0) == dvec3(0, -1, 0));
  CHECK(camera.rotation * dvec3(0, 0, -1) == dvec3(0, 0, 1));
}

/// Notes of keys that were not read.
Strings unread(const std::string& keys) {
  if (keys.empty()) return {};
  return {"Keys that may change the picture were not read: " + keys + "."};
}

const double of_height = 240 * std::sqrt(3.0);  ///< focal length for 60 degrees over 480 pixels
const std::string polycam_keys =
    R"("file_path": "./images/frame_00001.jpg", "depth_file_path": "./depth/frame_00001.png", )";
const std::string size_and_length = R"("fl_x": 500, "w": 640, "h": 480)";
const std::string not_rolling =
    size_and_length + R"(, "rolling_shutter": [0, 0, 0, 0], "fix_premult": false)";
const std::string rolling = size_and_length + R"(, "rolling_shutter": [0, 0, 0, 1])";

}  // namespace

TEST_CASE("camera layouts: transforms of other programs are pinholes with these numbers and notes") {
  const struct {
    const char* program;
    json file;
    std::string unread{};
    std::vector<Intrinsics> expected = {{640, 480, 500, 500, 320, 240}};
  } cases[] = {
      {"nerfstudio 1.1.5, ns-process-data polycam: intrinsics of each frame and none around them",
       transforms(R"("camera_model": "OPENCV", "orientation_override": "none", "ply_file_path": "cloud.ply")",
                  {polycam_keys + R"("fl_x": 640, "fl_y": 650, "cx": 321, "cy": 160, "w": 640, "h": 320)",
                   polycam_keys + R"("fl_x": 320, "fl_y": 330, "cx": 161, "cy": 80, "w": 320, "h": 160)"}),
       "",
       {{640, 320, 640, 650, 321, 160}, {320, 160, 320, 330, 161, 80}}},
      {"instant-ngp 2.0, scripts/colmap2nerf.py: angles beside focal lengths",
       transforms(R"("camera_angle_x": 1.1, "camera_angle_y": 0.9, "fl_x": 500.0, "fl_y": 510.0, "k1": 0,
                     "k2": 0, "k3": 0, "k4": 0, "p1": 0, "p2": 0, "is_fisheye": false, "cx": 321.0,
                     "cy": 239.0, "w": 640.0, "h": 480.0, "aabb_scale": 16)",
                  {R"("file_path": "./images/0001.jpg", "sharpness": 25.0)"}),
       "",
       {{640, 480, 500, 510, 321, 239}}},
      {"instant-ngp 2.0, src/nerf_loader.cu: angles in degrees",
       transforms(R"("x_fov": 90, "y_fov": 60, "w": 640, "h": 480)"),
       "",
       {{640, 480, 320, of_height, 320, 240}}},
      {"the same: one angle for both axes",
       transforms(R"("y_fov": 60, "w": 640, "h": 480)"),
       "",
       {{640, 480, of_height, of_height, 320, 240}}},
      {"COLMAP's names of a converter: FOV without an angle",
       transforms(size_and_length + R"(, "camera_model": "FOV", "alpha": null, "beta": 1, "omega": 0)")},
      {"instant-ngp 2.0, src/nerf_loader.cu: keys that place cameras elsewhere",
       transforms(not_rolling + R"(, "sharpen": null, "scale": 0.5, "offset": [0.5, 0.5, 0.5])"),
       "offset, scale"},
      {"the same: keys that move cameras while they expose",
       transforms(rolling, {R"("file_path": "a", "transform_matrix_start": 1, "transform_matrix_end": 1)"}),
       "rolling_shutter, transform_matrix_end, transform_matrix_start"},
      {"instant-ngp's paths of video frames: no images and so no names", transforms(size_and_length, {""})},
      {"D-NeRF's scenes of Blender, 2021: a time for each frame",
       transforms(R"("camera_angle_x": 1.0, "w": 64, "h": 64)",
                  {R"("file_path": "./train/r_000", "rotation": 0.01, "time": 0.5)"}),
       "time",
       {{64, 64, 32 / std::tan(0.5), 32 / std::tan(0.5), 32, 32}}}};
  for (const auto& [program, file, keys, expected] : cases) {
    CAPTURE(program);
    const CameraFile found = read(file);
    CHECK(found.notes == unread(keys));
    REQUIRE(found.cameras.size() == expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      check_intrinsics(found.cameras[i], expected[i]);
      check_pose(found.cameras[i]);
      CHECK(found.cameras[i].lens.is_pinhole());
      CHECK(found.cameras[i].name == file["frames"][i].value("file_path", ""));
    }
  }
}

TEST_CASE("camera layouts: files that no camera can be made of are refused by name") {
  const std::string other = "or the folder of a COLMAP model, found a JSON object with ";
  const std::string no_inria =
      "x.json: byte 1: expected a camera with 'img_name', as INRIA's cameras.json has, found the keys ";
  json no_matrix = transforms(rolling, {R"("transform_matrix_start": 1, "transform_matrix_end": 1)"});
  no_matrix["frames"][0].erase("transform_matrix");
  const struct {
    const char* program;
    json file;
    std::string expected;
  } cases[] = {
      {"nerfstudio 1.1.5, ns-export cameras: poses alone",
       R"([{"file_path": "a.jpg", "transform": [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3]]}])"_json,
       no_inria + "file_path, transform"},
      {"Record3D's metadata.json",
       R"({"w": 4, "h": 3, "fps": 60, "K": [1, 0, 0, 0, 1, 0, 2, 2, 1], "poses": [[0, 0, 0, 1]]})"_json,
       other + "the keys K, fps, h, poses, w"},
      {"the supersplat-viewer's settings.json",
       R"({"version": 2, "cameras": [{"initial": {"fov": 60}}], "animTracks": []})"_json,
       other + "the keys animTracks, cameras, version"},
      {"nothing", json::object(), other + "no keys"},
      {"instant-ngp", transforms(R"("y_fov": 180, "w": 640, "h": 480)"),
       "an angle above 0 and below pi (180 degrees) in 'y_fov'"},
      {"a rolling shutter alone", no_matrix, "expected a frame with 'transform_matrix'"},
      {"neither a size nor a name", transforms(R"("fl_x": 500, "h": 480)", {""}),
       "expected a frame with 'file_path'"},
      {"a trainer's FOV", inria(R"("camera_model": "FOV", "omega": 0.9)"),
       "x.json: byte 1: expected one of the camera models"}};
  for (const auto& [program, file, expected] : cases)
    CHECK_MESSAGE(contains(refusal(file, "x.json"), expected), program);
  CHECK(refusal(json::object(), "x.json")
            .starts_with("x.json: byte 0: expected cameras: INRIA's cameras.json"));
}

// nerfstudio 1.1.5, the viewer's render panel, and the older viewer without `default_fov`.
TEST_CASE("camera layouts: a path of nerfstudio's viewer is a view for each frame") {
  json path = R"({"default_fov": 75.0, "default_transition_sec": 2.0, "camera_type": "perspective",
                  "keyframes": [{"matrix": [], "fov": 75.0, "aspect": 2.0}], "render_height": 48,
                  "render_width": 64, "fps": 24, "seconds": 2.0, "is_cycle": false, "smoothness_value": 0.0,
                  "crop": null})"_json;
  for (const double fov : {90.0, 60.0})
    path["camera_path"].push_back({{"camera_to_world", {1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1}},
                                   {"fov", fov},
                                   {"aspect", 2.0}});
  CameraFile found = read(path, "camera_path.json");
  REQUIRE(found.cameras.size() == 2);
  CHECK(found.frames_a_second == 24);
  CHECK(found.notes.empty());
  // The angle is that of the height.
  check_intrinsics(found.cameras[0], {64, 48, 24, 24, 32, 24});
  check_intrinsics(found.cameras[1], {64, 48, 24 * std::sqrt(3.0), 24 * std::sqrt(3.0), 32, 24});
  for (const Camera& camera : found.cameras) {
    check_pose(camera);
    CHECK(camera.name.empty());
    CHECK(camera.lens.is_pinhole());
  }
  path.erase("camera_type");
  CHECK(read(path, "camera_path.json").cameras.at(0).lens.is_pinhole());
  path["camera_type"] = "fisheye";
  found = read(path, "camera_path.json");
  CHECK(found.cameras.at(0).lens == Lens{LensModel::fisheye, {}});
  check_intrinsics(found.cameras[0], {64, 48, 24, 24, 32, 24});
  check_pixel(found.cameras[0], {0, 3, 3}, {32, 24 + 24 * std::atan(1.0)});
  path["camera_type"] = "equirectangular";
  found = read(path, "camera_path.json");
  CHECK(found.cameras.at(1).lens == Lens{LensModel::equirectangular, {}});
  check_pixel(found.cameras[1], {3, 0, 0}, {48, 24});
  check_pixel(found.cameras[1], {0, -1, 1}, {32, 12});

  path["fps"] = 12.5;
  CHECK(read(path, "camera_path.json").frames_a_second == 12.5);
  path["fps"] = 0;
  CHECK(contains(refusal(path, "camera_path.json"), "expected 'fps' to be above 0"));
  path.erase("fps");
  CHECK(read(path, "camera_path.json").frames_a_second == 24);

  path["crop"] = {{"crop_center", {0, 0, 0}}}, path["camera_path"][1]["render_time"] = 0.5;
  CHECK(read(path, "camera_path.json").notes == unread("crop, render_time"));
}

TEST_CASE("camera layouts: what is wrong in a path is placed") {
  const json good =
      R"({"camera_type": "perspective", "render_height": 48, "render_width": 64, "camera_path": [
          {"camera_to_world": [1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1], "fov": 90.0}]})"_json;
  CHECK(read(good, "camera_path.json").cameras.size() == 1);
  const std::string root = "camera_path.json: byte 0: expected ", frame_key = "/camera_path/0/";
  const std::string frame =
      "camera_path.json: byte " + std::to_string(good.dump().find("{\"camera_to_world\"")) + ": expected ";
  const std::string types = root + "'camera_type' to be perspective, fisheye or equirectangular, found ";
  const struct {
    std::string place;
    json value;
    std::string expected;
  } cases[] = {{"/camera_type", "omnidirectional", types + "omnidirectional"},
               {"/camera_type", "vr180", types + "vr180"},
               {"/camera_type", "", types},
               {"/camera_path", 7, root + "'camera_path' to be an array"},
               {"/camera_path", json::array({7}), frame + "a frame (a JSON object)"},
               {"/render_height", nullptr, root + "a number in 'render_height'"},
               {frame_key + "fov", nullptr, frame + "a number in 'fov'"},
               {frame_key + "fov", 180, frame + "an angle above 0 and below pi (180 degrees) in 'fov'"},
               {frame_key + "camera_to_world", {1, 2, 3}, frame + "sixteen numbers in 'camera_to_world'"},
               {frame_key + "camera_to_world", 7, frame + "sixteen numbers in 'camera_to_world'"},
               {frame_key + "camera_to_world/14", 1, frame + "a last row of 0, 0, 0, 1 in 'camera_to_world'"},
               {frame_key + "camera_to_world/11", "3", frame + "a number in 'camera_to_world'"}};
  const auto changed = [&](const std::string& place, const json& value) {
    json file = good;
    file[json::json_pointer(place)] = value;
    return refusal(file, "camera_path.json");
  };
  for (const auto& [place, value, expected] : cases) CHECK(changed(place, value) == expected);
  CHECK(contains(changed("/render_width", 0), root + "a width and a height"));
  CHECK(contains(changed(frame_key + "camera_to_world/0", 2), "orthonormal rows"));
}

// gaussian-splatting-lightning, internal/dataset.py, and GauStudio of 2025: INRIA's keys and principal
// points. INRIA's own, and OpenSplat 1.1.5's, have none.
TEST_CASE("camera layouts: principal points that other trainers add to cameras.json count") {
  const struct {
    std::string members;
    Intrinsics expected;
    std::string unread;
  } cases[] = {{R"("cx": 300.5, "cy": 250, "time": null, "appearance_id": null,
                   "normalized_appearance_id": null)",
                {640, 480, 500, 510, 300.5, 250},
                ""},
               {R"("cx": null, "cy": null, "appearance_id": 3, "normalized_appearance_id": 0.25)",
                {640, 480, 500, 510, 320, 240},
                "appearance_id, normalized_appearance_id"},
               {"", {640, 480, 500, 510, 320, 240}, ""}};
  for (const auto& [members, expected, keys] : cases) {
    const CameraFile found = read(inria(members), "cameras.json");
    CHECK(found.notes == unread(keys));
    check_intrinsics(found.cameras.at(0), expected);
  }
}

TEST_CASE("camera layouts: lenses that other trainers add to cameras.json count") {
  json file = inria(R"("k1": -0.1, "k2": 0.02, "p1": 0.003, "p2": -0.004)");
  file.push_back(inria()[0]);
  const CameraFile found = read(file, "cameras.json");
  CHECK(found.notes.empty());
  CHECK(found.cameras.at(0).lens ==
        Lens{LensModel::perspective, {.radial = {-0.1, 0.02}, .tangential = {0.003, -0.004}}});
  CHECK(found.cameras.at(1).lens.is_pinhole());
  file[0]["camera_model"] = "OPENCV_FISHEYE", file[1]["camera_model"] = "EQUIRECTANGULAR";
  const std::vector<Camera> others = read(file, "cameras.json").cameras;
  CHECK(others.at(0).lens.model == LensModel::fisheye);
  check_pixel(others.at(1), {1, 0, 0}, {480, 240});
}

TEST_CASE("camera layouts: files that are no cameras are told by what they are") {
  const TemporaryFolder folder;
  const auto found = [&](const std::string& name, const std::string& content) {
    const std::string told = complaint([&] { read_cameras(folder.write(name, content)); });
    const std::string before = "or the folder of a COLMAP model, found ";
    return contains(told, name + ": byte 0: expected cameras: INRIA's cameras.json")
               ? told.substr(told.find(before) + before.size())
               : told;
  };
  const std::string cases[][3] = {
      {"a.ply", "ply\nformat", "a PLY"},
      {"a.glb", "glTF", "a glTF"},
      {"a.splat", std::string(32, '\1'), "a .splat"},
      {"lod-meta.json", R"({"lodLevels": 1, "filenames": []})", "a streamed SOG"},
      {"list.json", R"([{"file": "a.ply"}])", "a list of scenes"},
      {"cameras.txt", "# Camera list\n", "a file of a COLMAP model, which is read by its folder"},
      {"cameras.bin", std::string(8, '\0'), "a file of a COLMAP model, which is read by its folder"},
      {"a.db", "SQLite format 3",
       "a database; of COLMAP, give the folder of a model that it wrote, such as sparse/0"},
      {"a.xml", "<?xml version=\"1.0\"?>\n<document><chunk label=\"1\">",
       "cameras of Metashape; export them as a COLMAP model"},
      {"bundle.out", "# Bundle file v0.3\n", "a model of Bundler; convert it with 'colmap model_converter'"},
      {"a.json", "// by hand\n[]", "a text that begins with a comment, which JSON has not"},
      {"a.json", "\xff\xfe[", "a text in UTF-16; save it in UTF-8"},
      {"a.json", "", "an empty file"},
      {"a.txt", "frame 1", "something else"}};
  for (const auto& [name, content, expected] : cases) CHECK(found(name, content) == expected);
  CHECK(contains(found("a.json", "[ // the first\n {}]"),
                 "a.json: byte 2: expected valid JSON, which has no comments"));
}

// Editors of Windows and PowerShell write the mark.
TEST_CASE("camera layouts: a byte order mark before JSON changes nothing but places") {
  const std::string mark = "\xef\xbb\xbf", path = R"({"camera_type": "perspective", "render_width": 64,
      "render_height": 48, "camera_path": [{"fov": 50, "camera_to_world": [1,0,0,1, 0,1,0,2, 0,0,1,3, 0,0,0,1]}]})";
  const TemporaryFolder folder;
  for (const std::string& content : {transforms(size_and_length).dump(), inria().dump(), path})
    for (const std::string blanks : {"", " \r\n"}) {
      const auto cameras = load_cameras(folder.write("c.json", mark + blanks + content));
      REQUIRE(cameras.size() == 1);
      CHECK(cameras[0].centre() == dvec3(1, 2, 3));
    }
  const std::string change = R"({"transform": [[1, 0, 0, 10], [0, 1, 0, 0], [0, 0, 1, 0]], "scale": 1})";
  folder.write("dataparser_transforms.json", mark + change);
  CHECK(load_cameras(folder.write("c.json", mark + transforms(size_and_length).dump())).at(0).centre() ==
        dvec3(11, 2, 3));
  CHECK(complaint([&] {
          load_cameras(folder.write("c.json", mark + "[{}]"));
        }).find("c.json: byte 4: expected a camera") != std::string::npos);
}

TEST_CASE("camera layouts: COLMAP's models without coefficients, and forks' names, are lenses of JSON") {
  for (const char* name : {"SIMPLE_FISHEYE", "FISHEYE"}) {
    json file = transforms(size_and_length);
    file["camera_model"] = name;
    CHECK(read(file).cameras.at(0).lens == Lens{LensModel::fisheye, {}});
  }
  json file = transforms(R"("w": 640, "h": 480, "camera_model": "SPHERICAL")");
  CHECK(read(file).cameras.at(0).lens == Lens{LensModel::equirectangular, {}});
}

}  // namespace swiftgs::test::camera_layouts_test
