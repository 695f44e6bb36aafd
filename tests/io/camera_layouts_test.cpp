// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <swiftgs/io/cameras.hpp>

#include "colmap_files.hpp"
#include "lens_pixels.hpp"

/// @file
/// What other programs write about cameras, each in a few lines: read with the right values, noted or refused
/// by name.

using namespace swiftgs;
using namespace swiftgs::test;
using nlohmann::json;

namespace {

/// A camera at (1, 2, 3) without a turn, with OpenGL's axes.
const json matrix = {{1, 0, 0, 1}, {0, 1, 0, 2}, {0, 0, 1, 3}, {0, 0, 0, 1}};

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

void check_intrinsics(const Camera& camera, int width, int height, double fx, double fy, double cx,
                      double cy) {
  CHECK(camera.width == width);
  CHECK(camera.height == height);
  CHECK(camera.fx == doctest::Approx(fx));
  CHECK(camera.fy == doctest::Approx(fy));
  CHECK(camera.cx == doctest::Approx(cx));
  CHECK(camera.cy == doctest::Approx(cy));
}

json inria_camera() {
  return {{"id", 0},
          {"img_name", "a"},
          {"width", 640},
          {"height", 480},
          {"fx", 500},
          {"fy", 510},
          {"position", {1, 2, 3}},
          {"rotation", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
}

}  // namespace

// nerfstudio 1.1.5, ns-process-data polycam: intrinsics of each frame and none around them.
TEST_CASE("camera layouts: frames of Polycam in nerfstudio have intrinsics of their own") {
  json file = {
      {"camera_model", "OPENCV"}, {"orientation_override", "none"}, {"ply_file_path", "point_cloud.ply"}};
  for (const int size : {640, 320})
    file["frames"].push_back({{"fl_x", size},
                              {"fl_y", size + 10},
                              {"cx", size / 2 + 1},
                              {"cy", size / 4},
                              {"w", size},
                              {"h", size / 2},
                              {"file_path", "./images/frame_00001.jpg"},
                              {"depth_file_path", "./depth/frame_00001.png"},
                              {"transform_matrix", matrix}});
  const CameraFile found = read(file);
  REQUIRE(found.cameras.size() == 2);
  CHECK(found.notes.empty());
  check_intrinsics(found.cameras[0], 640, 320, 640, 650, 321, 160);
  check_intrinsics(found.cameras[1], 320, 160, 320, 330, 161, 80);
  check_pose(found.cameras[1]);
}

// nerfstudio 1.1.5, ns-process-data realitycapture: coefficients of each frame; metashape: around the frames.
TEST_CASE("camera layouts: nerfstudio tells distortion of a frame or of all") {
  json file = {{"camera_model", "OPENCV"}, {"orientation_override", "none"}, {"w", 64}, {"h", 48}};
  const json frame = {{"fl_x", 50}, {"file_path", "images/a.jpg"}, {"transform_matrix", matrix}};
  file["frames"] = {frame, frame};
  for (const char* key : {"k1", "k2", "k3", "k4", "p1", "p2"}) file["frames"][1][key] = 0.0;
  CHECK(read(file).cameras.at(1).lens.is_pinhole());
  file["frames"][1]["k3"] = 1e-4, file["k4"] = -0.5;
  const CameraFile found = read(file);
  CHECK(found.notes.empty());
  CHECK(found.cameras.at(0).lens.distortion == Distortion{.radial = {0, 0, 0, -0.5}});
  CHECK(found.cameras.at(1).lens.distortion == Distortion{.radial = {0, 0, 1e-4, 0}});
}

// nerfstudio 1.1.5, ns-process-data images: a turned world, which a scene trained on it does not have.
TEST_CASE("camera layouts: a world that nerfstudio turned is noted unless the turn back is there") {
  json file = {{"w", 64}, {"h", 48}, {"fl_x", 50}, {"k1", 0}, {"camera_model", "OPENCV"}};
  file["applied_transform"] = {{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}};
  file["frames"] = {
      {{"file_path", "images/frame_00001.jpg"}, {"colmap_im_id", 1}, {"transform_matrix", matrix}}};
  const TemporaryFolder folder;
  const auto path = folder.write("transforms.json", file.dump());
  CameraFile found = read_cameras(path);
  check_pose(found.cameras.at(0));
  REQUIRE(found.notes.size() == 1);
  CHECK(contains(found.notes[0], "put its dataparser_transforms.json beside the file"));
  folder.write("dataparser_transforms.json",
               R"({"transform": [[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0]], "scale": 2})");
  found = read_cameras(path);
  CHECK(found.notes.empty());
  CHECK(found.cameras.at(0).centre() == dvec3(2, 4, 6));
}

// nerfstudio 1.1.5, ns-export cameras: poses alone.
TEST_CASE("camera layouts: poses without intrinsics are refused with their keys") {
  const json pose = {{"file_path", "a.jpg"}, {"transform", {{1, 0, 0, 1}, {0, 1, 0, 2}, {0, 0, 1, 3}}}};
  CHECK(
      refusal(json::array({pose}), "transforms_train.json") ==
      "transforms_train.json: byte 1: expected a camera with 'img_name', as INRIA's cameras.json has, found "
      "the keys file_path, transform");
}

// instant-ngp 2.0, scripts/colmap2nerf.py.
TEST_CASE("camera layouts: instant-ngp's own converter writes angles beside focal lengths") {
  json file = {{"camera_angle_x", 1.1},
               {"camera_angle_y", 0.9},
               {"fl_x", 500.0},
               {"fl_y", 510.0},
               {"k1", 0},
               {"k2", 0},
               {"k3", 0},
               {"k4", 0},
               {"p1", 0},
               {"p2", 0},
               {"is_fisheye", false},
               {"cx", 321.0},
               {"cy", 239.0},
               {"w", 640.0},
               {"h", 480.0},
               {"aabb_scale", 16}};
  file["frames"] = {{{"file_path", "./images/0001.jpg"}, {"sharpness", 25.0}, {"transform_matrix", matrix}}};
  const CameraFile found = read(file);
  CHECK(found.notes.empty());
  check_intrinsics(found.cameras.at(0), 640, 480, 500, 510, 321, 239);
  check_pose(found.cameras.at(0));
}

// instant-ngp 2.0, src/nerf_loader.cu: angles in degrees, and one angle for both axes.
TEST_CASE("camera layouts: instant-ngp takes angles in degrees") {
  json file = {{"x_fov", 90}, {"y_fov", 60}, {"w", 640}, {"h", 480}};
  file["frames"] = {{{"file_path", "a.png"}, {"transform_matrix", matrix}}};
  const double of_height = 240 * std::sqrt(3.0);
  check_intrinsics(read(file).cameras.at(0), 640, 480, 320, of_height, 320, 240);
  file.erase("x_fov");
  check_intrinsics(read(file).cameras.at(0), 640, 480, of_height, of_height, 320, 240);
  file["y_fov"] = 180;
  CHECK(contains(refusal(file), "an angle above 0 and below pi (180 degrees) in 'y_fov'"));
}

// nerfstudio 1.1.5, ns-process-data aria: a lens with two more coefficients than a thin prism.
TEST_CASE("camera layouts: Project Aria's lens is refused by name") {
  json file = {{"camera_model", "FISHEYE624"}, {"fisheye_crop_radius", 707.5}};
  file["frames"] = {{{"fl_x", 610},
                     {"fl_y", 610},
                     {"cx", 704},
                     {"cy", 704},
                     {"w", 1408},
                     {"h", 1408},
                     {"distortion_params", {0.4, -0.4, 0.1, 0.1, -0.1, 0.01, 0.001, 0, 0, 0, 0, 0}},
                     {"file_path", "images/camera-rgb_1.jpg"},
                     {"transform_matrix", matrix}}};
  CHECK(contains(refusal(file), "found FISHEYE624"));
}

// nerfstudio 1.1.5, the viewer's render panel, and the older viewer without `default_fov`.
TEST_CASE("camera layouts: a path of nerfstudio's viewer is a view for each frame") {
  json path = {{"default_fov", 75.0},
               {"default_transition_sec", 2.0},
               {"keyframes", {{{"matrix", json::array()}, {"fov", 75.0}, {"aspect", 2.0}}}},
               {"camera_type", "perspective"},
               {"render_height", 48},
               {"render_width", 64},
               {"fps", 24},
               {"seconds", 2.0},
               {"is_cycle", false},
               {"smoothness_value", 0.0},
               {"crop", nullptr}};
  for (const double fov : {90.0, 60.0})
    path["camera_path"].push_back({{"camera_to_world", {1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1}},
                                   {"fov", fov},
                                   {"aspect", 2.0}});
  CameraFile found = read(path, "camera_path.json");
  REQUIRE(found.cameras.size() == 2);
  CHECK(found.notes.empty());
  // The angle is that of the height.
  check_intrinsics(found.cameras[0], 64, 48, 24, 24, 32, 24);
  check_intrinsics(found.cameras[1], 64, 48, 24 * std::sqrt(3.0), 24 * std::sqrt(3.0), 32, 24);
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
  check_intrinsics(found.cameras[0], 64, 48, 24, 24, 32, 24);
  check_pixel(found.cameras[0], {0, 3, 3}, {32, 24 + 24 * std::atan(1.0)});
  path["camera_type"] = "equirectangular";
  found = read(path, "camera_path.json");
  CHECK(found.cameras.at(1).lens == Lens{LensModel::equirectangular, {}});
  check_pixel(found.cameras[1], {3, 0, 0}, {48, 24});
  check_pixel(found.cameras[1], {0, -1, 1}, {32, 12});

  path["crop"] = {{"crop_center", {0, 0, 0}}}, path["camera_path"][1]["render_time"] = 0.5;
  CHECK(read(path, "camera_path.json").notes ==
        std::vector<std::string>{"Keys that may change the picture were not read: crop, render_time."});
}

TEST_CASE("camera layouts: what is wrong in a path is placed") {
  const json good = {
      {"camera_type", "perspective"},
      {"render_height", 48},
      {"render_width", 64},
      {"camera_path",
       {{{"camera_to_world", {1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1}}, {"fov", 90.0}}}}};
  const auto with = [&](const char* key, const json& value) {
    json changed = good;
    changed[key] = value;
    return refusal(changed, "camera_path.json");
  };
  const auto frame_with = [&](const char* key, const json& value) {
    json changed = good;
    changed["camera_path"][0][key] = value;
    return refusal(changed, "camera_path.json");
  };
  const std::string root = "camera_path.json: byte 0: expected ";
  const std::string frame =
      "camera_path.json: byte " + std::to_string(good.dump().find("{\"camera_to_world\"")) + ": expected ";
  CHECK(read(good, "camera_path.json").cameras.size() == 1);
  for (const char* type : {"omnidirectional", "vr180", ""})
    CHECK(with("camera_type", type) ==
          root + "'camera_type' to be perspective, fisheye or equirectangular, found " + type);
  CHECK(with("camera_path", 7) == root + "'camera_path' to be an array");
  CHECK(with("camera_path", {7}) == frame + "a frame (a JSON object)");
  CHECK(contains(with("render_width", 0), root + "a width and a height"));
  CHECK(with("render_height", nullptr) == root + "a number in 'render_height'");
  CHECK(frame_with("fov", nullptr) == frame + "a number in 'fov'");
  CHECK(frame_with("fov", 180) == frame + "an angle above 0 and below pi (180 degrees) in 'fov'");
  CHECK(frame_with("camera_to_world", {1, 2, 3}) == frame + "sixteen numbers in 'camera_to_world'");
  CHECK(frame_with("camera_to_world", 7) == frame + "sixteen numbers in 'camera_to_world'");
  CHECK(frame_with("camera_to_world", {1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3, 0, 0, 1, 1}) ==
        frame + "a last row of 0, 0, 0, 1 in 'camera_to_world'");
  CHECK(frame_with("camera_to_world", {1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, "3", 0, 0, 0, 1}) ==
        frame + "a number in 'camera_to_world'");
  CHECK(contains(frame_with("camera_to_world", {2, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1}),
                 "orthonormal rows"));
  check_every_truncation(good.dump(), [](const std::string& content) {
    io::parse_camera_path({as_bytes(content), "camera_path.json"});
  });
}

// COLMAP's names, in a file that a converter writes: FOV without an angle and EUCM without a share of the
// sphere are pinholes.
TEST_CASE("camera layouts: models of one coefficient are refused unless it is 0") {
  json file = {{"camera_model", "EUCM"}, {"alpha", 0}, {"beta", 1}, {"fl_y", 500}, {"w", 640}, {"h", 480}};
  file["frames"] = {{{"file_path", "a.png"}, {"transform_matrix", matrix}}};
  CHECK(read(file).notes.empty());
  check_intrinsics(read(file).cameras.at(0), 640, 480, 500, 500, 320, 240);
  file["alpha"] = 0.5;
  CHECK(contains(refusal(file), "found EUCM with alpha = 0.5"));
  file["alpha"] = nullptr, file["camera_model"] = "FOV", file["omega"] = 0;
  CHECK(read(file).notes.empty());
  file["omega"] = 0.9;
  CHECK(contains(refusal(file), "found FOV with omega = 0.9"));
  file["omega"] = nullptr, file["fl_y"] = nullptr;
  CHECK(contains(
      refusal(file),
      "a focal length above 0 in 'fl_x', 'fl_y', 'x_fov', 'y_fov', 'camera_angle_x' or 'camera_angle_y'"));
}

// instant-ngp 2.0, src/nerf_loader.cu: keys that place cameras elsewhere, or move them while they expose.
TEST_CASE("camera layouts: what instant-ngp does to cameras beyond a pinhole is noted or refused") {
  json file = {{"fl_x", 500}, {"w", 640}, {"h", 480}, {"scale", 0.5}, {"offset", {0.5, 0.5, 0.5}}};
  file["rolling_shutter"] = {0, 0, 0, 0}, file["fix_premult"] = false, file["sharpen"] = nullptr;
  file["frames"] = {{{"file_path", "a.png"}, {"transform_matrix", matrix}}};
  CHECK(read(file).notes ==
        std::vector<std::string>{"Keys that may change the picture were not read: offset, scale."});
  file.erase("offset"), file.erase("scale");
  CHECK(read(file).notes.empty());
  json rolling = file;
  rolling["rolling_shutter"] = {0, 0, 0, 1};
  rolling["frames"][0]["transform_matrix_start"] = rolling["frames"][0]["transform_matrix_end"] = matrix;
  CHECK(read(rolling).notes ==
        std::vector<std::string>{"Keys that may change the picture were not read: rolling_shutter, "
                                 "transform_matrix_end, transform_matrix_start."});
  rolling["frames"][0].erase("transform_matrix");
  CHECK(contains(refusal(rolling), "expected a frame with 'transform_matrix'"));
  file["from_mitsuba"] = true;
  CHECK(contains(refusal(file), "found 'from_mitsuba'"));
}

// instant-ngp's paths of video frames have no images, and so no names.
TEST_CASE("camera layouts: a frame without a name is a camera") {
  json file = {{"fl_x", 500}, {"w", 640}, {"h", 480}, {"frames", {{{"transform_matrix", matrix}}}}};
  const CameraFile found = read(file);
  REQUIRE(found.cameras.size() == 1);
  CHECK(found.cameras[0].name.empty());
  check_pose(found.cameras[0]);
  file.erase("w");
  CHECK(contains(refusal(file), "expected a frame with 'file_path'"));
}

// D-NeRF's scenes of Blender, 2021: a time for each frame.
TEST_CASE("camera layouts: a time of a frame is noted") {
  json file = {{"camera_angle_x", 1.0}, {"w", 64}, {"h", 64}};
  for (const double time : {0.0, 0.5})
    file["frames"].push_back(
        {{"file_path", "./train/r_000"}, {"rotation", 0.01}, {"time", time}, {"transform_matrix", matrix}});
  CHECK(read(file).notes ==
        std::vector<std::string>{"Keys that may change the picture were not read: time."});
}

// gaussian-splatting-lightning, internal/dataset.py, and GauStudio of 2025: INRIA's keys and principal
// points.
TEST_CASE("camera layouts: principal points that other trainers add to cameras.json count") {
  json camera = inria_camera();
  camera["cx"] = 300.5, camera["cy"] = 250;
  camera["time"] = nullptr, camera["appearance_id"] = nullptr, camera["normalized_appearance_id"] = nullptr;
  CameraFile found = read(json::array({camera}), "cameras.json");
  CHECK(found.notes.empty());
  check_intrinsics(found.cameras.at(0), 640, 480, 500, 510, 300.5, 250);
  camera["appearance_id"] = 3, camera["normalized_appearance_id"] = 0.25;
  CHECK(read(json::array({camera}), "cameras.json").notes ==
        std::vector<std::string>{
            "Keys that may change the picture were not read: appearance_id, normalized_appearance_id."});
  camera["cx"] = camera["cy"] = nullptr;
  check_intrinsics(read(json::array({camera}), "cameras.json").cameras.at(0), 640, 480, 500, 510, 320, 240);
  // INRIA's own, and OpenSplat 1.1.5's.
  found = read(json::array({inria_camera()}), "cameras.json");
  CHECK(found.notes.empty());
  check_intrinsics(found.cameras.at(0), 640, 480, 500, 510, 320, 240);
}

TEST_CASE("camera layouts: lenses that other trainers add to cameras.json count") {
  json camera = inria_camera();
  camera["k1"] = -0.1, camera["k2"] = 0.02, camera["p1"] = 0.003, camera["p2"] = -0.004;
  CameraFile found = read(json::array({camera, inria_camera()}), "cameras.json");
  CHECK(found.notes.empty());
  CHECK(found.cameras.at(0).lens ==
        Lens{LensModel::perspective, {.radial = {-0.1, 0.02}, .tangential = {0.003, -0.004}}});
  CHECK(found.cameras.at(1).lens.is_pinhole());
  const dvec3 p(0.5, 0.25, 1);
  const double scale = radial({-0.1, 0.02}, {0.5, 0.25});
  const Pixel aside = tangential(0.003, -0.004, {0.5, 0.25});
  check_pixel(found.cameras[0], p,
              {320 + 500 * (0.5 * scale + aside.x), 240 + 510 * (0.25 * scale + aside.y)});
  camera["camera_model"] = "OPENCV_FISHEYE";
  CHECK(read(json::array({camera}), "cameras.json").cameras.at(0).lens.model == LensModel::fisheye);
  camera = inria_camera();
  camera["camera_model"] = "EQUIRECTANGULAR";
  check_pixel(read(json::array({camera}), "cameras.json").cameras.at(0), {1, 0, 0}, {480, 240});
  camera["camera_model"] = "FOV", camera["omega"] = 0.9;
  CHECK(contains(refusal(json::array({camera}), "cameras.json"),
                 "cameras.json: byte 1: expected one of the camera models"));
}

// COLMAP 3.12: rigs and frames beside cameras and images, in sub-folders as its rig_configurator asks for.
TEST_CASE("camera layouts: rigs and frames of COLMAP change no image") {
  const TemporaryFolder folder;
  folder.write("sparse/0/rigs.bin", "rigs"), folder.write("sparse/0/frames.bin", "frames");
  folder.write("sparse/0/cameras.bin",
               cameras_bin({{}, {.id = 2, .model = 4, .parameters = {500, 510, 321, 239, 0, 0, 0, 0}}}));
  folder.write("sparse/0/images.bin",
               images_bin({{.name = "rig1/right/0001.jpg", .camera_id = 2}, {.name = "rig1/left/0001.jpg"}}));
  const CameraFile found = read_cameras(folder.path());
  CHECK(found.notes.empty());
  REQUIRE(found.cameras.size() == 2);
  CHECK(found.cameras[0].name == "rig1/left/0001.jpg");
  check_intrinsics(found.cameras[1], 640, 480, 500, 510, 321, 239);
}

// hierarchical-3d-gaussians, 2024, scripts for MatrixCity: "one line of data per image".
TEST_CASE("camera layouts: images of COLMAP in one line each are refused at the second") {
  const std::string head =
      "# Image list with one line of data per image:\n# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, "
      "NAME\n";
  const std::string told = complaint([&] {
    parse_text("1 PINHOLE 64 48 50 50 32 24\n",
               head + "1 1 0 0 0 0 0 0 1 0001.png\n2 1 0 0 0 0 0 0 1 0002.png\n");
  });
  CHECK(contains(told, "the 2D points of the image of line 3 in line 4"));
  CHECK(contains(told, "found 0002.png"));
}

// Mip-NeRF, scripts/convert_blender_data.py; Record3D's metadata.json; Nerfies' camera/000001.json; the
// supersplat-viewer's settings.json; Polycam's keyframes/corrected_cameras.
TEST_CASE("camera layouts: JSON of other layouts is refused with its keys") {
  const std::string expected =
      "x.json: byte 0: expected cameras: INRIA's cameras.json (a JSON array), a transforms.json (a JSON "
      "object with 'frames'), nerfstudio's camera_path.json (one with 'camera_path'), or the folder of a "
      "COLMAP model, found a JSON object with ";
  const json mip_nerf = {{"train", {{"file_path", {"a.png"}}, {"cam2world", {matrix}}, {"focal", {50}}}},
                         {"val", json::object()},
                         {"test", json::object()}};
  CHECK(refusal(mip_nerf, "x.json") == expected + "the keys test, train, val");
  const json record_3d = {{"w", 4},
                          {"h", 3},
                          {"fps", 60},
                          {"K", {1, 0, 0, 0, 1, 0, 2, 2, 1}},
                          {"poses", {{0, 0, 0, 1, 0, 0, 0}}}};
  CHECK(refusal(record_3d, "x.json") == expected + "the keys K, fps, h, poses, w");
  const json nerfies = {{"orientation", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                        {"position", {0, 0, 0}},
                        {"focal_length", 50.0},
                        {"skew", 0.0},
                        {"image_size", {64, 48}}};
  CHECK(refusal(nerfies, "x.json") ==
        expected + "the keys focal_length, image_size, orientation, position, skew");
  const json viewer = {
      {"version", 2}, {"cameras", {{{"initial", {{"fov", 60}}}}}}, {"animTracks", json::array()}};
  CHECK(refusal(viewer, "x.json") == expected + "the keys animTracks, cameras, version");
  const json polycam = {{"fx", 50.0}, {"fy", 50.0}, {"cx", 32.0}, {"cy", 24.0}, {"t_00", 1.0}};
  CHECK(refusal(polycam, "x.json") == expected + "the keys cx, cy, fx, fy, t_00");
  CHECK(refusal(json::object(), "x.json") == expected + "no keys");
}

// OpenSfM and OpenDroneMap, as OpenSplat 1.1.5 reads them: reconstruction.json.
TEST_CASE("camera layouts: a reconstruction of OpenSfM is refused with its keys") {
  const json file = {{{"cameras", json::object()}, {"shots", json::object()}, {"points", json::object()}}};
  CHECK(refusal(file, "reconstruction.json") ==
        "reconstruction.json: byte 1: expected a camera with 'img_name', as INRIA's cameras.json has, found "
        "the keys cameras, points, shots");
}
