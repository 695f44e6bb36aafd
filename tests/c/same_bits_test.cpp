// SPDX-License-Identifier: Apache-2.0

// The C interface beside the C++ that it is made of: the same bits, and a status for every exception.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <memory>
#include <new>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <swiftgs.h>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/default_view.hpp>
#include <swiftgs/edit/rotation.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/tools/scene_bounds.hpp>

#include "policies/all_planes.hpp"

using namespace swiftgs;

namespace {

constexpr std::size_t count = 3000;
constexpr int width = 96, height = 64;

struct Free {
  void operator()(swiftgs_scene* scene) const { swiftgs_scene_free(scene); }
  void operator()(swiftgs_renderer* renderer) const { swiftgs_renderer_free(renderer); }
};

std::unique_ptr<swiftgs_scene, Free> make_scene() {
  swiftgs_scene* scene = nullptr;
  REQUIRE(swiftgs_scene_builtin(count, &scene) == SWIFTGS_OK);
  return std::unique_ptr<swiftgs_scene, Free>(scene);
}

/// A struct of C that knows its size.
template <class Struct>
Struct sized() {
  Struct made{};
  made.size = sizeof(made);
  return made;
}

swiftgs_conventions conventions_named(const char* name) {
  auto conventions = sized<swiftgs_conventions>();
  REQUIRE(swiftgs_conventions_named(name, &conventions) == SWIFTGS_OK);
  return conventions;
}

swiftgs_camera camera_of_c() {
  auto camera = sized<swiftgs_camera>();
  REQUIRE(swiftgs_camera_builtin(width, height, &camera) == SWIFTGS_OK);
  return camera;
}

/// Where a list writes a matrix that C++ has in columns.
void copy_rows(const dmat3& from, double* to) {
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) to[3 * row + column] = from[column][row];
}

Scene with_features(Scene scene) {
  scene.feature_channels = 4;
  for (std::size_t i = 0; i < 4 * scene.size(); ++i) scene.features.push_back(float(i % 7) - 3);
  return scene;
}

/// Before `plain_camera`: one that is smaller than a pixel at a depth of exactly 2 on the axis, a nearer one,
/// two whose order by depth is not that by distance, and one that reaches into the image from the side.
Scene scene_of_conventions() {
  Scene scene = make_builtin_scene(5);
  scene.means = {vec3(0, 0, 2), vec3(0.5f, 0.4f, 1.5f), vec3(-1.2f, 0.5f, 4), vec3(-0.2f, 0.1f, 4.1f),
                 vec3(4, 0, 2.5f)};
  scene.scales = {vec3(0.001f), vec3(0.1f), vec3(0.6f, 0.5f, 0.4f), vec3(0.6f, 0.5f, 0.4f), vec3(1.5f)};
  scene.opacities = {0.5f, 0.9f, 0.9f, 0.8f, 0.9f};
  return with_features(std::move(scene));
}

Camera plain_camera() {
  Camera camera = builtin_camera(width, height);
  camera.rotation = dmat3(1), camera.translation = {0, 0, 0};
  camera.cx = width / 2 + 0.5, camera.cy = height / 2 + 0.5;
  return camera;
}

swiftgs_camera in_c(const Camera& camera) {
  swiftgs_camera to = camera_of_c();
  to.fx = camera.fx, to.fy = camera.fy, to.cx = camera.cx, to.cy = camera.cy,
  to.lens = int(camera.lens.model);
  copy_rows(camera.rotation, to.rotation);
  for (int axis = 0; axis < 3; ++axis) to.translation[axis] = camera.translation[axis];
  std::copy_n(camera.lens.distortion.radial, 4, to.radial);
  std::copy_n(camera.lens.distortion.rational, 3, to.rational);
  std::copy_n(camera.lens.distortion.tangential, 2, to.tangential);
  std::copy_n(camera.lens.distortion.prism, 2, to.prism);
  return to;
}

