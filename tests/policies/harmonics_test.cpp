// SPDX-License-Identifier: Apache-2.0

// Harmonics in fewer bytes than floats, against floats of the same numbers.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/memory/harmonic_packing.hpp>
#include <swiftgs/tools/parallel.hpp>

#include "colour.hpp"
#include "policies/arrays_on.hpp"
#include "policies/hooked.hpp"
#include "policies/planes.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

constexpr std::size_t count = 1000;

/// A scene whose harmonics are next(i, k) for float k of Gaussian i.
template <class F>
Scene scene_of(int degree, const F& next, std::size_t size = count) {
  Scene scene = random_scene(size, degree, 3);
  const std::size_t each = 3 * std::size_t(sh_rest_count(degree));
  for (std::size_t i = 0; i < scene.sh_rest.size(); ++i) scene.sh_rest[i] = next(i / each, i % each);
  return scene;
}

/// Numbers that are exactly what a format stores. A palette has 37 rows of floats.
Scene scene_in(const std::string& format, int degree, std::size_t size = count) {
  Random random(7);
  std::vector<float> palette(37 * 45);
  for (float& value : palette) value = random.f(-0.4, 0.4);
  return scene_of(
      degree,
      [&](std::size_t i, std::size_t k) {
        if (format == "palette") return palette[45 * (i * i % 37) + k];
        if (format == "bytes") return float(int(random.bits() % 256) - 128) / 256;
        if (format == "halves") return to_float(to_half(random.f(-0.5, 0.5)));
        return random.f(-0.5, 0.5);
      },
      size);
}
const char* const formats[] = {"palette", "bytes", "halves", "floats"};

HarmonicPacking packing_of(const Scene& scene, HarmonicsKept kept = HarmonicsKept::smallest) {
  return {Serial(), scene, used_sh_degree(scene), kept};
}
std::string format_of(const HarmonicPacking& packing) {
  return name_of(packing.rows_at(nullptr, packing.labels().data));
}
std::string format_of(const SceneView& scene) { return name_of(scene.sh_rest); }

/// `scene` with the harmonics that halves hold of it.
Scene in_halves(Scene scene) {
  for (float& value : scene.sh_rest) value = to_float(to_half(value));
  return scene;
}

/// Packed harmonics in memory of a backend, for views of uploaded scenes.
template <class B>
struct PackedOn {
  PackedOn(const B& backend, const Scene& scene) {
    const HarmonicPacking packing = packing_of(scene);
    std::vector<unsigned char> bytes(packing.rows() * packing.stride());
    for (std::size_t i = 0; i < packing.rows(); ++i) packing.write(i, &bytes[i * packing.stride()]);
    memory = to_backend(backend, bytes);
    labels =
        to_backend(backend, std::vector<std::uint16_t>(packing.labels().begin(), packing.labels().end()));
    rows = packing.rows_at(memory.data(), labels.data());
  }
  SceneView in(SceneView view) const {
    view.sh_rest = rows;
    return view;
  }

  HarmonicRows rows;
  typename B::template Buffer<unsigned char> memory;
  typename B::template Buffer<std::uint16_t> labels;
};

}  // namespace

TEST_CASE("harmonics: a scene takes the smallest format that is exact") {
  for (int degree = 1; degree <= max_sh_degree; ++degree)
    for (const std::string format : formats) {
      CAPTURE(degree);
      CAPTURE(format);
      const Scene scene = scene_in(format, degree);
      const HarmonicPacking packing = packing_of(scene);
      CHECK(format_of(packing) == format);
      CHECK(packing.stride() % 16 == 0);
      if (degree == 3 && format != "palette")
        CHECK(packing.stride() == (format == "bytes" ? 48 : format == "halves" ? 96 : 192));

      const PackedOn<Serial> packed(Serial(), scene);
      const HarmonicRows& rows = packed.rows;
      const std::size_t each = 3 * std::size_t(sh_rest_count(degree));
      std::vector<float> found(each);
      int wrong = 0;
      for (std::size_t i = 0; i < count; ++i) {
        rows.load(i, degree, found.data());
        for (std::size_t k = 0; k < each; ++k) {
          wrong += found[k] != scene.sh_rest[each * i + k];
          wrong += rows.part(i / 2, 700)[i - i / 2][int(k)] != found[k] && i - i / 2 < 700;
        }
      }
      CHECK(wrong == 0);
    }
}

