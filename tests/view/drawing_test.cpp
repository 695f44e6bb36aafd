// SPDX-License-Identifier: Apache-2.0
#include "view/drawing.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>

#include "pages/scenes.hpp"
#include "view/angles.hpp"
#include "view/crop_error.hpp"

using namespace swiftgs;
using namespace swiftgs::cli;

namespace {

const std::string exact = "serial/early/axis-shared-threshold-float-cholesky/ellipse";
const std::string rough = "serial/early/axis-shared-half-split/ellipse";

/// One Gaussian 4 ahead of `camera`.
ShownScene ball(const std::string& name, float x, vec3 colour) {
  Scene scene;
  scene.means = {vec3(x, 0, 4)}, scene.scales = {vec3(0.3f)}, scene.rotations = {Quaternion()};
  scene.opacities = {0.9f}, scene.sh0 = {colour};
  return {{.file = name}, std::make_shared<const Scene>(std::move(scene)), {}};
}

Camera camera() { return look_at({0, 0, 0}, {0, 0, 1}, {0, -1, 0}, 0.8, 96, 64); }

/// The column of a ball's middle.
int column(double x) { return int(camera().fx * x / 4 + camera().cx); }

ShownScene generated() {
  return {{.file = "builtin"}, std::make_shared<const Scene>(make_builtin_scene(3000)), {}};
}

/// Changes scene `number` by `edit` of what its list says.
template <class Edit>
void change(Drawing& drawing, std::size_t number, const Edit& edit) {
  ListedScene listed = drawing.scenes()[number].listed;
  edit(listed);
  drawing.change(number, std::move(listed));
}

void hide(ListedScene& listed) { listed.visible = false; }

double brightness(const Frame& frame) {
  double sum = 0;
  for (const float value : frame.colour) sum += double(value);
  return sum;
}

}  // namespace

TEST_CASE("view drawing: a picked Gaussian is told by its scene though others are hidden") {
  Drawing drawing(exact, {}, {}, {ball("left", -1.4f, vec3(1, 0, 0)), ball("right", 1.4f, vec3(0, 1, 0))});
  const auto pick = [&](double x) {
    drawing.draw(camera(), false);
    return drawing.pick(column(x), 32);
  };
  const std::optional<Picked> right = pick(1.4);
  REQUIRE(right);
  CHECK(right->scene == 1);
  CHECK(right->name == "Gaussian 0");
  CHECK(right->depth == 4);
  CHECK(right->weight > 0.8f);
  CHECK(pick(-1.4)->scene == 0);
  CHECK_FALSE(pick(0));

  change(drawing, 0, hide);
  CHECK_FALSE(pick(-1.4));
  REQUIRE(pick(1.4));
  CHECK(pick(1.4)->scene == 1);
  change(drawing, 1, hide);
  CHECK_FALSE(pick(1.4));
  CHECK(brightness(drawing.picture()) == 0);
}

TEST_CASE("view drawing: scenes go where they are placed and one without Gaussians is refused") {
  Drawing drawing(exact, {}, {}, {ball("ball", -1.4f, vec3(1))});
  drawing.draw(camera(), false);
  CHECK_FALSE(drawing.pick(column(0.4), 32));
  const std::size_t before = drawing.version();
  change(drawing, 0, [](ListedScene& listed) { listed.world_from_scene.translation.x = 1.8; });
  CHECK(drawing.version() > before);
  drawing.draw(camera(), false);
  CHECK(drawing.pick(column(0.4), 32));

  CHECK_THROWS_AS(change(drawing, 0, [](ListedScene& listed) { listed.world_from_scene.scale = 0; }),
                  std::invalid_argument);
  CHECK(drawing.scenes()[0].listed.world_from_scene.scale == 1);
  const ShownScene empty{{.file = "empty.ply"}, std::make_shared<const Scene>(), {}};
  CHECK_THROWS_WITH_AS(drawing.add({ball("ball", 0, vec3(1)), empty}),
                       "empty.ply: expected a Gaussian or more to show, found none", std::invalid_argument);
  ShownScene beyond = ball("beyond", 0, vec3(1));
  beyond.listed.first = 2;
  CHECK_THROWS_AS(drawing.add({beyond}), std::invalid_argument);
  CHECK(drawing.scenes().size() == 1);
  change(drawing, 0, [](ListedScene& listed) { listed.opacity = 0.5f; });  // what was refused is not kept
}