swiftgs_gaussians in_c(const Scene& scene) {
  auto arrays = sized<swiftgs_gaussians>();
  arrays.count = scene.size(), arrays.sh_degree = scene.sh_degree;
  arrays.feature_channels = scene.feature_channels;
  arrays.means.data = &scene.means[0].x, arrays.scales.data = &scene.scales[0].x;
  arrays.rotations.data = &scene.rotations[0].w, arrays.opacities.data = scene.opacities.data();
  arrays.sh0.data = &scene.sh0[0].x, arrays.sh_rest.data = scene.sh_rest.data();
  arrays.features.data = scene.features.data();
  return arrays;
}

/// The same renderer of C++ and of C, with the same scene.
struct Both {
  explicit Both(const std::string& name, const Scene& scene = with_features(make_builtin_scene(count)))
      : cpp(find_renderer(name).make()) {
    const swiftgs_gaussians arrays = in_c(scene);
    swiftgs_renderer* made = nullptr;
    REQUIRE(swiftgs_renderer_create(std::string(cpp->name()).c_str(), nullptr, &made) == SWIFTGS_OK);
    c.reset(made);
    REQUIRE(swiftgs_renderer_set_gaussians(made, &arrays) == SWIFTGS_OK);
    cpp->set_scene(std::make_shared<const Scene>(scene));
  }

  /// Draws with both, checks that all planes have the same bits, and returns the frame of C++.
  Frame compare(const Camera& camera, const Conventions& conventions, const swiftgs_conventions& given,
                ShownScenes shows = {}) {
    const Outputs outputs = test::all_planes(3);
    Frame expected, found;
    View drawn =
        make_view(camera, conventions, prepare(expected, width, height, outputs), vec3(0.1f, 0.2f, 0.3f));
    drawn.shows = shows;
    cpp->render_into({&drawn, 1});
    auto view = sized<swiftgs_view>();
    const swiftgs_camera from = in_c(camera);
    view.camera = &from, view.conventions = &given;
    view.feature_channels = outputs.features;
    view.first_shown = shows.first, view.shown_count = shows.count == ShownScenes{}.count ? 0 : shows.count;
    for_each_plane(
        [](std::size_t, const auto& of_view, swiftgs_plane& to) {
          to = {of_view.data, of_view.pitch};
        },
        prepare(found, width, height, outputs), view);
    for (int k = 0; k < 3; ++k) view.background[k] = drawn.background[k];
    auto frame = sized<swiftgs_frame>();
    frame.views = &view, frame.count = 1;
    REQUIRE(swiftgs_renderer_render(c.get(), &frame) == SWIFTGS_OK);
    for_each_plane(
        [](std::size_t, const auto& a, const auto& b, const PlaneRow& row) {
          CAPTURE(row.name);
          CHECK(!a.empty());
          CHECK(a == b);
        },
        found, expected, plane_table);
    check_picks({.x = width / 2 - 5, .y = height / 2 - 3, .width = 9, .height = 7});
    return expected;
  }

  Frame compare(const Camera& camera, ShownScenes shows = {}) {
    return compare(camera, {}, conventions_named("gsplat"), shows);
  }

  /// The last frames of both show the same Gaussians.
  void check_picks(const PickRectangle& at) {
    std::vector<swiftgs_picked> found(std::size_t(at.width) * std::size_t(at.height));
    REQUIRE(swiftgs_renderer_pick(c.get(), at.view, at.x, at.y, at.width, at.height, found.data()) ==
            SWIFTGS_OK);
    const std::vector<PickedPixel> expected = cpp->pick(at);
    REQUIRE(found.size() == expected.size());
    CHECK(std::equal(found.begin(), found.end(), expected.begin(), [](const auto& a, const auto& b) {
      return PickedPixel{a.gaussian, a.weight, a.depth, a.median, a.median_depth} == b;
    }));
  }

  std::unique_ptr<AnyRenderer> cpp;
  std::unique_ptr<swiftgs_renderer, Free> c{};
};

/// Conventions of C++ and of C that are changed alike.
struct Conventional {
  Conventions cpp{};
  swiftgs_conventions c = conventions_named("gsplat");
};