TEST_CASE("harmonics: no format is chosen that a number lies one ulp beside") {
  for (const std::string format : {"bytes", "halves"}) {
    Scene scene = scene_in(format, 2);
    // In the last Gaussian, and in the first block.
    for (const std::size_t i : {scene.sh_rest.size() - 1, std::size_t(100)})
      for (const float towards : {-1.0f, 1.0f}) {
        const float before = scene.sh_rest[i];
        scene.sh_rest[i] = std::nextafter(before, towards);
        CHECK(format_of(packing_of(scene)) == "floats");
        scene.sh_rest[i] = before;
      }
  }
  const auto with = [](float value, const char* format) {
    Scene scene = scene_in(format, 2);
    scene.sh_rest.back() = value;
    return format_of(packing_of(scene));
  };
  // Bytes are k / 256, from -128 to 127, and some are odd.
  CHECK(with(127 / 256.0f, "bytes") == "bytes");
  CHECK(with(-0.5f, "bytes") == "bytes");
  CHECK(with(0.5f, "bytes") == "halves");
  CHECK(with(-129 / 256.0f, "bytes") == "halves");
  CHECK(with(1 / 512.0f, "bytes") == "halves");
  CHECK(with(1e-45f, "bytes") == "floats");
  CHECK(with(-0.0f, "bytes") == "bytes");
  CHECK(with(65504, "halves") == "halves");
  CHECK(with(65536, "halves") == "floats");
  CHECK(with(0x1p-24f, "halves") == "halves");  // the smallest half
  CHECK(with(-1023 * 0x1p-24f, "halves") == "halves");
  CHECK(with(0x1p-25f, "halves") == "floats");
  CHECK(with(1025.5f, "halves") == "floats");
}

TEST_CASE("harmonics: bytes have any scale that keeps all numbers normal") {
  const auto format = [](float scale) {
    return format_of(packing_of(scene_of(
        3, [&](std::size_t i, std::size_t k) { return scale * float(int((31 * i + 7 * k) % 256) - 128); })));
  };
  for (const float scale : {0x1p-126f, 0x1p-7f, 1.0f, 0x1p96f}) CHECK(format(scale) == "bytes");
  CHECK(format(0x1p-127f) != "bytes");
  CHECK(format(0x1p97f) != "bytes");
}

