// SPDX-License-Identifier: Apache-2.0

// The C interface beside the C++ that it is made of: the same bits, and a status for every exception.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <new>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <swiftgs.h>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/default_view.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/io/progress.hpp>
#include <swiftgs/orbit.hpp>
#include <swiftgs/rotation.hpp>
#include <swiftgs/scene_bounds.hpp>

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

/// The same renderer of C++ and of C, with the same scene.
struct Both {
  explicit Both(const RendererEntry& entry) : cpp(entry.make()) {
    Scene scene = make_builtin_scene(count);
    scene.feature_channels = 4;
    for (std::size_t i = 0; i < 4 * count; ++i) scene.features.push_back(float(i % 7) - 3);
    const auto without = make_scene();
    auto arrays = sized<swiftgs_gaussians>();
    REQUIRE(swiftgs_scene_get_arrays(without.get(), &arrays) == SWIFTGS_OK);
    arrays.features.data = scene.features.data(), arrays.feature_channels = scene.feature_channels;
    swiftgs_renderer* made = nullptr;
    REQUIRE(swiftgs_renderer_create(std::string(entry.name).c_str(), nullptr, &made) == SWIFTGS_OK);
    c.reset(made);
    REQUIRE(swiftgs_renderer_set_gaussians(made, &arrays) == SWIFTGS_OK);
    cpp->set_scene(std::make_shared<const Scene>(std::move(scene)));
  }

