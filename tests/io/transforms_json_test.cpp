// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <nlohmann/json.hpp>

#include "camera_files.hpp"
#include "camera_parsing.hpp"
#include "png_encoder.hpp"

namespace swiftgs::test::transforms_json_test {

using nlohmann::json;

namespace {

constexpr double pi = 3.14159265358979323846;

/// Camera to world with OpenGL's axes, as these files have it.
json matrix_of(const Camera& camera) {
  json rows = {{0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 1}};
  const dvec3 centre = camera.centre();
  for (int row = 0; row < 3; ++row) {
    rows[row][0] = camera.rotation[row][0];
    rows[row][1] = -camera.rotation[row][1];
    rows[row][2] = -camera.rotation[row][2];
    rows[row][3] = centre[row];
  }
  return rows;
}

const Camera camera_looking = look_at({1, 2, 3}, {-2, 0.5, 0.25}, {0.1, -0.2, 1}, 0.8, 640, 480);

/// `file` with other values, or new ones.
json with(json file, const json& members) {
  file.update(members);
  return file;
}

json frame(const std::string& path, const Camera& camera = camera_looking) {
  return {{"file_path", path}, {"transform_matrix", matrix_of(camera)}};
}

/// A file of two frames with the same intrinsics.
json some_file() {
  return {{"w", 640},
          {"h", 480.0},
          {"fl_x", 500},
          {"fl_y", 510.5},
          {"cx", 321},
          {"cy", 239.25},
          {"frames", {frame("images/b.jpg"), frame("./images/a.jpg")}}};
}

CameraFile parse_file(const json& file) {
  const std::string content = file.dump();
  return io::parse_transforms_json({as_bytes(content), "transforms.json"});
}
std::vector<Camera> parse(const json& file) { return parse_file(file).cameras; }

std::string complaint_about(const json& file) {
  return complaint([&] { parse(file); });
}

void check_near(const dvec3& found, const dvec3& expected) {
  for (int i = 0; i < 3; ++i) CHECK(found[i] == doctest::Approx(expected[i]).epsilon(1e-12));
}

void check_pose(const Camera& found, const Camera& expected) {
  check_near(found.translation, expected.translation);
  for (int i = 0; i < 3; ++i) check_near(found.rotation[i], expected.rotation[i]);
}

/// nerfstudio's: the rows of a turn and a move, and a scale.
const json turn = {{0, -1, 0, 10}, {1, 0, 0, 20}, {0, 0, 1, 30}};

std::vector<Camera> parse_in_model(const json& file, const json& dataparser) {
  const std::string content = file.dump(), change = dataparser.dump();
  const io::Source source{as_bytes(change), "dataparser_transforms.json"};
  return io::parse_transforms_json({as_bytes(content), "transforms.json"}, {}, &source).cameras;
}

/// What messages expect in place of a lens that is not read.
const std::string models =
    "transforms.json: byte 0: expected one of the camera models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, "
    "RADIAL, OPENCV, OPENCV_FISHEYE, FULL_OPENCV, SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE, THIN_PRISM_FISHEYE, "
    "SIMPLE_FISHEYE, FISHEYE, EQUIRECTANGULAR, ORTHOPHOTO, found ";

const json six = {{"k1", -0.11}, {"k2", 0.07}, {"k3", 0.023}, {"k4", -0.017}, {"p1", 0.013}, {"p2", -0.021}};

const Distortion of_six{.radial = {-0.11, 0.07, 0.023, -0.017}, .tangential = {0.013, -0.021}};

}  // namespace

TEST_CASE("transforms.json: content decides and cameras keep the order and the names of the file") {
  const TemporaryFolder folder;
  const auto cameras = load_cameras(folder.write("anything", std::string("\n").append(some_file().dump())));
  REQUIRE(cameras.size() == 2);
  CHECK(cameras[0].name == "images/b.jpg");
  CHECK(cameras[1].name == "./images/a.jpg");
  CHECK(cameras[1].height == 480);
  CHECK(cameras[1].fy == 510.5);
  check_pose(cameras[1], camera_looking);
  json three_rows = some_file();
  three_rows["frames"][0]["transform_matrix"].erase(3);
  check_pose(parse(three_rows).at(0), camera_looking);
  CHECK(load_cameras(folder.write("none.json", R"({"frames": []})")).empty());
}

TEST_CASE("transforms.json: what a frame has itself wins") {
  json file = some_file();
  file["frames"][1].update(R"({"w": 64, "h": 48, "fl_x": 50, "cx": 31})"_json);
  const auto cameras = parse(file);
  CHECK(intrinsics(cameras[0]) == Intrinsics{640, 480, 500, 510.5, 321, 239.25});
  CHECK(intrinsics(cameras[1]) == Intrinsics{64, 48, 50, 510.5, 31, 239.25});
  file["frames"][1]["fl_x"] = nullptr;
  CHECK(parse(file)[1].fx == 500);
  file["frames"][1]["fl_x"] = "50";
  CHECK(contains(complaint_about(file), "a number in 'fl_x'"));
  file["frames"][1].erase("fl_x");
  file["frames"][1]["camera_angle_x"] = 0.5 * pi;
  CHECK(parse(file)[1].fx == doctest::Approx(32));
}

TEST_CASE("transforms.json: angles of view stand for focal lengths and centres for principal points") {
  json file = some_file();
  for (const char* key : {"fl_x", "fl_y", "cx", "cy"}) file.erase(key);
  file["camera_angle_x"] = 2 * std::atan(0.5);
  check_intrinsics(parse(file).at(0), {640, 480, 640, 640, 320, 240});
  file["camera_angle_y"] = 0.5 * pi;
  check_intrinsics(parse(file).at(0), {640, 480, 640, 240, 320, 240});
  for (const double angle : {0.0, -1.0, pi, 7.0}) {
    file["camera_angle_x"] = angle;
    CHECK(contains(complaint_about(file), "an angle above 0 and below pi (180 degrees) in 'camera_angle_x'"));
  }
  file.erase("camera_angle_x");
  CHECK(parse(file).at(0).fx == doctest::Approx(240));
  file.erase("camera_angle_y");
  CHECK(contains(complaint_about(file), "in 'fl_x', 'fl_y', 'x_fov', 'y_fov', 'camera_angle_x' or "));
}

// What each of a lens's coefficients does is held by the tests of COLMAP's models.
TEST_CASE("transforms.json: coefficients stand in a list or each under its name") {
  const json list = {-0.11, 0.07, 0.023, -0.017, 0.013, -0.021};
  for (const char* model : {"", "PINHOLE", "OPENCV", "OPENCV_FISHEYE"}) {
    CAPTURE(model);
    const bool fisheye = model == std::string("OPENCV_FISHEYE");
    const Lens expected{fisheye ? LensModel::fisheye : LensModel::perspective, of_six};
    json file = with(some_file(), six), listed = some_file();
    // The list counts before keys of their own.
    listed["distortion_params"] = list, listed["k1"] = 0.5;
    if (*model) file["camera_model"] = listed["camera_model"] = model;
    for (const json& one : {file, listed}) {
      CHECK(parse_file(one).notes.empty());
      CHECK(parse(one).at(1).lens == expected);
    }
  }
}

TEST_CASE("transforms.json: the fourth to sixth coefficients of FULL_OPENCV are below the line") {
  json file = with(some_file(), six);
  file["camera_model"] = "FULL_OPENCV", file["k4"] = 0.19, file["k5"] = 0.053, file["k6"] = -0.029;
  CHECK(parse(file).at(0).lens.distortion == Distortion{.radial = {-0.11, 0.07, 0.023},
                                                        .rational = {0.19, 0.053, -0.029},
                                                        .tangential = {0.013, -0.021}});
  const std::pair<json, const char*> changes[] = {
      {{{"camera_model", "OPENCV"}}, "OPENCV with k5 = 0.053"},
      {{{"camera_model", nullptr}}, "k5 = 0.053"},
      {{{"camera_model", nullptr}, {"k5", 0}}, "k6 = -0.029"},
      {{{"distortion_params", {0.1, 0, 0, 0, 0, 0}}}, "FULL_OPENCV with distortion_params that is not 0"}};
  for (const auto& [change, found] : changes) CHECK(complaint_about(with(file, change)) == models + found);
}

TEST_CASE("transforms.json: names that COLMAP has for coefficients count") {
  json file = with(some_file(), {{"camera_model", "SIMPLE_RADIAL_FISHEYE"}, {"k", -0.11}});
  CHECK(parse(file).at(0).lens == Lens{LensModel::fisheye, {.radial = {-0.11}}});
  file["camera_model"] = "SIMPLE_RADIAL";
  CHECK(parse(file).at(0).lens == Lens{LensModel::perspective, {.radial = {-0.11}}});
  file = with(some_file(), six);
  file["camera_model"] = "THIN_PRISM_FISHEYE", file["sx1"] = 0.031, file["sy1"] = -0.043;
  Distortion prism = of_six;
  prism.prism[0] = 0.031, prism.prism[1] = -0.043;
  CHECK(parse(file).at(0).lens == Lens{LensModel::fisheye, prism});
}

TEST_CASE("transforms.json: a frame's own coefficients and lens win") {
  json file = with(some_file(), six);
  json& frame = file["frames"][1];
  frame["k1"] = 0.25, frame["p2"] = 0, frame["k2"] = nullptr;
  CHECK(parse(file).at(0).lens.distortion == of_six);
  CHECK(parse(file).at(1).lens.distortion ==
        Distortion{.radial = {0.25, 0.07, 0.023, -0.017}, .tangential = {0.013, 0}});
  frame["distortion_params"] = {1, 2, 3, 4, 5, 6};
  CHECK(parse(file).at(1).lens.distortion == Distortion{.radial = {1, 2, 3, 4}, .tangential = {5, 6}});
  frame["distortion_params"] = {0, 0};
  CHECK(parse(file).at(1).lens.is_pinhole());
  CHECK(parse(file).at(0).lens.is_distorted());
  frame["camera_model"] = "OPENCV_FISHEYE";
  CHECK(parse(file).at(1).lens == Lens{LensModel::fisheye, {}});
  CHECK(parse(file).at(0).lens.model == LensModel::perspective);
  // Keys of its own before a list of the file.
  file.erase("k1"), frame.erase("distortion_params");
  file["distortion_params"] = {1, 2, 3, 4, 5, 6};
  CHECK(parse(file).at(1).lens.distortion == Distortion{.radial = {0.25, 2, 3, 4}, .tangential = {5, 0}});
}

TEST_CASE("transforms.json: instant-ngp's fisheye lenses have no model's name") {
  json file = with(some_file(), {{"is_fisheye", true}, {"k1", -0.11}, {"k2", 0.07}, {"k3", 0}, {"k4", 0}});
  const Lens expected{LensModel::fisheye, {.radial = {-0.11, 0.07}}};
  CHECK(parse(file).at(0).lens == expected);
  file["camera_model"] = "OPENCV_FISHEYE";
  CHECK(parse(file).at(0).lens == expected);
  file["camera_model"] = "OPENCV";
  CHECK(complaint_about(file) ==
        "transforms.json: byte 0: expected one lens, found 'is_fisheye' and the camera model OPENCV");
  file["is_fisheye"] = false;
  CHECK(parse(file).at(0).lens.model == LensModel::perspective);
}

TEST_CASE("transforms.json: an equirectangular image shows the whole sphere") {
  // As nerfstudio writes it of Metashape's spherical sensors.
  json file =
      with(some_file(),
           R"({"fl_x": 320, "fl_y": 480, "cx": 320, "cy": 240, "camera_model": "EQUIRECTANGULAR"})"_json);
  const auto check = [](const Camera& camera) {
    CHECK(camera.lens == Lens{LensModel::equirectangular, {}});
    check_pixel(camera, {0, 0, 2}, {320, 240});
    check_pixel(camera, {3, 0, 0}, {480, 240});
    check_pixel(camera, {-1, 0, 0}, {160, 240});
    check_pixel(camera, {-5, 0, -5}, {80, 240});
    check_pixel(camera, {0, 1, 1}, {320, 360});
    check_pixel(camera, {2, -std::sqrt(8.0), 2}, {400, 120});
  };
  check(parse(file).at(0));
  CHECK(parse_file(file).notes.empty());
  for (const std::string key : {"fl_x", "fl_y", "cx", "cy"}) {
    const CameraFile other = parse_file(with(file, {{key, 1000}}));
    check(other.cameras.at(0));
    CHECK(other.notes == Strings{"Keys that may change the picture were not read: " + key + "."});
    file.erase(key);
  }
  check(parse(file).at(0));
  file["k1"] = 0.1;
  CHECK(complaint_about(file) == models + "EQUIRECTANGULAR with k1 = 0.1");
  // instant-ngp's name for it, whose focal lengths say nothing.
  file = with(some_file(), {{"latlong", true}});
  check(parse(file).at(0));
  CHECK(parse_file(file).notes.empty());
}

TEST_CASE("transforms.json: an orthophoto has parallel rays and lengths in pixels a unit") {
  json file = with(some_file(), {{"camera_model", "ORTHOPHOTO"}});
  const Camera camera = parse(file).at(0);
  CHECK(camera.lens == Lens{LensModel::orthographic, {}});
  check_pixel(camera, {0.25, -0.5, 7}, {321 + 125, 239.25 - 255.25});
  // Of the world that the model is in.
  CHECK(parse_in_model(file, {{"transform", turn}, {"scale", 2}}).at(0).fx == 500);
  for (const char* key : {"fl_x", "fl_y"}) file.erase(key);
  file["camera_angle_x"] = 1;
  CHECK(contains(complaint_about(file), "in 'fl_x' or 'fl_y' of an orthographic lens"));
  file["fl_y"] = 100;
  CHECK(parse(file).at(0).fx == 100);
  file["p1"] = 0.1;
  CHECK(complaint_about(file) == models + "ORTHOPHOTO with p1 = 0.1");
}

TEST_CASE("transforms.json: coefficients of 0 are a pinhole's") {
  json zero = with(some_file(), R"({"is_fisheye": false, "latlong": null})"_json);
  zero["distortion_params"] = {0, 0.0, 0, 0, 0, 0};
  for (const char* key :
       {"k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "sx1", "sy1", "k", "omega", "alpha"})
    zero[key] = 0.0;
  zero["beta"] = 1;  // of EUCM, which says nothing where alpha is 0
  for (const char* model : {"PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV", "FULL_OPENCV",
                            "FOV", "DIVISION", "EUCM"}) {
    zero["camera_model"] = model;
    CHECK(parse(zero).at(0).lens.is_pinhole());
    CHECK(parse_file(zero).notes.empty());
    CHECK(parse(with(some_file(), {{"camera_model", model}})).at(1).lens.is_pinhole());
  }
}

TEST_CASE("transforms.json: lenses that are not read are refused by name") {
  for (const char* key : {"k", "k5", "k6", "omega", "alpha"}) {
    json file = with(some_file(), {{key, -1e-9}});
    CHECK(complaint_about(file) == models + key + " = -1e-09");
    file["camera_model"] = "DIVISION";
    CHECK(complaint_about(file) == models + "DIVISION with " + key + " = -1e-09");
    file["frames"][0][key] = file["frames"][1][key] = 0;
    CHECK(complaint_about(file) == "");
  }
  for (const char* model :
       {"FISHEYE624", "OMNIDIRECTIONALSTEREO_L", "VR180_R", "RAD_TAN_THIN_PRISM_FISHEYE", "anything", ""})
    CHECK(complaint_about(with(some_file(), {{"camera_model", model}})) == models + model);
  for (const char* key : {"ftheta_p0", "equirectangular", "orthographic", "from_mitsuba", "normal_mts_args"})
    CHECK(complaint_about(with(some_file(), {{key, true}})) == models + "'" + key + "'");
  json file = some_file();
  file["frames"][1]["k1"] = "0.1";
  CHECK(contains(complaint_about(file), "expected a number in 'k1'"));
  file["frames"][1]["k1"] = 1e7;
  CHECK(contains(complaint_about(file), "expected distortion coefficients of at most 1e6"));
  for (const json& list : {json{0.1, 0}, json(0.1), json{0.1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}}) {
    file["frames"][1] = frame("a"), file["frames"][1]["distortion_params"] = list;
    CHECK(contains(complaint_about(file), "six numbers k1, k2, k3, k4, p1 and p2 in 'distortion_params'"));
  }
  file["frames"][1]["distortion_params"] = {0.1, 0, 0, 0, 0, "0"};
  CHECK(contains(complaint_about(file), "expected a number in 'distortion_params'"));
}

TEST_CASE("transforms.json: the size is taken from the header of the image beside the file") {
  const TemporaryFolder folder;
  const std::string ihdr =
      png_chunk("IHDR", big_endian(80) + big_endian(60) + std::string("\x8\x6\0\0\0", 5));
  // A header, and no pixels: enough bytes that they could follow.
  const std::string image = "\x89PNG\r\n\x1a\n" + ihdr + png_chunk("IDAT", std::string(100, 'x'));
  folder.write("nerf/train/r_0.png", image);
  json file = {{"camera_angle_x", 0.5 * pi}, {"frames", {frame("./train/r_0")}}};
  const auto path = folder.write("nerf/transforms_train.json", file.dump());
  const Camera camera = load_cameras(path).at(0);
  CHECK(camera.name == "./train/r_0");
  check_intrinsics(camera, {80, 60, 40, 40, 40, 30});

  CHECK(contains(complaint_about(file), "expected a frame with 'w' and 'h', or a file with its images"));
  file["w"] = 640;
  CHECK(contains(complaint_about(file), "expected a frame with 'w' and 'h'"));
  file["frames"][0]["file_path"] = "train/r_1.jpg";
  folder.write("nerf/transforms_train.json", file.dump());
  const std::string missing = complaint([&] { load_cameras(path); });
  CHECK(contains(missing, path.string() + ": byte "));
  CHECK(contains(missing, "expected a frame with 'w' and 'h', or its image ("));
  CHECK(contains(missing, "r_1.jpg: No such file"));
  // A dot is not an extension: Blender writes frame.0001.
  folder.write("nerf/train/frame.0001.png", image);
  json dotted = file;
  dotted.erase("w"), dotted["frames"][0]["file_path"] = "train/frame.0001";
  CHECK(load_cameras(folder.write("nerf/dotted.json", dotted.dump())).at(0).width == 80);

  folder.write("nerf/train/r_1.jpg", "no image");
  CHECK(contains(complaint([&] { load_cameras(path); }), "r_1.jpg: byte 0: expected an image"));
  folder.write("nerf/train/r_1.jpg", image.substr(0, 20));
  CHECK(contains(complaint([&] { load_cameras(path); }), "expected a valid PNG"));
}

TEST_CASE("transforms.json: cameras follow the model that nerfstudio trained") {
  json file = some_file();
  // p_json = applied p, so that p_model = scale (turn p) with applied undone.
  file["applied_transform"] = {{1, 0, 0, 0.5}, {0, 0, 1, 0}, {0, -1, 0, 0}};
  file["applied_scale"] = 4;
  const dvec3 point(0.3, -0.4, 1.5);                     // in the world before
  const dvec3 in_file(0.8, 1.5, 0.4);                    // applied
  const dvec3 in_model = 0.5 * dvec3(10.4, 20.3, 31.5);  // 2 / 4 of the turned one
  const json dataparser = {{"transform", turn}, {"scale", 2}};
  const Camera plain = parse(file).at(0), moved = parse_in_model(file, dataparser).at(0);
  check_near(moved.rotation * in_model + moved.translation,
             0.5 * (plain.rotation * in_file + plain.translation));
  CHECK(plain.translation == parse(some_file()).at(0).translation);
  CHECK_NOTHROW(validate(moved));

  // Without what was applied, the file's world is where the model's starts.
  const Camera turned = parse_in_model(some_file(), dataparser).at(0);
  check_near(turned.rotation * (2.0 * dvec3(10.4, 20.3, 31.5)) + turned.translation,
             2.0 * (plain.rotation * point + plain.translation));

  const TemporaryFolder folder;
  const auto path = folder.write("transforms.json", file.dump());
  CameraFile found = read_cameras(path);
  check_pose(found.cameras.at(0), plain);
  CHECK(contains(found.notes.at(0), "put its dataparser_transforms.json beside the file"));
  folder.write("dataparser_transforms.json", dataparser.dump());
  found = read_cameras(path);
  check_pose(found.cameras.at(0), moved);
  CHECK(found.notes.empty());
  check_pose(load_cameras(folder.path()).at(0), moved);
}

TEST_CASE("transforms.json: a world that cannot be changed is placed") {
  const json good = {{"transform", turn}, {"scale", 2}};
  const auto refused = [&](const json& file, const json& dataparser) {
    return complaint([&] { parse_in_model(file, dataparser); });
  };
  CHECK(refused(some_file(), good) == "");
  const std::string place = "dataparser_transforms.json: byte 0: expected ";
  const std::pair<json, std::string> cases[] = {
      {json::array(), "nerfstudio's dataparser_transforms.json (a JSON object)"},
      {{{"scale", 1}}, "nerfstudio's dataparser_transforms.json with 'transform'"},
      {with(good, {{"scale", 0}}), "a scale above 0 in 'scale'"},
      {with(good, {{"scale", -1}}), "a scale above 0 in 'scale'"},
      {with(good, R"({"transform": [[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]})"_json),
       "a rotation and a translation in 'transform'"},
      {with(good, R"({"transform": [[1, 0, 0, 0], [0, 1, 0, 0]]})"_json),
       "'transform' to be three or four rows"}};
  for (const auto& [dataparser, expected] : cases)
    CHECK(refused(some_file(), dataparser) == place + expected);
  CHECK(contains(refused(some_file(), with(good, {{"scale", 1e308}})), "a finite translation"));
  json file = some_file();
  file["applied_transform"] = {{0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}};
  CHECK(refused(file, good) ==
        "transforms.json: byte 0: expected a rotation and a translation in 'applied_transform'");
  CHECK(complaint_about(file) == "");
  file.erase("applied_transform"), file["applied_scale"] = 0;
  CHECK(refused(file, good) == "transforms.json: byte 0: expected a scale above 0 in 'applied_scale'");
}

TEST_CASE("transforms.json: the frame that is wrong is placed") {
  json file = some_file();
  // A name that misleads who counts brackets, behind a member of the same kind.
  file["before"] = {{"frames", {1, 2}}};
  file["frames"][0]["file_path"] = "x,[{\\\"]";
  const auto second_with = [&](const char* key, const json& value) {
    json changed = file;
    changed["frames"][1][key] = value;
    return complaint_about(changed);
  };
  const std::string place =
      "transforms.json: byte " + std::to_string(file.dump().rfind("{\"file_path\"")) + ": expected ";
  CHECK(complaint_about(file) == "");
  const struct {
    const char* key;
    json value;
    const char* expected;
  } cases[] = {{"file_path", 7, "'file_path' to be a string"},
               {"transform_matrix", 7, "'transform_matrix' to be three or four rows"},
               {"transform_matrix", R"([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1]])"_json,
                "rows of four numbers in 'transform_matrix'"},
               {"transform_matrix", R"([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, null]])"_json,
                "a number in 'transform_matrix'"},
               {"transform_matrix", R"([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1, 1]])"_json,
                "a last row of 0, 0, 0, 1 in 'transform_matrix'"}};
  for (const auto& [key, value, expected] : cases) CHECK(second_with(key, value) == place + expected);
  CHECK(contains(second_with("transform_matrix", {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1.01, 0}}),
                 "orthonormal rows"));
  json changed = file;
  changed["frames"][1].erase("transform_matrix");
  CHECK(complaint_about(changed) == place + "a frame with 'transform_matrix'");
  changed["frames"][1] = 7;
  CHECK(contains(complaint_about(changed), "expected a frame (a JSON object)"));
  for (const double width : {0.0, -640.0, 65537.0, 640.5, 1e300})
    CHECK(contains(complaint_about(with(file, {{"w", width}})), "transforms.json: byte 0: expected a width"));
  CHECK(contains(second_with("fl_x", -500), "focal lengths of 1e-6 to 1e12 pixels"));
  CHECK(contains(second_with("cx", 1e10), "a principal point"));
}

TEST_CASE("transforms.json: a frame is found among keys that are written twice or with escapes") {
  const std::string good = frame("a").dump();
  const auto place_of = [&](const std::string& before) {
    const std::string content = before + good + ", 7], \"w\": 4, \"h\": 3, \"fl_x\": 5}";
    return complaint([&] { io::parse_transforms_json({as_bytes(content), "t"}); });
  };
  for (const std::string before :
       {R"({"frames": [)", R"({"frames": {}, "frames" : [ )", R"({"\u0066rames": [)",
        R"({"frames":[1,2,3],"a\":[":"frames","x":{"frames":[4]},"frames":[)"}) {
    CAPTURE(before);
    CHECK(place_of(before) == "t: byte " + std::to_string(before.size() + good.size() + 2) +
                                  ": expected a frame (a JSON object)");
  }
}

TEST_CASE("transforms.json: JSON that is something else is refused") {
  CHECK(contains(complaint_about(json::array()), "expected a transforms.json (a JSON object)"));
  CHECK(contains(complaint_about(json::object()), "expected a transforms.json with 'frames'"));
  CHECK(contains(complaint_about({{"frames", 7}}), "'frames' to be an array"));
  const auto refused = [](const std::string& content) {
    return complaint([&] { io::parse_transforms_json({as_bytes(content), "t"}); });
  };
  CHECK(contains(refused(R"({"frames": [NaN]})"), "t: byte 12: expected valid JSON"));
  CHECK(contains(refused(R"({"frames": [1e999]})"), "numbers that a double can hold"));
  std::string deep = R"({"k1": )" + std::string(100'000, '[') + std::string(100'000, ']') +
                     R"(, "w": 4, "h": 3, "fl_x": 5, "frames": [)" + frame("a").dump() + "]}";
  CHECK(contains(refused(deep), "at most 256 arrays and objects in each other"));
  const TemporaryFolder folder;
  for (const char* content : {R"({"transform": [], "scale": 1})", R"({"asset": {}})", "{}"})
    CHECK(contains(complaint([&] { load_cameras(folder.write("transforms.json", content)); }),
                   "a transforms.json (a JSON object with 'frames')"));
}

}  // namespace swiftgs::test::transforms_json_test
