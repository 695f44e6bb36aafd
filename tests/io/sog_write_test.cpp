// SPDX-License-Identifier: Apache-2.0
#include <set>
#include <stdexcept>

#include <zip.h>

#include <swiftgs/edit/order.hpp>

#include "scenes.hpp"

namespace swiftgs::test::sog_write_test {

namespace {

Scene written_and_read(const Scene& scene) { return write_and_read(scene, ".sog").scene(); }

double signed_logarithm(double value) { return std::copysign(std::log1p(std::abs(value)), value); }

/// `scene` is in the order of the file.
void check_means(const Scene& scene, const Scene& read) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto [least, most] = std::minmax_element(scene.means.begin(), scene.means.end(),
                                                   [&](auto& a, auto& b) { return a[axis] < b[axis]; });
    const double step = (signed_logarithm((*most)[axis]) - signed_logarithm((*least)[axis])) / 65535;
    for (std::size_t i = 0; i < scene.size(); ++i) {
      const double error = signed_logarithm(read.means[i][axis]) - signed_logarithm(scene.means[i][axis]);
      CHECK(std::abs(error) <= 0.5001 * step + 1e-7 * std::abs(signed_logarithm(scene.means[i][axis])));
    }
  }
}

void check_rotations(const Scene& scene, const Scene& read) {
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const std::array<double, 4> errors = rotation_errors(scene.rotations[i], read.rotations[i]);
    for (std::size_t k = 0; k < 4; ++k)
      if (k != largest_of(scene.rotations[i])) CHECK(std::abs(errors[k]) <= 0.5001 * std::sqrt(2.0) / 255);
  }
}

/// Harmonics of few different numbers and sets, which the file can hold exactly.
void simplify_harmonics(Scene& scene, std::size_t sets) {
  const std::size_t width = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  for (std::size_t i = 0; i < scene.sh_rest.size(); ++i) {
    const std::size_t set = i / width % sets, k = i % width;
    scene.sh_rest[i] = float((set * 37 + k * 11 + set * set * k + set / 200 * k * k * 3) % 200) / 64 - 1;
  }
}

}  // namespace

TEST_CASE("sog: what is written is read back for every degree") {
  for (int degree = 0; degree <= 3; ++degree) {
    CAPTURE(degree);
    Scene scene = some_scene(2500, degree);
    scene.model.antialiased = degree % 2 == 1;
    simplify_harmonics(scene, 2000);  // of which the palette has room for 2048
    scene = order_spatially(scene);
    const Scene found = written_and_read(scene);
    const Difference apart = difference(scene, found);
    CHECK(found.model.antialiased == scene.model.antialiased);
    CHECK(found.sh_rest == scene.sh_rest);
    check_means(scene, found);
    check_rotations(scene, found);
    CHECK(apart.opacities <= 0.5001 / 255);
    // Both are spread evenly, over 6 and 2, so that steps are 6/256 and 2/256.
    CHECK(apart.scales < 0.7 * 6 / 256);
    CHECK(apart.sh0 < 0.7 * 2 / 256);
  }
}

TEST_CASE("sog: one Gaussian, alone or repeated, is exact but for its rotation and opacity") {
  for (const auto& [count, degree] : {std::pair{1u, 0}, {1u, 1}, {1u, 2}, {1u, 3}, {5000u, 3}}) {
    CAPTURE(count);
    const Scene scene = subset(some_scene(1, degree), std::vector<std::uint32_t>(count, 0));
    const Scene found = written_and_read(scene);
    const Difference apart = difference(scene, found);
    for (const vec3& mean : found.means)
      for (int axis = 0; axis < 3; ++axis)
        CHECK(mean[axis] == doctest::Approx(scene.means[0][axis]).epsilon(1e-6));
    CHECK(apart.scales < 1e-6);
    CHECK(found.sh0 == scene.sh0);
    CHECK(found.sh_rest == scene.sh_rest);
    CHECK(apart.opacities <= 0.5001 / 255);
    CHECK(std::set<float>(found.opacities.begin(), found.opacities.end()).size() == 1);
    check_rotations(scene, found);
  }
}

TEST_CASE("sog: scales of 0 stay 0 and leave the others alone") {
  Scene scene = some_scene(1000, 0);
  for (std::size_t i = 0; i < scene.size(); i += 3) scene.scales[i].z = 0;
  scene.scales[1] = vec3(0);
  scene.scales[2] = vec3(std::numeric_limits<float>::denorm_min());
  scene = order_spatially(scene);
  const Scene read = written_and_read(scene);
  for (std::size_t i = 0; i < scene.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const float scale = scene.scales[i][axis];
      CHECK((read.scales[i][axis] == 0) == (scale == 0));
      if (scale > 1e-30f) CHECK(std::abs(std::log(read.scales[i][axis] / scale)) < 0.05);
    }
  for (vec3& scale : scene.scales) scale = vec3(0);
  CHECK(written_and_read(scene).scales == scene.scales);
}