TEST_CASE("view drawing: pages that memory does not hold are not added and those of before still show") {
  const test::TemporaryFolder folder;
  const auto paged = [&] {
    const PagedScene pages = test::pages_of(folder, test::ordered_scene(3000));
    return ShownScene{
        {.file = "scene.sgp"}, std::make_shared<const Scene>(pages.read(pages.root()).scene), pages};
  };
  const ShownScene first = paged();
  const double root = double(detail::resident_bytes(first.pages->pages()[first.pages->root()]));
  Drawing drawing(exact, {}, {.megabytes = 1.5e-6 * root}, {ball("ball", 0, vec3(0, 8, 0)), first});
  const auto drawn = [&] {
    drawing.draw(camera(), false);
    return drawing.picture().colour;
  };
  const std::vector<float> before = drawn();
  CHECK_THROWS_AS(drawing.add({paged()}), InvalidArgument);
  CHECK(drawing.scenes().size() == 2);
  CHECK(drawn() == before);
  drawing.add({ball("other", 1.4f, vec3(8, 0, 0))});
  CHECK(drawn() != before);
  CHECK(drawing.scenes().size() == 3);
}

TEST_CASE("view drawing: another renderer draws the same scenes") {
  Drawing drawing(exact, {}, {}, {ball("left", -1.4f, vec3(1)), ball("right", 1.4f, vec3(1))});
  change(drawing, 0, hide);
  drawing.draw(camera(), false);
  const std::vector<float> before = drawing.picture().colour;
  drawing.use(rough);
  CHECK(drawing.renderer().name() == rough);
  drawing.draw(camera(), false);
  CHECK(psnr(drawing.picture().colour, before) > 40);
  CHECK_THROWS_AS(drawing.use("serial/none"), std::invalid_argument);
  CHECK(drawing.renderer().name() == rough);
}

TEST_CASE("view drawing: a plane shows in place of colour") {
  Drawing drawing(exact, {}, {}, {ball("ball", 0, vec3(1, -1, -1))});
  drawing.draw(camera(), false);
  const std::vector<float> colour = drawing.picture().colour;
  drawing.show_plane("alpha");
  drawing.draw(camera(), false);
  const std::size_t middle = 3 * (32 * 96 + 48);
  CHECK(drawing.picture().colour[middle] == drawing.picture().colour[middle + 1]);
  CHECK(drawing.picture().colour[middle] == doctest::Approx(0.9).epsilon(0.01));
  CHECK(drawing.draw_apart(camera()) == colour);
  for (const char* plane : {"normal", "id"}) {
    CAPTURE(plane);
    drawing.show_plane(plane);
    drawing.draw(camera(), false);
    const std::vector<float>& picture = drawing.picture().colour;
    CHECK(vec3(picture[0], picture[1], picture[2]) == vec3(0));  // nothing shows in the corner
    CHECK(std::max({picture[middle], picture[middle + 1], picture[middle + 2]}) > 0.4f);
  }
  drawing.show_plane("");
  drawing.draw(camera(), false);
  CHECK(drawing.picture().colour == colour);
}

