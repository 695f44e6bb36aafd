// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include <glm/geometric.hpp>

#include <swiftgs/edit/select.hpp>

#include "far_scene.hpp"
#include "scenes.hpp"

namespace swiftgs::test::strays_test {

namespace {

constexpr std::size_t gaussians = 4000, every = 1000;

/// The way of stray `i` from the scene, which is 10 units large: in all directions, and not alike far.
vec3 way_of_stray(std::size_t i) {
  const float sign = i / every % 2 ? -1 : 1;
  return sign * vec3(3000, 100.0f * float(i) + 70, -2e6f / float(i + 1));
}

bool is_stray(std::size_t i) { return i % every == 0; }

Scene with_strays(Scene scene) {
  for (std::size_t i = 0; i < scene.size(); ++i)
    if (is_stray(i)) scene.means[i] += way_of_stray(i);
  return scene;
}

/// Small enough that every displacement shows.
Scene small_gaussians(std::size_t count) {
  Scene scene = some_scene(count, 0);
  for (vec3& scale : scene.scales) scale *= 0.01f;
  return scene;
}

/// Of the Gaussian of `found` that number `i` of `scene` became, by its colour and its place.
std::size_t number_in(const Scene& found, const Scene& scene, std::size_t i) {
  const auto apart = [&](std::size_t k) {
    return glm::distance(found.sh0[k], scene.sh0[i]) + 0.1f * glm::distance(found.means[k], scene.means[i]);
  };
  std::size_t best = 0;
  for (std::size_t k = 1; k < found.size(); ++k)
    if (apart(k) < apart(best)) best = k;
  return best;
}

/// For how many of `scene`, but for strays, `found` has no Gaussian within `distance`.
std::size_t lost(const Scene& scene, const Scene& found, float distance) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < scene.size(); ++i)
    count += !is_stray(i) && std::none_of(found.means.begin(), found.means.end(), [&](const vec3& mean) {
      return glm::distance(mean, scene.means[i]) < distance;
    });
  return count;
}

}  // namespace

TEST_CASE("strays: a scene in UTM metres with a Gaussian at zero gets its origin") {
  const TemporaryFolder folder;
  const dvec3 centre(512345.25, 5403209.75, 432.5);
  // The coordinates of the first row, which are the first numbers behind the header, become zeros.
  std::string content = far_scene(centre, "double");
  REQUIRE(contains(content, "\nproperty double x\nproperty double y\nproperty double z\n"));
  const std::string end = "end_header\n";
  std::fill_n(content.begin() + std::ptrdiff_t(content.find(end) + end.size()), 3 * sizeof(double), '\0');
  const SceneFile file = read(content, "utm.ply");
  REQUIRE(file.scene.size() == far_scene_size);
  CHECK(glm::distance(file.scene.origin, centre) < 2);
  CHECK(file.scene.origin + dvec3(file.scene.means[0]) == dvec3(0));
  const Scene near = read(far_scene(dvec3(0), "double")).scene;
  for (std::size_t i = 1; i < near.size(); ++i)
    CHECK(file.scene.origin + dvec3(file.scene.means[i]) == centre + dvec3(near.means[i]));
}

TEST_CASE("strays: a compressed PLY gives them chunks of their own") {
  // As many others as fill whole chunks, and as do not.
  for (const std::size_t count : {std::size_t(1026), gaussians}) {
    CAPTURE(count);
    const Scene scene = small_gaussians(count);
    const Written plain = write_and_read(scene, ".compressed.ply");
    const Written strayed = write_and_read(with_strays(scene), ".compressed.ply");
    const float step = 0.02f;  // of chunks of a part of the scene
    CHECK(lost(scene, plain.scene(), step) == 0);
    CHECK(lost(scene, strayed.scene(), step) == 0);
    const std::size_t strays = (count + every - 1) / every, added = (256 - (count - strays) % 256) % 256;
    CHECK(strayed.gaussians == count + added);
    CHECK(strayed.added == added);
    const Scene found = strayed.scene();
    REQUIRE(found.size() == count + added);
    const auto shows = [](float opacity) { return opacity > 0; };
    CHECK(std::size_t(std::count_if(found.opacities.begin(), found.opacities.end(), shows)) == count);
    CHECK(strayed.losses.position >= plain.losses.position);
  }
}

TEST_CASE("strays: extreme colours leave those of others in a compressed PLY") {
  Scene scene = small_gaussians(gaussians);
  for (std::size_t i = 0; i < scene.size(); i += every) scene.sh0[i] = vec3(1e5f, -3e4f, 2e5f);
  const Scene found = write_and_read(scene, ".compressed.ply").scene();
  std::size_t wrong = 0;
  for (const vec3& colour : scene.sh0)
    wrong += std::none_of(found.sh0.begin(), found.sh0.end(),
                          [&](const vec3& other) { return glm::distance(colour, other) < 0.02f; });
  CHECK(wrong == 0);
}