template <class T>
void set(T& member, double value) {
  member = static_cast<T>(value);
}
template <class T>
void set(std::optional<T>& member, double value) {
  member = static_cast<T>(value);
}

bool same_planes_of(const Frame& a, const Frame& b) {
  bool same = true;
  for_each_plane([&](std::size_t, const auto& of_a, const auto& of_b) { same = same && of_a == of_b; }, a, b);
  return same;
}

}  // namespace

TEST_CASE("c: frames have the bits of the C++ interface on every backend that draws into memory of the host") {
  std::set<std::string> backends;
  for (const RendererEntry& entry : renderers()) {
    if (!entry.usable || entry.name.starts_with("cuda/")) continue;
    const std::string backend(entry.name.substr(0, entry.name.find('/')));
    if (!backends.insert(backend).second) continue;
    CAPTURE(backend);
    Both(backend).compare(builtin_camera(width, height), Conventions::inria(), conventions_named("inria"));
  }
}

TEST_CASE("c: every lens and measure of depth has the bits of the C++ interface") {
  const Distortion distortion{.radial = {-0.2, 0.03, 0.004, -0.0005},
                              .rational = {0.05, 0.006, 0.0007},
                              .tangential = {0.003, -0.002},
                              .prism = {0.001, 0.004}};
  const Lens lenses[] = {{},
                         {LensModel::perspective, distortion},
                         {LensModel::fisheye, {}},
                         {LensModel::fisheye, distortion},
                         {LensModel::orthographic, {}},
                         {LensModel::equirectangular, {}}};
  Both both("serial");
  std::vector<Frame> all;
  for (const Lens& lens : lenses) {
    CAPTURE(name_of(lens.model));
    CAPTURE(lens.is_distorted());
    Camera camera = builtin_camera(width, height);
    camera.lens = lens;
    if (lens.model == LensModel::orthographic) camera.fx = camera.fy = 15;
    if (lens.model == LensModel::equirectangular) camera.fx = camera.fy = 20;
    all.push_back(both.compare(camera));
  }
  for (std::size_t i = 1; i < all.size(); ++i) CHECK(all[i].colour != all[i - 1].colour);
}

TEST_CASE("c: each number of the conventions has the bits of the C++ interface") {
  Both both("serial", scene_of_conventions());
  Conventional changed;
  Frame before = both.compare(plain_camera());
  const Frame usual = before;
  const auto compare = [&](const std::string& member) {
    CAPTURE(member);
    const Frame frame = both.compare(plain_camera(), changed.cpp, changed.c);
    CHECK_FALSE(same_planes_of(frame, before));
    before = frame;
  };
#define ALSO(member, value) set(changed.cpp.member, value), set(changed.c.member, value), compare(#member);
#define CONVENTION(member, value) \
  changed = {}, before = usual;   \
  ALSO(member, value)
#include "support/conventions.inc"
#undef ALSO
#undef CONVENTION
}

