// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/project/sh.hpp>

#include "scenes.hpp"
#include "spz_encoder.hpp"

namespace swiftgs::test::spz_test {

namespace {

SceneFile read_spz(const std::string& content, SpzFrame frame = SpzFrame::raw) {
  return read_scene(as_bytes(content), "test.spz", {.spz_frame = frame});
}

/// A scene whose numbers every version stores without loss, rotations and scales aside.
Scene exact_scene(int sh_degree) {
  Scene scene = some_scene(40, sh_degree);
  for (vec3& mean : scene.means)
    for (int axis = 0; axis < 3; ++axis) mean[axis] = std::round(mean[axis] * 16) / 16;
  for (vec3& scale : scene.scales)
    for (int axis = 0; axis < 3; ++axis) scale[axis] = std::exp(std::round(std::log(scale[axis]) * 16) / 16);
  for (float& opacity : scene.opacities) opacity = std::round(opacity * 255) / 255;
  scene.opacities[0] = 0, scene.opacities[1] = 1;
  for (float& value : scene.sh_rest) value = std::round(value * 128) / 128;
  return scene;
}

}  // namespace

TEST_CASE("spz: every version and degree is decoded within its quantisation") {
  for (std::uint32_t version = 1; version <= 4; ++version)
    for (int degree = 0; degree <= 3; ++degree) {
      CAPTURE(version);
      CAPTURE(degree);
      const Scene scene = exact_scene(degree);
      SpzParts parts = encode_spz(scene, version);
      parts.flags = std::uint8_t(degree % 2);
      const SceneFile file = read_spz(pack_spz(parts));
      CHECK(file.scene.model.antialiased == (degree % 2 == 1));
      check_whole(file, "SPZ version " + std::to_string(version), scene.size());
      const Difference apart = difference(scene, file.scene);
      CHECK(apart.scales < 1e-5);
      CHECK(apart.sh0 < 0.0131);
      CHECK(file.scene.means == scene.means);
      if (version < 4) CHECK(read_spz(plain_spz(parts)).scene.means == scene.means);  // without gzip
      CHECK(file.scene.opacities == scene.opacities);
      CHECK(file.scene.sh_rest == scene.sh_rest);
      // Half a step of 2/255, and as much again for the length. A small w is the root of what the others
      // leave.
      const double xyz_error = version < 3 ? 0.011 : 0.0011, w_error = version < 3 ? 0.12 : 0.0011;
      for (std::size_t i = 0; i < scene.size(); ++i) {
        const Quaternion& b = file.scene.rotations[i];
        const auto [w, x, y, z] = rotation_errors(scene.rotations[i], b);
        CHECK(std::abs(w) < w_error);
        for (const double error : {x, y, z}) CHECK(std::abs(error) < xyz_error);
        CHECK(b.w * b.w + b.x * b.x + b.y * b.y + b.z * b.z == doctest::Approx(1).epsilon(1e-6));
      }
    }
}

TEST_CASE("spz: degree 4 is cut to degree 3 and said so") {
  for (std::uint32_t version = 1; version <= 4; ++version) {
    const Scene scene = exact_scene(3);
    SpzParts parts = encode_spz(scene, version);
    parts.sh_degree = 4;
    std::string wide;
    for (std::size_t i = 0; i < scene.size(); ++i)
      wide += parts.arrays[5].substr(i * 45, 45) + std::string(27, 'x');
    parts.arrays[5] = wide;
    const SceneFile file = read_spz(pack_spz(parts));
    CHECK(file.scene.sh_degree == 3);
    CHECK(file.scene.sh_rest == scene.sh_rest);
    CHECK(file.notes.size() == 1);
  }
}

TEST_CASE("spz: positions of version 1 that are not finite are dropped") {
  SpzParts parts = encode_spz(exact_scene(1), 1);
  parts.arrays[0].replace(0, 2, std::string("\x00\x7c", 2));   // infinity
  parts.arrays[0].replace(6, 2, std::string("\x01\x7e", 2));   // NaN
  parts.arrays[0].replace(12, 2, std::string("\x01\x00", 2));  // the least subnormal number
  const SceneFile file = read_spz(gzip_spz(parts));
  CHECK(file.left_out.not_finite == 2);
  CHECK(file.scene.size() == 38);
  CHECK(file.scene.means[0].x == std::ldexp(1.0f, -24));
}

TEST_CASE("spz: extensions are stepped over and told of and the axes that one states are honoured") {
  for (const std::uint32_t version : {1u, 2u, 3u, 4u}) {
    SpzParts parts = encode_spz(exact_scene(2), version);
    const Scene raw = read_spz(pack_spz(parts)).scene;
    parts.flags = 2;
    parts.extensions = spz_extension(0xADBE0002, "twelve bytes") + coordinate_system(7) +
                       spz_extension(0xAB, "") + spz_extension(0xCD, "payload");
    const SceneFile file = read_spz(pack_spz(parts), SpzFrame::specified);
    CHECK(file.scene.means[5] == vec3(-1, -1, 1) * raw.means[5]);
    REQUIRE(file.notes.size() == 3);
    CHECK(contains(file.notes[0], "orbit camera"));
    CHECK(contains(file.notes[1], "2, the first of type 0xab"));
    CHECK(contains(file.notes[2], "axes are LUF"));
    CHECK(contains(read_spz(pack_spz(parts), SpzFrame::rub).notes.at(2), "LUF"));
    CHECK(read_spz(pack_spz(parts), SpzFrame::luf).notes.size() == 2);
    CHECK(read_spz(pack_spz(parts), SpzFrame::rub).scene.means[5] == vec3(1, -1, -1) * raw.means[5]);
    CHECK(read_spz(pack_spz(parts), SpzFrame::raw).scene.means == raw.means);
    parts.extensions = "";
    CHECK(read_spz(pack_spz(parts), SpzFrame::specified).scene.means[5] == vec3(1, -1, -1) * raw.means[5]);
  }
}

TEST_CASE("spz: a coordinate system turns means and covariances and leaves colours as they were") {
  // Where RDF's x, y and z are stored, and their signs. LFD, RFD, LBU and RBU are as Niantic's library writes
  // them, and not as their letters say.
  struct Stored {
    int axis[3];
    double sign[3];
  };
  const Stored systems[] = {{{0, 1, 2}, {-1, 1, -1}}, {{0, 1, 2}, {1, 1, -1}},  {{0, 1, 2}, {-1, -1, -1}},
                            {{0, 1, 2}, {1, -1, -1}}, {{0, 1, 2}, {-1, 1, 1}},  {{0, 1, 2}, {1, 1, 1}},
                            {{0, 1, 2}, {-1, -1, 1}}, {{0, 1, 2}, {1, -1, 1}},  {{0, 2, 1}, {-1, -1, -1}},
                            {{0, 2, 1}, {1, -1, -1}}, {{0, 2, 1}, {-1, 1, -1}}, {{0, 2, 1}, {1, 1, -1}},
                            {{0, 2, 1}, {-1, -1, 1}}, {{0, 2, 1}, {1, -1, 1}},  {{0, 2, 1}, {-1, 1, 1}},
                            {{0, 2, 1}, {1, 1, 1}}};
  SpzParts parts = encode_spz(exact_scene(3), 3);
  parts.flags = 2;
  for (std::uint32_t system = 1; system <= 16; ++system) {
    CAPTURE(system);
    // Number k of the file is sign[k] times coordinate axis[k] of RDF.
    const Stored& stored = systems[system - 1];
    dmat3 to_rdf(0);
    for (int k = 0; k < 3; ++k) to_rdf[k][stored.axis[k]] = stored.sign[k];
    parts.extensions = coordinate_system(system);
    const Scene raw = read_spz(pack_spz(parts), SpzFrame::raw).scene;
    const Scene turned = read_spz(pack_spz(parts), SpzFrame::specified).scene;
    const SceneView raw_view = view(raw), turned_view = view(turned);
    for (std::size_t i = 0; i < raw.size(); ++i) {
      CHECK(turned.means[i] == vec3(to_rdf * dvec3(raw.means[i])));
      check_moved_covariance(turned, raw, i, to_rdf);
      const vec3 direction(0.36f, -0.48f, 0.8f);
      const vec3 seen = sh_colour(raw_view, i, direction),
                 seen_turned = sh_colour(turned_view, i, vec3(to_rdf * dvec3(direction)));
      for (int c = 0; c < 3; ++c) CHECK(std::abs(seen_turned[c] - seen[c]) < 1e-5);
    }
  }
}

TEST_CASE("spz: the named frames are those of the coordinate systems") {
  SpzParts parts = encode_spz(exact_scene(2), 4);
  const std::string plain = pack_spz(parts);
  parts.flags = 2;
  for (const auto& [frame, system] :
       {std::pair{SpzFrame::rub, 4u}, {SpzFrame::rdf, 6u}, {SpzFrame::luf, 7u}}) {
    parts.extensions = coordinate_system(system);
    check_same(read_spz(plain, frame).scene, read_spz(pack_spz(parts), SpzFrame::specified).scene);
  }
}

TEST_CASE("spz: progress is told within a stream") {
  const std::string content = stream_spz(encode_spz(some_scene(1'000'000, 0), 4));
  int reports = 0;
  const Progress watch = [&](double part) { return ++reports, part < 0.25; };
  // Of positions alone there are several megabytes, which make up less than half of unpacking.
  CHECK_THROWS_AS(read_scene(as_bytes(content), "a.spz", {.progress = watch}), Cancelled);
  CHECK(reports > 4);
}

}  // namespace swiftgs::test::spz_test