  /// Draws with both, checks that the planes have the same bits, and returns the frame of C++.
  Frame compare(const Camera& camera, RenderSettings settings, const swiftgs_camera& given,
                const swiftgs_conventions& conventions) {
    for_each_plane(
        [](std::size_t, auto& wanted) {
          if constexpr (!std::is_const_v<std::remove_reference_t<decltype(wanted)>>) wanted = true;
        },
        settings.outputs);
    settings.outputs.features = 3;
    Frame expected, found;
    cpp->render(camera, settings, expected);
    auto view = sized<swiftgs_view>();
    view.camera = &given, view.conventions = &conventions;
    view.feature_channels = settings.outputs.features;
    for_each_plane(
        [](std::size_t, const auto& from, swiftgs_plane& to) {
          to = {from.data, from.pitch};
        },
        prepare(found, width, height, settings.outputs), view);
    for (int k = 0; k < 3; ++k) view.background[k] = settings.background[k];
    auto frame = sized<swiftgs_frame>();
    frame.views = &view, frame.count = 1;
    REQUIRE(swiftgs_renderer_render(c.get(), &frame) == SWIFTGS_OK);
    for_each_plane(
        [](std::size_t, const auto& a, const auto& b, const char* name) {
          CAPTURE(name);
          CHECK(!a.empty());
          CHECK(a == b);
        },
        found, expected, plane_names);
    check_picks({.x = width / 2 - 5, .y = height / 2 - 3, .width = 9, .height = 7});
    return expected;
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

}  // namespace

TEST_CASE("c: frames have the bits of the C++ interface on every backend of the host") {
  RenderSettings settings;
  settings.background = vec3(0.1f, 0.2f, 0.3f);
  settings.conventions = Conventions::inria();
  for (const RendererEntry& entry : renderers()) {
    if (!entry.usable || entry.name.starts_with("cuda/") || !entry.name.ends_with("/ellipse")) continue;
    CAPTURE(entry.name);
    Both(entry).compare(builtin_camera(width, height), settings, camera_of_c(), conventions_named("inria"));
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
  constexpr Conventions::Depth depths[] = {Conventions::Depth::of_lens, Conventions::Depth::z,
                                           Conventions::Depth::distance};
  Both both(find_renderer("serial"));
  std::vector<Frame> all;
  for (const Lens& lens : lenses)
    for (const Conventions::Depth depth : depths) {
      CAPTURE(name_of(lens.model));
      CAPTURE(lens.is_distorted());
      CAPTURE(int(depth));
      Camera camera = builtin_camera(width, height);
      camera.lens = lens;
      if (lens.model == LensModel::orthographic) camera.fx = camera.fy = 15;
      if (lens.model == LensModel::equirectangular) camera.fx = camera.fy = 20;
      RenderSettings settings;
      settings.conventions.depth = depth;
      settings.conventions.depth_at = Conventions::DepthAt(all.size() % 2);
      swiftgs_camera given = camera_of_c();
      given.fx = camera.fx, given.fy = camera.fy, given.lens = int(lens.model);
      std::copy_n(lens.distortion.radial, 4, given.radial);
      std::copy_n(lens.distortion.rational, 3, given.rational);
      std::copy_n(lens.distortion.tangential, 2, given.tangential);
      std::copy_n(lens.distortion.prism, 2, given.prism);
      swiftgs_conventions conventions = conventions_named("gsplat");
      conventions.depth = int(depth), conventions.depth_at = int(settings.conventions.depth_at);
      all.push_back(both.compare(camera, settings, given, conventions));
    }
  // The lenses show different images, and the measures different depths.
  for (std::size_t i = 3; i < all.size(); i += 3) CHECK(all[i].colour != all[i - 3].colour);
  for (std::size_t i = 0; i < all.size(); i += 3) CHECK(all[i + 1].depth != all[i + 2].depth);
}

TEST_CASE("c: views into images of every format have the bits of the C++ interface") {
  Both both(find_renderer("serial"));
  const Camera camera = builtin_camera(width, height);
  const swiftgs_camera given = camera_of_c();
  std::vector<float> occluder(width * height);
  for (std::size_t i = 0; i < occluder.size(); ++i) occluder[i] = i % 3 ? 1 : 0.98f;
  std::set<std::vector<std::byte>> all;
  // Bottom row first, with gaps between rows. Half of the frames lie over an image and behind surfaces.
  const auto draw = [&](int format, int conversion, bool over) {
    const std::size_t row = width * bytes_per_pixel(PixelFormat(format)), pitch = row + 16;
    std::vector<std::byte> expected(height * pitch, std::byte(60)), found = expected;
    const auto last_row = [&](std::vector<std::byte>& image) { return &image[(height - 1) * pitch]; };
    FrameView frame{.width = width,
                    .height = height,
                    .colour = {last_row(expected), -std::ptrdiff_t(pitch)},
                    .format = PixelFormat(format),
                    .over = over,
                    .conversion = Conversion(conversion)};
    auto view = sized<swiftgs_view>();
    view.camera = &given, view.format = format, view.conversion = conversion, view.over = over;
    view.colour = {last_row(found), -std::int64_t(pitch)};
    for (int k = 0; k < 3; ++k) view.background[k] = 0.25f * float(k);
    if (over) {
      frame.occluder = {occluder.data(), sizeof(float) * width};
      frame.stored_depth = StoredDepth::perspective(0.1, 100);
      view.occluder = {occluder.data(), sizeof(float) * width};
      view.stored_depth = swiftgs_stored_perspective(0.1, 100);
    }
    const View drawn = make_view(camera, Conventions::gsplat(), frame, vec3(0, 0.25f, 0.5f));
    both.cpp->render_into({&drawn, 1});
    auto frame_of_c = sized<swiftgs_frame>();
    frame_of_c.views = &view, frame_of_c.count = 1;
    REQUIRE(swiftgs_renderer_render(both.c.get(), &frame_of_c) == SWIFTGS_OK);
    CHECK(found == expected);
    for (std::size_t y = 0; y < height; ++y)
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
  CHECK(camera.fx == moved.fx);
  CHECK(numbers(camera.translation) == of(moved.translation));
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      CHECK(camera.rotation[3 * row + column] == moved.rotation[column][row]);
}

TEST_CASE("c: placed scenes have the bits of the C++ interface") {
  Both both(find_renderer("serial"));
  const auto scene = make_scene();
  std::uint64_t number = 0;
  REQUIRE(swiftgs_renderer_add_scene(both.c.get(), scene.get(), &number) == SWIFTGS_OK);
  CHECK(number == both.cpp->add_scene(std::make_shared<const Scene>(make_builtin_scene(count))));

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
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      given[1].rotation[3 * row + column] = p.world_from_scene.rotation[column][row];
  given[1].scale = p.world_from_scene.scale, given[1].transparency = 1 - double(p.opacity);
  given[1].half_space_count = p.clip.half_space_count, given[1].radius = p.clip.radius;
  for (int k = 0; k < 3; ++k)
    given[1].translation[k] = p.world_from_scene.translation[k], given[1].centre[k] = p.clip.centre[k];
  for (int k = 0; k < 8; ++k) given[1].half_spaces[k] = p.clip.half_spaces[k / 4][k % 4];
  given[1].first = p.first, given[1].count = p.count, given[1].tint_amount = p.tint.amount;
  for (int k = 0; k < 3; ++k) given[1].tint[k] = p.tint.colour[k];
  REQUIRE(swiftgs_renderer_place(both.c.get(), given, 2) == SWIFTGS_OK);
  const Frame frame =
      both.compare(builtin_camera(width, height), {}, camera_of_c(), conventions_named("gsplat"));
  const auto of_second = [](std::uint32_t id) { return id != no_gaussian && id >= count; };
  CHECK(std::count_if(frame.id.begin(), frame.id.end(), of_second) > 100);
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
    CHECK((entry.on_device != 0) == renderers()[i].on_device);
    CHECK(renderers()[i].on_device == renderers()[i].name.starts_with("cuda/"));
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
  check(std::invalid_argument("one"), SWIFTGS_INVALID_ARGUMENT, "one");
  check(FormatError("file", 3, "four"), SWIFTGS_FORMAT_ERROR, "file: byte 3: expected four");
  check(Cancelled("file"), SWIFTGS_CANCELLED, "file: cancelled");
  check(std::system_error(std::make_error_code(std::errc::io_error), "five"), SWIFTGS_SYSTEM_ERROR,
        std::system_error(std::make_error_code(std::errc::io_error), "five").what());
  check(DeviceError("call", "six"), SWIFTGS_DEVICE_ERROR, "call: six");
  check(CapacityError("seven", 8, 9), SWIFTGS_CAPACITY_ERROR, "seven: 8 needed, the limit is 9");
  check(std::logic_error("ten"), SWIFTGS_LOGIC_ERROR, "ten");
  check(std::bad_alloc(), SWIFTGS_OUT_OF_MEMORY, "out of memory");
  check(std::length_error("vector"), SWIFTGS_OUT_OF_MEMORY, "out of memory");
  check(std::runtime_error("eleven"), SWIFTGS_UNAVAILABLE, "eleven");
  check(std::bad_cast(), SWIFTGS_INTERNAL_ERROR, std::bad_cast().what());
  check(12, SWIFTGS_INTERNAL_ERROR, "an exception without a text, expected one of the library");
}