TEST_CASE("c: views into images of every format have the bits of the C++ interface") {
  Both both("serial");
  const Camera camera = builtin_camera(width, height);
  const swiftgs_camera given = camera_of_c(), other = in_c(plain_camera());
  constexpr int part_width = 64, part_height = 40, left = 16, top = 16;
  std::vector<float> occluder(part_width * part_height);
  for (std::size_t i = 0; i < occluder.size(); ++i) occluder[i] = i % 3 ? 1 : 0.98f;
  std::set<std::vector<std::byte>> all;
  // A part of an image, bottom row first, with gaps between rows. Half of the frames lie over an image and
  // behind surfaces. Beside it the frame has another camera's image.
  const auto draw = [&](int format, int conversion, bool over) {
    const std::size_t row = part_width * bytes_per_pixel(PixelFormat(format)), pitch = row + 16;
    std::vector<std::byte> expected(part_height * pitch, std::byte(60)), found = expected;
    const auto last_row = [&](std::vector<std::byte>& image) { return &image[(part_height - 1) * pitch]; };
    FrameView frame{.width = part_width,
                    .height = part_height,
                    .colour = {last_row(expected), -std::ptrdiff_t(pitch)},
                    .format = PixelFormat(format),
                    .over = over,
                    .conversion = Conversion(conversion)};
    swiftgs_view views[] = {sized<swiftgs_view>(), sized<swiftgs_view>()};
    swiftgs_view& view = views[0];
    view.camera = &given, view.format = format, view.conversion = conversion, view.over = over;
    view.width = part_width, view.height = part_height, view.left = left, view.top = top;
    view.colour = {last_row(found), -std::int64_t(pitch)};
    for (int k = 0; k < 3; ++k) view.background[k] = 0.25f * float(k);
    if (over) {
      frame.occluder = {occluder.data(), sizeof(float) * part_width};
      frame.stored_depth = StoredDepth::perspective(0.1, 100);
      view.occluder = {occluder.data(), sizeof(float) * part_width};
      view.stored_depth = swiftgs_stored_perspective(0.1, 100);
    }
    Frame whole;
    std::vector<float> whole_of_c(3 * width * height);
    views[1].camera = &other, views[1].colour = {whole_of_c.data(), 3 * sizeof(float) * width};
    const View drawn[] = {make_view(camera, Conventions::gsplat(), frame, vec3(0, 0.25f, 0.5f), {left, top}),
                          make_view(plain_camera(), {}, prepare(whole, width, height, {}))};
    both.cpp->render_into({drawn, 2});
    auto frame_of_c = sized<swiftgs_frame>();
    frame_of_c.views = views, frame_of_c.count = 2;
    REQUIRE(swiftgs_renderer_render(both.c.get(), &frame_of_c) == SWIFTGS_OK);
    CHECK(found == expected);
    CHECK(whole_of_c == whole.colour);
    for (std::size_t y = 0; y < part_height; ++y)
      CHECK(std::all_of(&found[y * pitch + row], &found[y * pitch + row] + 16,
                        [](std::byte byte) { return byte == std::byte(60); }));
    all.insert(found);
  };
  for (const int format :
       {SWIFTGS_RGB_FLOAT, SWIFTGS_RGBA_FLOAT, SWIFTGS_RGBA_HALF, SWIFTGS_RGBA_8, SWIFTGS_BGRA_8})
    for (const int conversion :
         {SWIFTGS_CONVERT_NOTHING, SWIFTGS_CONVERT_SRGB_TO_LINEAR, SWIFTGS_CONVERT_LINEAR_TO_SRGB})
      for (const bool over : {false, true}) {
        CAPTURE(format);
        CAPTURE(conversion);
        CAPTURE(over);
        draw(format, conversion, over);
      }
  CHECK(all.size() == 5 * 3 * 2);
}

TEST_CASE("c: where a scene lies and how a camera moves around it are those of the C++ interface") {
  const auto scene = make_scene();
  const Scene same = make_builtin_scene(count);
  const auto numbers = [](const auto& array) {
    return std::vector<double>(std::begin(array), std::end(array));
  };
  const auto of = [](const dvec3& v) { return std::vector<double>{v.x, v.y, v.z}; };
  auto bounds = sized<swiftgs_scene_bounds>();
  REQUIRE(swiftgs_scene_robust_bounds(scene.get(), &bounds) == SWIFTGS_OK);
  const SceneBounds expected = robust_bounds(same);
  CHECK(numbers(bounds.low) == of(expected.low));
  CHECK(numbers(bounds.high) == of(expected.high));
  CHECK(numbers(bounds.centre) == of(expected.centre));
  CHECK(bounds.radius == expected.radius);

  const OrbitView view = default_view(same, width, height, dvec3(0, 0, 7));
  auto camera = sized<swiftgs_camera>();
  auto orbit = sized<swiftgs_orbit>();
  orbit.up[2] = 7;
  REQUIRE(swiftgs_scene_default_view(scene.get(), width, height, &camera, &orbit) == SWIFTGS_OK);
  CHECK(numbers(orbit.target) == of(view.target));
  CHECK(numbers(orbit.up) == of(view.up));
  orbit.turn = 1, orbit.rise = 0.2, orbit.distance = 2;
  REQUIRE(swiftgs_camera_orbit(&camera, &orbit) == SWIFTGS_OK);
  const Camera moved = swiftgs::orbit(view, 1, 0.2, 2);
  const swiftgs_camera wanted = in_c(moved);
  CHECK(std::memcmp(&camera, &wanted, sizeof(camera)) == 0);
}