TEST_CASE("view drawing: the range of depths is that of what shows") {
  Drawing drawing(exact, {}, {}, {ball("left", -1.4f, vec3(1)), ball("right", 1.4f, vec3(1))});
  change(drawing, 1, [](ListedScene& listed) { listed.world_from_scene.scale = 2; });  // twice as far away
  drawing.draw(camera(), false);
  CHECK_FALSE(drawing.depth_range());
  drawing.show_plane("median_depth");
  drawing.draw(camera(), false);
  REQUIRE(drawing.depth_range());
  CHECK(drawing.depth_range()->low == 4);
  CHECK(drawing.depth_range()->high == 8);
  CHECK(drawing.depth_range()->part(8) == 1);
  CHECK(drawing.depth_range()->depth(0.5f) == doctest::Approx(std::sqrt(32.0)));
  change(drawing, 0, hide);
  drawing.draw(camera(), false);
  CHECK(drawing.depth_range()->low == 8);
  CHECK(drawing.depth_range()->part(8) == 0);
  change(drawing, 1, hide);
  drawing.draw(camera(), false);
  CHECK_FALSE(drawing.depth_range());
  drawing.show_plane("alpha");
  drawing.draw(camera(), false);
  CHECK_FALSE(drawing.depth_range());
}

TEST_CASE("view drawing: the error in a crop is that beside the reference of this picture and renderer") {
  Drawing drawing(exact, {}, {}, {generated()});
  const Camera whole = builtin_camera(), crop = crop_around(whole, 640, 400, CropError::side);
  CHECK(crop.width == CropError::side);
  CropError error;
  const auto wait_for = [&](const Camera& of) {
    std::optional<CropError::Error> found;
    while (!(found = error.of(drawing, of))) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return *found;
  };
  CHECK_FALSE(error.of(drawing, crop));
  CHECK(error.is_under_way());
  const double psnr_exact = wait_for(crop).psnr_db;
  CHECK_FALSE(error.is_under_way());
  CHECK(psnr_exact > 100);
  drawing.use(rough);
  const std::optional<CropError::Error> of_coarse = error.of(drawing, crop);  // no other reference
  REQUIRE(of_coarse);
  CHECK(of_coarse->psnr_db < psnr_exact - 20);

  // Moved scenes and other crops have references of their own.
  drawing.use(exact);
  change(drawing, 0, [](ListedScene& listed) {
    listed.world_from_scene.rotation = rotation_of({3, 2, 1});
    listed.first = 256, listed.count = 2000;
  });
  CHECK_FALSE(error.of(drawing, crop));
  CHECK(wait_for(crop).psnr_db > 100);
  CHECK_FALSE(error.of(drawing, crop_around(whole, 0, 0, CropError::side)));
  CHECK(wait_for(crop_around(whole, 640, 360, CropError::side)).psnr_db > 100);
}

TEST_CASE("view drawing: a crop shows its part of the picture") {
  const Camera whole = builtin_camera();
  const Camera corner = crop_around(whole, 0, whole.height, 64), middle = crop_around(whole, 640, 360, 64);
  CHECK(corner.cx == whole.cx);
  CHECK(corner.cy == whole.cy - (whole.height - 64));
  CHECK(middle.cx == 32);
  CHECK(middle.fx == whole.fx);
  CHECK(crop_around(camera(), 50, 50, 80).height == 64);
}

TEST_CASE("view drawing: angles of a rotation make the same rotation") {
  const dmat3 turned = rotation_of({30, -50, 140});
  for (const dmat3& rotation : {dmat3(1.0), turned, rotation_of({0, 90, 20}), rotation_of({-170, 5, -95})}) {
    const dmat3 again = rotation_of(angles_of(rotation));
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) CHECK(std::abs(again[i][j] - rotation[i][j]) < 1e-9);
  }
  // About x first.
  const dvec3 y = rotation_of({90, 0, 90}) * dvec3(0, 1, 0);
  CHECK(y.z == doctest::Approx(1));
  CHECK(std::signbit(angles_of(dmat3(1.0)).y) == false);
}

TEST_CASE("view drawing: a scene is called by its file or folder") {
  const auto name = [](const std::string& file) { return ShownScene{{.file = file}, nullptr, {}}.name(); };
  CHECK(name("captures/room.ply") == "room.ply");
  CHECK(name("captures/garden/") == "garden");
  CHECK(name("builtin:20") == "builtin:20");
  CHECK(name(".") == ".");
}