TEST_CASE("sog: means of all sizes keep their logarithms") {
  constexpr float largest = std::numeric_limits<float>::max();
  Scene scene = some_scene(100, 0);
  scene.means[0] = vec3(largest, -largest, largest);
  scene.means[1] = vec3(-largest, largest, 1e-30f);
  scene.means[2] = vec3(0.0f, -0.0f, 1e30f);
  scene = order_spatially(scene);
  check_means(scene, written_and_read(scene));
}

TEST_CASE("sog: every opacity that a byte holds is exact and 0 hides no colour") {
  Scene scene = some_scene(256, 0);
  for (std::size_t i = 0; i < 256; ++i) {
    scene.opacities[i] = float(i) / 255;
    scene.sh0[i] = vec3(float(i + 3), float(255 - i), 7.0f) / 64.0f;
  }
  scene.sh0[0] = vec3(0.25f, 1, 2);
  scene = order_spatially(scene);
  const Scene read = written_and_read(scene);
  CHECK(read.opacities == scene.opacities);
  CHECK(difference(scene, read).sh0 < 0.01);
}

TEST_CASE("sog: a huge number does not coarsen the others") {
  Scene scene = some_scene(3000, 1);
  simplify_harmonics(scene, 200);
  scene.sh0[7] = vec3(1e30f, -1e30f, 1e10f);
  scene.scales[8] = vec3(3e38f, 1, 1);
  scene.sh_rest[9 * 9] = 1e17f;
  scene.sh_rest[9 * 9 + 1] = -1e10f;
  scene = order_spatially(scene);
  const Scene read = written_and_read(scene);
  for (std::size_t i = 0; i < scene.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const float colour = scene.sh0[i][axis], scale = scene.scales[i][axis];
      CHECK(std::abs(read.sh0[i][axis] - colour) < 0.02 + 1e-6 * std::abs(colour));
      CHECK(std::abs(std::log(read.scales[i][axis] / scale)) < 0.06);
    }
  for (std::size_t i = 0; i < scene.sh_rest.size(); ++i)
    CHECK(std::abs(read.sh_rest[i] - scene.sh_rest[i]) <= 1e-6 * std::abs(scene.sh_rest[i]));
}

TEST_CASE("sog: harmonics that the file cannot hold are clamped and counted, and an empty scene is refused") {
  Scene scene = some_scene(50, 1);
  scene.sh_rest[9 * 5] = 1e30f;
  scene.sh_rest[9 * 6] = -3e38f;
  const Written written = write_and_read(scene, ".sog");
  CHECK(written.notes == Strings{"SH coefficients above band 0 are clamped to -1e18 to 1e18: 2."});
  const Scene& read = written.scene();
  CHECK(*std::max_element(read.sh_rest.begin(), read.sh_rest.end()) == 1e18f);
  CHECK(*std::min_element(read.sh_rest.begin(), read.sh_rest.end()) == -1e18f);

  const TemporaryFolder folder;
  CHECK_THROWS_WITH_AS(write_scene(folder / "b.sog", Scene()), doctest::Contains("b.sog: expected 1 to"),
                       std::invalid_argument);
  CHECK(!std::filesystem::exists(folder / "b.sog"));
}

TEST_CASE("sog: the same scene makes the same file") {
  const Scene scene = some_scene(20'000, 1);
  CHECK(write_and_read(scene, ".sog").content == write_and_read(scene, ".sog").content);
}

TEST_CASE("sog: the file is a ZIP of entries stored as they are") {
  const TemporaryFolder folder;
  write_scene(folder / "a.sog", some_scene(100, 2));
  zip_t* const archive = zip_open((folder / "a.sog").c_str(), ZIP_RDONLY | ZIP_CHECKCONS, nullptr);
  REQUIRE(archive);
  CHECK(zip_get_num_entries(archive, 0) == 8);
  for (const char* name : {"meta.json", "means_l.webp", "means_u.webp", "scales.webp", "quats.webp",
                           "sh0.webp", "shN_centroids.webp", "shN_labels.webp"}) {
    CAPTURE(name);
    zip_stat_t entry;
    REQUIRE(zip_stat(archive, name, 0, &entry) == 0);
    CHECK(entry.comp_method == ZIP_CM_STORE);
    std::string content(entry.size, '\0');
    zip_file_t* const file = zip_fopen(archive, name, 0);
    REQUIRE(file);
    CHECK(zip_fread(file, content.data(), entry.size) == zip_int64_t(entry.size));
    char beyond;
    CHECK(zip_fread(file, &beyond, 1) == 0);  // where the sum is checked
    zip_fclose(file);
  }
  zip_discard(archive);
}

}  // namespace swiftgs::test::sog_write_test