TEST_CASE("c: scenes that are placed and updated have the bits of the C++ interface") {
  Both both("serial");
  const Scene added = with_features(make_builtin_scene(count));
  const swiftgs_gaussians given_arrays = in_c(added);
  swiftgs_scene* scene = nullptr;
  REQUIRE(swiftgs_scene_from_arrays(&given_arrays, &scene) == SWIFTGS_OK);
  std::uint64_t number = 0;
  CHECK(swiftgs_renderer_add_scene(both.c.get(), scene, &number) == SWIFTGS_OK);
  swiftgs_scene_free(scene);
  CHECK(number == both.cpp->add_scene(std::make_shared<const Scene>(added)));

  const dmat3 turn = matrix_of(unit(DQuaternion{0.8, 0.3, -0.4, 0.2}));
  Placement placements[] = {{}, {.scene = 0, .world_from_scene = {turn, 1.25, dvec3(0.5, -0.5, 0.25)}}};
  placements[1].opacity = 0.7f, placements[1].clip = Clip::sphere(vec3(0.5f, 0.25f, 0.125f), 1.5f);
  placements[1].clip.half_space_count = 2, placements[1].clip.half_spaces[0] = vec4(1, 0.5f, -0.25f, 0.75f),
  placements[1].clip.half_spaces[1] = vec4(0, 1, 0, 2);
  placements[1].first = 100, placements[1].count = 2500;
  placements[1].tint = {vec3(0.25f, 0.5f, 2), 0.3f};
  both.cpp->place({placements, 2});

  swiftgs_placement given[] = {sized<swiftgs_placement>(), sized<swiftgs_placement>()};
  const Placement& p = placements[1];
  copy_rows(p.world_from_scene.rotation, given[1].rotation);
  given[1].scale = p.world_from_scene.scale, given[1].transparency = 1 - double(p.opacity);
  given[1].half_space_count = p.clip.half_space_count, given[1].radius = p.clip.radius;
  for (int k = 0; k < 3; ++k)
    given[1].translation[k] = p.world_from_scene.translation[k], given[1].centre[k] = p.clip.centre[k];
  for (int k = 0; k < 8; ++k) given[1].half_spaces[k] = p.clip.half_spaces[k / 4][k % 4];
  given[1].first = p.first, given[1].count = p.count, given[1].tint_amount = p.tint.amount;
  for (int k = 0; k < 3; ++k) given[1].tint[k] = p.tint.colour[k];
  REQUIRE(swiftgs_renderer_place(both.c.get(), given, 2) == SWIFTGS_OK);
  const Camera camera = builtin_camera(width, height);
  const Frame frame = both.compare(camera);
  const auto of_second = [](std::uint32_t id) { return id != no_gaussian && id >= count; };
  CHECK(std::count_if(frame.id.begin(), frame.id.end(), of_second) > 100);
  CHECK(both.compare(camera, {0, 1}).colour != both.compare(camera, {1, 1}).colour);

  // Each array of a range.
  SceneArrays arrays{.count = 500};
  arrays.means = {&added.means[1000].x}, arrays.scales = {&added.scales[900].x};
  arrays.rotations = {&added.rotations[800].w}, arrays.opacities = {&added.opacities[700]};
  arrays.sh0 = {&added.sh0[600].x}, arrays.sh_rest = {&added.sh_rest[45 * 500]}, arrays.sh_degree = 3;
  auto update = sized<swiftgs_gaussians>();
  update.count = arrays.count, update.sh_degree = 3;
  const FloatArray* const from[] = {&arrays.means,     &arrays.scales, &arrays.rotations,
                                    &arrays.opacities, &arrays.sh0,    &arrays.sh_rest};
  swiftgs_array* const to[] = {&update.means,     &update.scales, &update.rotations,
                               &update.opacities, &update.sh0,    &update.sh_rest};
  for (int k = 0; k < 6; ++k) to[k]->data = from[k]->data;
  both.cpp->update_scene(number, 200, arrays);
  REQUIRE(swiftgs_renderer_update_scene(both.c.get(), number, 200, &update) == SWIFTGS_OK);
  given[1].scene = number, placements[1].scene = number;
  both.cpp->place({placements, 2});
  REQUIRE(swiftgs_renderer_place(both.c.get(), given, 2) == SWIFTGS_OK);
  CHECK(both.compare(camera).colour != frame.colour);
}