TEST_CASE("harmonics: a palette has at most 65536 rows and is smaller than what it takes the place of") {
  constexpr std::size_t many = 140'000;
  const auto of_rows = [](std::size_t rows, std::size_t size, float scale) {
    return scene_of(
        1, [&](std::size_t i, std::size_t k) { return scale * float(i % rows + k); }, size);
  };
  const HarmonicPacking most = packing_of(of_rows(65'536, many, 1 / 3.0f));
  CHECK(format_of(most) == "palette");
  CHECK(most.rows() == 65'536);
  CHECK(most.bytes() == 48 * 65'536 + 2 * many);
  CHECK(format_of(packing_of(of_rows(65'537, many, 1 / 3.0f))) == "floats");
  // 48 bytes a row and 2 a Gaussian, against 48 and against 16.
  CHECK(format_of(packing_of(of_rows(958, 1000, 1 / 3.0f))) == "palette");
  CHECK(format_of(packing_of(of_rows(959, 1000, 1 / 3.0f))) == "floats");
  const auto of_bytes = [&](std::size_t rows) { return format_of(packing_of(of_rows(rows, 400, 1))); };
  CHECK(of_bytes(116) == "palette");
  CHECK(of_bytes(117) == "bytes");
}

TEST_CASE("harmonics: all threads find what one finds") {
  for (const std::string format : formats) {
    const Scene scene = scene_in(format, 1, 20'000);
    CHECK(format_of(HarmonicPacking(HostThreads(), scene, 1, HarmonicsKept::smallest)) == format);
  }
}

SWIFTGS_CONTRACT("harmonics: frames have the bits of floats in every format and to any degree") {
  Usual<B> renderer(test::make_backend<B>());
  for (int stored = 1; stored <= max_sh_degree; ++stored)
    for (const std::string format : formats) {
      const Scene scene = scene_in(format, stored);
      const auto floats = backend.upload(scene, HarmonicsKept::floats);
      const auto smallest = backend.upload(scene);
      CHECK(format_of(floats.view()) == "floats");
      CHECK(format_of(smallest.view()) == format);
      const auto shared = backend.upload(std::make_shared<const Scene>(scene));
      CHECK(format_of(shared.view()) == (on_host<B> ? "floats" : format));
      const PackedOn<B> packed(backend, scene);
      for (int degree = 0; degree <= stored; ++degree) {
        CAPTURE(stored);
        CAPTURE(format);
        CAPTURE(degree);
        SceneView expected = floats.view(), found = smallest.view();
        expected.sh_degree = found.sh_degree = degree;
        check_same<B>(renderer, packed.in(expected), expected);
        check_same<B>(renderer, found, expected);
      }
    }
}

SWIFTGS_CONTRACT("harmonics: placed scenes of several formats share warps") {
  Usual<B> renderer(test::make_backend<B>());
  std::vector<PlacedScene> packed, expected;
  std::vector<typename B::SceneOn> uploaded;
  std::vector<PackedOn<B>> rows;
  for (int degree = 0; degree <= max_sh_degree; ++degree)
    for (const std::string format : formats) {
      const Scene scene = scene_in(format, degree, 160);
      uploaded.push_back(backend.upload(scene, HarmonicsKept::floats));
      rows.emplace_back(backend, scene);
    }
  for (const std::size_t size : {5, 50, 3})
    for (std::size_t i = 0; i < uploaded.size(); ++i) {
      const Similarity where{.translation = dvec3(0.1 * double(i), 0, 0)};
      const SceneView view = uploaded[i].view();
      packed.push_back({range_of(rows[i].in(view), 2 * size, size), where});
      expected.push_back({range_of(view, 2 * size, size), where});
    }
  check_same<B>(renderer, packed, expected);
}

SWIFTGS_CONTRACT("harmonics: colours whose sums leave the range of float are found in every format") {
  Usual<B> renderer(test::make_backend<B>());
  RenderSettings settings;
  settings.count = true;
  for (const std::string format : {"palette", "bytes", "halves"}) {
    CAPTURE(format);
    Scene scene = scene_in(format, 3);
    const float large = format == "palette" ? 3e38f : format == "bytes" ? 0x1p96f * 127 : 65504.0f;
    for (std::size_t k = 0; k < scene.sh_rest.size(); ++k)
      if (k / 45 % 37 % 3 == 0) {
        scene.sh_rest[k] = k % 2 == 0 ? large : -large;
      } else if (format == "bytes") {
        scene.sh_rest[k] *= 0x1p104f;
      }
    for (std::size_t i = 0; i < count; i += 5) scene.sh0[i] = vec3(3e38f, -3e38f, i % 2 ? 3e38f : 0);
    REQUIRE(format_of(packing_of(scene)) == format);
    const auto floats = backend.upload(scene, HarmonicsKept::floats);
    const PackedOn<B> packed(backend, scene);
    check_same<B>(renderer, packed.in(floats.view()), floats, settings);
  }
}

SWIFTGS_CONTRACT("harmonics: halves are the nearest and of colours as near as is said") {
  Usual<B> renderer(test::make_backend<B>());
  Random random(4);
  const Scene scene = scene_of(3, [&](std::size_t i, std::size_t) {
    return i % 3 == 0 ? random.f(-1, 1) : random.f(-1, 1) * (i % 3 == 1 ? 1e-6f : 1e3f);
  });
  const Scene rounded = in_halves(scene);
  const auto moved = backend.upload(Scene(scene), HarmonicsKept::halves);
  const auto shared = backend.upload(std::make_shared<const Scene>(scene), HarmonicsKept::halves);
  const auto expected = backend.upload(rounded, HarmonicsKept::floats);
  CHECK(format_of(moved.view()) == "halves");
  CHECK(moved.view().sh_rest.stride == 96);
  check_same<B>(renderer, moved, expected);
  check_same<B>(renderer, shared, expected);
  // The float64 reference, of both.
  double most = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d direction =
        Eigen::Vector3d(random.in(-1, 1), random.in(-1, 1), random.in(-1, 1)).normalized();
    const auto basis = reference::sh_basis(direction);
    const Eigen::Vector3d off =
        reference::colour(rounded, i, direction) - reference::colour(scene, i, direction);
    for (int c = 0; c < 3; ++c) {
      double bound = 0;
      for (std::size_t k = 0; k < 15; ++k) {
        CHECK(std::abs(basis[k + 1]) < 1.2);
        bound +=
            std::abs(basis[k + 1]) *
            std::max(0x1p-11 * std::abs(double(scene.sh_rest[45 * i + 3 * k + std::size_t(c)])), 0x1p-25);
      }
      most = std::max(most, std::abs(off[c]) / bound);
    }
  }
  CHECK(most <= 1 + 1e-9);
  CHECK(most > 0.2);
}

SWIFTGS_CONTRACT("harmonics: numbers that no half holds are refused") {
  Scene scene = scene_in("floats", 2);
  for (const float value : {65504.0f, -65504.0f}) {
    scene.sh_rest[24 * 11 + 5] = value;
    CHECK_NOTHROW((void)backend.upload(scene, HarmonicsKept::halves));
  }
  scene.sh_rest[24 * 11 + 5] = -65505;
  CHECK_THROWS_WITH_AS((void)backend.upload(scene, HarmonicsKept::halves),
                       doctest::Contains("sh_rest of Gaussian 11 is -65505.0"), std::invalid_argument);
  CHECK_NOTHROW((void)backend.upload(scene));
  scene.sh_rest[24 * 11 + 5] = std::numeric_limits<float>::infinity();
  CHECK_THROWS_AS((void)backend.upload(scene, HarmonicsKept::halves), std::invalid_argument);
}

SWIFTGS_CONTRACT("harmonics: packed ones stay in updates and all else is replaced") {
  Usual<B> renderer(test::make_backend<B>());
  const Scene before = scene_in("halves", 2), other = random_scene(300, 2, 8);
  const ArraysOn<B> arrays(backend, other);
  const auto shared = std::make_shared<const Scene>(before);
  for (const bool shares : {true, false}) {
    auto scene = shares ? backend.upload(shared, HarmonicsKept::halves)
                        : backend.upload(Scene(before), HarmonicsKept::halves);
    CHECK_THROWS_WITH_AS(
        backend.update(scene, 100, arrays.all),
        doctest::Contains(
            "the scene keeps sh_rest as halves, expected floats: upload it with HarmonicsKept::floats"),
        std::invalid_argument);
    const Frame unchanged = renderer.render(backend.upload(before), cameras_around()[0], {});
    CHECK(same_planes(renderer.render(scene, cameras_around()[0], {}), unchanged));

    PlanesOn<B> planes(backend, 120, 80, all_planes(0), 0);
    const View view = make_view(cameras_around()[0], {}, planes.view());
    Report<B> report;
    const SceneArrays rest = some_of(arrays.all, every_array & ~sh_rest_alone);
    Scene expected = before;
    for (const std::size_t first : {0, 100, 700}) {
      backend.update(scene, first, rest);
      replace(expected, first, other, every_array & ~sh_rest_alone);
      if (first == 0) {
        renderer.reserve(scene.view(), {&view, 1}, {4000, 100'000});
      } else {
        renderer.record(scene.view(), report.data());
        CHECK(report.get(backend).overflowed == 0);
      }
      Usual<B> fresh(test::make_backend<B>());
      const Frame frame = fresh.render(backend.upload(expected), cameras_around()[0], settings_of_all());
      CHECK(same_planes(fresh.render(scene, cameras_around()[0], settings_of_all()), frame));
      if (first != 0) CHECK(same_planes(planes.on_host(backend), frame));
    }
    CHECK(same_bits(shared->means, before.means));
  }
}

SWIFTGS_CONTRACT("harmonics: renderers by name upload scenes as they are told") {
  const auto renderer = make_renderer(std::string(B::name) + "/early/per-pixel/ellipse");
  const auto scene = std::make_shared<const Scene>(scene_in("floats", 3));
  renderer->set_scene(scene);
  CHECK(renderer->harmonics(0) == std::string("floats"));
  renderer->set_scene(scene, HarmonicsKept::halves);
  CHECK(renderer->harmonics(0) == std::string("halves"));
  CHECK_THROWS_WITH_AS((void)renderer->harmonics(1), "harmonics: the scene is number 1, expected less than 1",
                       std::invalid_argument);
  REQUIRE(renderer->add_scene(scene) == 1);
  REQUIRE(renderer->add_scene(scene, HarmonicsKept::halves) == 2);
  CHECK(renderer->harmonics(1) == std::string("floats"));
  CHECK(renderer->harmonics(2) == std::string("halves"));
}

TEST_CASE("harmonics: packed rows need multiples of 16 bytes") {
  const Scene scene = scene_in("bytes", 3);
  const PackedOn<Serial> packed(Serial(), scene);
  SceneView view = packed.in(swiftgs::view(scene));
  CHECK_NOTHROW(validate(view));
  view.sh_rest.stride = 56;
  CHECK_THROWS_WITH_AS(
      validate(view),
      doctest::Contains("56 bytes apart; expected 1000 values, 45 bytes or more apart, in multiples of 16"),
      std::invalid_argument);
  view.sh_rest.stride = 32;
  CHECK_THROWS_AS(validate(view), std::invalid_argument);
}
