// SPDX-License-Identifier: Apache-2.0
#include "formats/ply/ply_compressed.hpp"

#include <random>

#include <swiftgs/edit/order.hpp>

#include "compressed_ply_text.hpp"
#include "scenes.hpp"

namespace swiftgs::test::ply_compressed_test {

using namespace swiftgs::io;

namespace {

Written written_and_read(const Scene& scene) { return write_and_read(scene, ".compressed.ply"); }

}  // namespace

TEST_CASE("compressed ply: values lie between those of their chunk") {
  const SceneFile file = read(CompressedPly().text());
  const Scene& scene = file.scene;
  REQUIRE(scene.size() == 1);
  CHECK_NOTHROW(validate(scene));
  check_whole(file, "compressed PLY", 1);
  CHECK(scene.means[0] == vec3(7, 8, -9));
  for (int axis = 0; axis < 3; ++axis)
    CHECK(scene.scales[0][axis] == doctest::Approx(std::exp(-1.0 - axis)).epsilon(1e-7));
  CHECK(scene.opacities[0] == 1);
  CHECK(scene.sh0[0].x == 0);
  CHECK(scene.sh0[0].z == doctest::Approx(-0.5 / 0.28209479177387814).epsilon(1e-7));
  CHECK(scene.rotations[0].w > 0.999f);
  CHECK(scene.sh_degree == 0);
}

TEST_CASE("compressed ply: what is not read is noted by name") {
  const std::string text =
      with(CompressedPly().text(), "end_header", "element camera 1\nproperty uchar id\nend_header");
  CHECK(read(text + "x").notes == Strings{"Elements other than Gaussians were not read: camera."});
}

TEST_CASE("compressed ply: old files without ranges of colours hold colours") {
  CompressedPly file;
  file.ranges.resize(12), file.chunks.resize(12);
  file.vertices[3] = 0xff330000;
  const Scene scene = read(file.text()).scene;
  CHECK(scene.sh0[0].x == doctest::Approx(0.5 / 0.28209479177387814).epsilon(1e-7));
  CHECK(scene.sh0[0].y == doctest::Approx(-0.3 / 0.28209479177387814).epsilon(1e-7));
  CHECK(scene.opacities[0] == 0);
}

TEST_CASE("compressed ply: a chunk has 256 Gaussians") {
  CompressedPly file;
  file.repeat(258);
  std::vector<float> second = file.chunks;
  second[3] = 4094;
  file.chunks.insert(file.chunks.end(), second.begin(), second.end());
  const Scene scene = read(file.text()).scene;
  REQUIRE(scene.size() == 258);
  CHECK(scene.means[255].x == 7);
  CHECK(scene.means[256].x == 14);
  CHECK(scene.means[257].x == 14);
}

TEST_CASE("compressed ply: harmonics change from channel-major to RGB innermost") {
  for (const int degree : {1, 2, 3, 4}) {
    CompressedPly file;
    const int count = sh_rest_count(degree);
    file.harmonics = 3 * count;
    for (int i = 0; i < 3 * count; ++i) file.sh += char(i);
    const SceneFile back = read(file.text());
    const int kept = std::min(degree, 3);
    CHECK(back.scene.sh_degree == kept);
    CHECK(back.notes.size() == (degree > 3 ? 1 : 0));
    for (int j = 0; j < sh_rest_count(kept); ++j)
      for (int c = 0; c < 3; ++c) {
        const int byte = c * count + j;
        const double expected = byte == 0 ? -4 : (byte + 0.5) / 32 - 4;
        CHECK(back.scene.sh_rest[std::size_t(3 * j + c)] == expected);
      }
  }
}

TEST_CASE("compressed ply: comments say what the Gaussians are") {
  CompressedPly file;
  file.before = "comment SplatRenderMode: mip\n";
  CHECK(read(file.text()).scene.model.antialiased);
  file.before = "comment SplatRenderMode: 2dgs\n";
  const SceneFile flat = read(file.text());
  CHECK(flat.scene.scales[0].z == 0);
  CHECK(flat.notes.size() == 2);
  CHECK(flat.scene.model.kernel == RenderingModel::Kernel::disk);
}

TEST_CASE("compressed ply: properties are found by name") {
  CompressedPly file;
  std::swap(file.words[0], file.words[3]), std::swap(file.vertices[0], file.vertices[3]);
  std::swap(file.ranges[0], file.ranges[17]), std::swap(file.chunks[0], file.chunks[17]);
  CHECK(read(file.text()).scene.means == read(CompressedPly().text()).scene.means);
}

TEST_CASE("compressed ply: a range that is not finite drops its chunk and no other") {
  for (const float bad : {NAN, INFINITY}) {
    CompressedPly file;
    file.repeat(257);
    const std::vector<float> second = file.chunks;
    file.chunks[6] = bad;
    file.chunks.insert(file.chunks.end(), second.begin(), second.end());
    const SceneFile back = read(file.text());
    CHECK(back.left_out.not_finite == 256);
    CHECK(back.scene.size() == 1);
  }
}

TEST_CASE("compressed ply: elements that do not fit each other are refused") {
  CompressedPly file;
  CHECK(contains(complaint_about(CompressedPly().repeat(257).text()), "2 chunks for 257 vertices, found 1"));
  CHECK(contains(complaint_about(CompressedPly().repeat(0).text()), "0 chunks for 0 vertices, found 1"));
  file.harmonics = 9, file.sh = std::string(18, 'a');
  CHECK(contains(complaint_about(file.text()), "as many rows of 'sh' as of 'vertex', 1, found 2"));
  file.harmonics = 8, file.sh = std::string(8, 'a');
  CHECK(contains(complaint_about(file.text()), "found 8"));
  const char* cases[][3] = {{"binary_little", "binary_big", "binary_little_endian"},
                            {"float max_scale_z", "int max_scale_z", "'max_scale_z' of type float"},
                            {"uint packed_color", "int packed_color", "'packed_color' of type uint"},
                            {"packed_scale", "packed_sale", "'packed_scale' of element 'vertex'"},
                            {"max_b", "max_bee", "'max_b' of element 'chunk'"},
                            {"element vertex", "element vortex", "'vertex'"},
                            {"element vertex 1", "element vertex 18446744073709551615", "chunks for"}};
  for (const auto& [from, to, expected] : cases)
    CHECK_MESSAGE(contains(complaint_about(with(CompressedPly().text(), from, to)), expected), to);
}

TEST_CASE("compressed ply: what is written is read back to within half a step for every degree") {
  for (int degree = 0; degree <= 3; ++degree) {
    Scene scene = some_scene(1000, degree);
    scene.model.antialiased = degree % 2 == 1;
    const Written written = written_and_read(scene);
    const Scene& back = written.scene();
    CHECK(written.notes.empty());
    CHECK(back.model.antialiased == scene.model.antialiased);
    const Scene expected = order_spatially(scene);
    REQUIRE(back.size() == expected.size());
    for (std::size_t first = 0; first < 1000; first += 256) {
      const std::size_t end = std::min<std::size_t>(first + 256, 1000);
      const auto check = [&](const auto& value, vec3 steps, double rounding) {
        for (int axis = 0; axis < 3; ++axis) {
          float low = value(expected, first)[axis], high = low;
          for (std::size_t i = first; i < end; ++i) {
            low = std::min(low, value(expected, i)[axis]);
            high = std::max(high, value(expected, i)[axis]);
          }
          for (std::size_t i = first; i < end; ++i)
            REQUIRE(std::abs(value(back, i)[axis] - value(expected, i)[axis]) <=
                    0.5 * (high - low) / steps[axis] + rounding);
        }
      };
      check([](const Scene& s, std::size_t i) { return s.means[i]; }, {2047, 1023, 2047}, 1e-6);
      check([](const Scene& s, std::size_t i) { return glm::log(s.scales[i]); }, {2047, 1023, 2047}, 1e-6);
      check([](const Scene& s, std::size_t i) { return s.sh0[i]; }, {255, 255, 255}, 1e-6);
    }
    const Difference apart = difference(expected, back);
    CHECK(apart.opacities <= 0.5 / 255 + 1e-7);
    CHECK(apart.rotations < std::sqrt(2 * 4e-6));
    CHECK(apart.sh_rest <= 1.0 / 64);
  }
}

TEST_CASE("compressed ply: what the format cannot hold is clamped and counted") {
  Scene scene = some_scene(300, 1);
  scene.scales[0] = vec3(1, 0, 1);
  scene.scales[1] = vec3(1, std::exp(25.0f), 0);
  scene.sh_rest[9 * 2] = 5, scene.sh_rest[9 * 2 + 1] = -4;
  const Written written = written_and_read(scene);
  const Scene& back = written.scene();
  CHECK(written.notes == Strings{"Scales are clamped to exp(-20) to exp(20): 3.",
                                 "SH coefficients above band 0 are clamped to -4 to 4: 1."});
  float least = 1, most = 0;
  for (const vec3& scale : back.scales) least = std::min(least, scale.y), most = std::max(most, scale.y);
  CHECK(least == doctest::Approx(std::exp(-20.0)).epsilon(1e-5));
  CHECK(most == doctest::Approx(std::exp(20.0)).epsilon(1e-5));
}

TEST_CASE("compressed ply: scenes of no Gaussians or of one place survive being written") {
  CHECK(written_and_read({}).scene().size() == 0);
  const Scene one = some_scene(1, 0), back = written_and_read(one).scene();
  CHECK(back.means == one.means);
  CHECK(back.scales[0].x == doctest::Approx(one.scales[0].x).epsilon(1e-6));
}

TEST_CASE("compressed ply: rotations come back within half a step whichever component is largest") {
  std::mt19937 random(2);
  std::normal_distribution<double> value;
  const double half_step = std::sqrt(2.0) / 1023 / 2 + 1e-7;
  for (int i = 0; i < 4000; ++i) {
    std::array<double, 4> q = {value(random), value(random), value(random), value(random)};
    q[std::size_t(i % 4)] *= 8;
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const Quaternion unit{float(q[0] / length), float(q[1] / length), float(q[2] / length),
                          float(q[3] / length)};
    const Quaternion back = unpack_rotation(pack_rotation(unit));
    const std::array<double, 4> errors = rotation_errors(unit, back);
    const std::size_t largest = largest_of(unit);
    CHECK(std::array{back.w, back.x, back.y, back.z}[largest] > 0);
    for (std::size_t k = 0; k < 4; ++k)
      if (k != largest) REQUIRE(std::abs(errors[k]) <= half_step);
  }
}

TEST_CASE("compressed ply: rotations are w first and the identity is nearly itself") {
  const std::uint32_t third = 1u << 30 | 512u << 20 | 512u << 10 | 512u;  // x is the largest
  CHECK(unpack_rotation(third).x > 0.999f);
  CHECK(unpack_rotation(512u << 20 | 512u << 10 | 512u).w > 0.999f);
  const Quaternion too_long = unpack_rotation(0x3fffffff);  // three components of sqrt(1/2)
  CHECK(too_long.w == 0);
  CHECK(too_long.x == doctest::Approx(1 / std::sqrt(3.0)));
}

TEST_CASE("compressed ply: every harmonic gets the byte whose value is nearest") {
  for (int byte = 0; byte < 256; ++byte) CHECK(pack_sh(unpack_sh(std::uint8_t(byte)), byte % 3 == 0) == byte);
  CHECK(pack_sh(0, true) == 127);
  CHECK(pack_sh(0, false) == 128);
  for (int step = -5000; step <= 5000; ++step) {
    const float value = float(step) / 1001;
    float least = 100;
    for (int byte = 0; byte < 256; ++byte)
      least = std::min(least, std::abs(unpack_sh(std::uint8_t(byte)) - value));
    for (const bool lower : {false, true})
      REQUIRE(std::abs(unpack_sh(pack_sh(value, lower)) - value) == least);
  }
}

}  // namespace swiftgs::test::ply_compressed_test