TEST_CASE("c: the table has the renderers of the C++ interface in their order") {
  std::size_t listed = 0;
  REQUIRE(swiftgs_renderers_count(&listed) == SWIFTGS_OK);
  REQUIRE(listed == renderers().size());
  for (std::size_t i = 0; i < listed; ++i) {
    auto entry = sized<swiftgs_renderer_entry>();
    REQUIRE(swiftgs_renderers_get(i, &entry) == SWIFTGS_OK);
    CHECK(std::string_view(entry.name) == renderers()[i].name);
    CHECK((entry.usable != 0) == renderers()[i].usable);
    CHECK((entry.on_device != 0) == renderers()[i].name.starts_with("cuda/"));
  }
}

namespace {

/// A callback of C++ that throws is the way to have the library throw anything.
template <class E>
swiftgs_status status_of(const E& error) {
  auto options = sized<swiftgs_write_options>();
  options.context = const_cast<E*>(&error);
  options.progress = [](void* context, double) -> std::int32_t { throw *static_cast<const E*>(context); };
  return swiftgs_scene_write(make_scene().get(), "c_status.ply", &options);
}

}  // namespace

TEST_CASE("c: every kind of exception has a status and keeps its text") {
  const auto check = [](const auto& error, swiftgs_status expected, std::string_view text) {
    CAPTURE(text);
    CHECK(status_of(error) == expected);
    CHECK(swiftgs_last_error() == text);
  };
  check(InvalidArgument("one"), SWIFTGS_INVALID_ARGUMENT, "one");
  check(FormatError("file", 3, "four"), SWIFTGS_FORMAT_ERROR, "file: byte 3: expected four");
  check(Cancelled("file"), SWIFTGS_CANCELLED, "file: cancelled");
  const std::error_code reason = std::make_error_code(std::errc::io_error);
  check(FileError(reason, "five"), SWIFTGS_SYSTEM_ERROR, "five: " + reason.message());
  check(std::system_error(reason, "five"), SWIFTGS_SYSTEM_ERROR, "five: " + reason.message());
  check(DeviceError("call", "six"), SWIFTGS_DEVICE_ERROR, "call: six");
  check(CapacityError("seven", 8, 9), SWIFTGS_CAPACITY_ERROR, "seven: 8 needed, the limit is 9");
  check(OrderError("ten"), SWIFTGS_LOGIC_ERROR, "ten");
  check(std::bad_alloc(), SWIFTGS_OUT_OF_MEMORY, "out of memory");
  check(std::length_error("vector"), SWIFTGS_OUT_OF_MEMORY, "out of memory");
  check(Unavailable("eleven"), SWIFTGS_UNAVAILABLE, "eleven");
  check(std::runtime_error("of a callback"), SWIFTGS_INTERNAL_ERROR, "of a callback");
  check(std::bad_cast(), SWIFTGS_INTERNAL_ERROR, std::bad_cast().what());
  check(12, SWIFTGS_INTERNAL_ERROR, "an exception without a text, expected one of the library");
}