TEST_CASE("strays: an SPZ holds the others as finely as without them") {
  const Scene scene = small_gaussians(gaussians), strayed = with_strays(scene);
  const Written written = write_and_read(strayed, ".spz");
  CHECK(written.content[13] == 12);
  const std::string note = written.notes.back();
  CHECK(contains(note, "beyond coordinates of 2048, are moved nearer and made smaller"));
  CHECK(note.ends_with(": 4."));
  for (std::size_t i = 0; i < gaussians; ++i) {
    const vec3 &from = strayed.means[i], &to = written.scene().means[i];
    if (!is_stray(i)) {
      for (int axis = 0; axis < 3; ++axis) CHECK(std::abs(from[axis] - to[axis]) <= 0x1p-13f);
      continue;
    }
    // The same direction from the middle, and the same angle that it takes there.
    const double before = double(glm::length(from)), after = double(glm::length(to));
    CHECK(after < before);
    CHECK(std::max({std::abs(to.x), std::abs(to.y), std::abs(to.z)}) == doctest::Approx(2048).epsilon(1e-5));
    CHECK(glm::distance(from / float(before), to / float(after)) < 0.005f);
    for (int axis = 0; axis < 3; ++axis) {
      const float angle = std::max(strayed.scales[i][axis] / float(before), std::exp(-10.0f) / float(after));
      CHECK(std::log(written.scene().scales[i][axis] / float(after) / angle) ==
            doctest::Approx(0).epsilon(0.05));
    }
  }
  // Of a small scene too, whose positions have more digits.
  Scene small = small_gaussians(gaussians);
  for (vec3& mean : small.means) mean *= 0x1p-9f;
  const char bits = write_and_read(small, ".spz").content[13];
  CHECK(bits > 12);
  CHECK(write_and_read(with_strays(small), ".spz").content[13] == bits);
}

TEST_CASE("strays: they stay where they are in an SPZ that is fine enough, and where they are many") {
  Scene scene = small_gaussians(gaussians);
  for (vec3& mean : scene.means) mean *= 20.0f;
  scene.means[5].x = 5000;
  CHECK(write_and_read(scene, ".spz").content[13] == 10);
  scene.means[5].x = 1e6f;
  CHECK(write_and_read(scene, ".spz").content[13] == 12);
  for (std::size_t i = 0; i < gaussians; i += 250) scene.means[i].x = 1e6f;
  CHECK(write_and_read(scene, ".spz").content[13] == 3);
}

TEST_CASE("strays: a SOG holds the others nearly as finely as without them") {
  const Scene scene = small_gaussians(gaussians);
  const double plain = write_and_read(scene, ".sog").losses.position;
  const Scene found = write_and_read(with_strays(scene), ".sog").scene();
  CHECK(lost(scene, found, 8 * float(plain)) == 0);
}

TEST_CASE("losses: writers tell how far what they wrote is from the scene") {
  Scene scene = small_gaussians(700);
  scene.means[0].x = NAN;  // those after it have other numbers in the file
  scene.means[123] = vec3(0, 4000, 0.25f);
  for (const std::string ending : {".ply", ".compressed.ply", ".spz", ".sog", ".splat"}) {
    CAPTURE(ending);
    const Written written = write_and_read(scene, ending);
    const LargestLosses& losses = written.losses;
    LargestLosses found;
    for (std::size_t i = 1; i < scene.size(); ++i) {
      const std::size_t k = number_in(written.scene(), scene, i);
      const double moved = glm::distance(dvec3(scene.means[i]), dvec3(written.scene().means[k]));
      if (moved > found.position) found.position = moved, found.gaussian = i;
      const vec3& scale = scene.scales[i];
      found.displaced += moved > double(std::max({scale.x, scale.y, scale.z}));
      for (int axis = 0; axis < 3; ++axis) {
        const double ratio = double(written.scene().scales[k][axis]) / double(scale[axis]);
        found.scale = std::max({found.scale, ratio, 1 / ratio});
        found.colour = std::max(found.colour, 0.28209479177387814 * std::abs(double(scene.sh0[i][axis]) -
                                                                             written.scene().sh0[k][axis]));
      }
      found.opacity =
          std::max(found.opacity, std::abs(double(scene.opacities[i]) - written.scene().opacities[k]));
    }
    CHECK(losses.position == doctest::Approx(found.position).epsilon(1e-9));
    if (found.position > 0) CHECK(losses.gaussian == found.gaussian);
    CHECK(losses.displaced == found.displaced);
    if (ending == ".ply") continue;  // whose logarithms and logits are rounded to float
    CHECK(losses.scale == doctest::Approx(found.scale).epsilon(1e-6));
    CHECK(losses.colour == doctest::Approx(found.colour).epsilon(1e-6));
    CHECK(losses.opacity == doctest::Approx(found.opacity).epsilon(1e-6));
  }
}

TEST_CASE("losses: a displacement that shows is noted with its size and its Gaussian") {
  Scene scene = small_gaussians(256);  // one chunk, which a stray coarsens
  scene.means[17].x = 3000;
  const Written written = write_and_read(scene, ".compressed.ply");
  REQUIRE(written.notes.size() == 1);
  CHECK(written.losses.displaced > 50);
  CHECK(written.losses.position > 0.5);
  CHECK(written.losses.position < 0.9);
  CHECK(contains(written.notes[0], "Positions move by up to 0."));
  CHECK(contains(written.notes[0], " units (Gaussian " + std::to_string(written.losses.gaussian) + "). "));
  CHECK(written.notes[0].ends_with(": " + std::to_string(written.losses.displaced) + "."));
  // None of what no frame shows.
  scene.opacities.assign(scene.size(), 0.003f);
  CHECK(write_and_read(scene, ".compressed.ply").notes.empty());
}

}  // namespace swiftgs::test::strays_test
