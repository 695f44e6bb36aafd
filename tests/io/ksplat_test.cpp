// SPDX-License-Identifier: Apache-2.0
#include "scenes.hpp"
#include "spz_encoder.hpp"

namespace swiftgs::test::ksplat_test {

namespace {

constexpr double sh_constant = 0.28209479177387814;

/// A section of a .ksplat file. A test may falsify its header before `ksplat` puts the file together.
struct Section {
  std::string header = std::string(1024, '\0');
  std::string buckets{}, records{};
};

constexpr float block = 4, range = 32767;

/// Gaussians [begin, end) of `scene`, each in a bucket of `bucket_size` around (1, 2, 3) times its number.
/// All values are such that the level holds them exactly.
Section encode_section(const Scene& scene, std::size_t begin, std::size_t end, int level,
                       std::uint32_t bucket_size) {
  Section section;
  const std::size_t count = end - begin, buckets = (count + bucket_size - 1) / bucket_size;
  const std::size_t full = count / bucket_size;
  set(section.header, 0, std::uint32_t(count)), set(section.header, 4, std::uint32_t(count));
  set(section.header, 40, std::uint16_t(scene.sh_degree));
  if (level > 0) {
    set(section.header, 8, bucket_size), set(section.header, 12, std::uint32_t(buckets));
    set(section.header, 16, block), set(section.header, 20, std::uint16_t(12));
    set(section.header, 32, std::uint32_t(full)), set(section.header, 36, std::uint32_t(buckets - full));
    if (full != buckets) append(section.buckets, std::uint32_t(count - full * bucket_size));
    for (std::size_t b = 0; b < buckets; ++b)
      for (int axis = 1; axis <= 3; ++axis) append(section.buckets, float(b) * float(axis));
  }
  const auto number = [&](float value) {
    level == 0 ? append(section.records, value) : append(section.records, test::to_half(value));
  };
  const auto rest = std::size_t(sh_rest_count(scene.sh_degree));
  for (std::size_t i = begin; i < end; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      if (level == 0)
        append(section.records, scene.means[i][axis]);
      else {
        const double from_centre =
            double(scene.means[i][axis]) - double((i - begin) / bucket_size) * (axis + 1);
        append(section.records, std::uint16_t(std::lround(from_centre * range * 2 / block + range)));
      }
    }
    for (int axis = 0; axis < 3; ++axis) number(scene.scales[i][axis]);
    const Quaternion& q = scene.rotations[i];
    for (const float part : {q.w, q.x, q.y, q.z}) number(part);
    for (int c = 0; c < 3; ++c)
      section.records += quantise((0.5 + sh_constant * double(scene.sh0[i][c])) * 255);
    section.records += quantise(double(scene.opacities[i]) * 255);
    for (int degree = 1; degree <= scene.sh_degree; ++degree)
      for (std::size_t channel = 0; channel < 3; ++channel)
        for (auto k = std::size_t(sh_rest_count(degree - 1)); k < std::size_t(sh_rest_count(degree)); ++k) {
          const float value = scene.sh_rest[(i * rest + k) * 3 + channel];
          if (level < 2)
            number(value);
          else
            section.records += quantise((double(value) + 1.5) / 3 * 255);
        }
  }
  return section;
}

std::string ksplat(const std::vector<Section>& sections, int level) {
  std::string header(4096, '\0'), headers, bodies;
  std::uint32_t count = 0;
  for (const Section& section : sections) {
    std::uint32_t stored;
    std::memcpy(&stored, section.header.data(), 4);
    count += stored, headers += section.header, bodies += section.buckets + section.records;
  }
  header[1] = 1;
  const auto number = std::uint32_t(sections.size());
  set(header, 4, number), set(header, 8, number), set(header, 12, count), set(header, 16, count);
  set(header, 20, std::uint16_t(level));
  return header + headers + bodies;
}

/// Numbers that all levels hold, but for means and harmonics of a byte.
Scene exact_scene(std::size_t count, int degree) {
  Scene scene = some_scene(count, degree);
  const std::array<Quaternion, 3> turns = {{{1, 0, 0, 0}, {0.5f, -0.5f, 0.5f, 0.5f}, {0, 0, -1, 0}}};
  for (std::size_t i = 0; i < count; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      scene.means[i][axis] = std::fmod(scene.means[i][axis], 1.0f) + float(i / 8) * float(axis + 1);
      scene.scales[i][axis] = std::ldexp(1.0f, int(i) % 9 - 4 + axis);
      scene.sh0[i][axis] =
          float((std::round(double(scene.sh0[i][axis]) * 80 + 128) / 255 - 0.5) / sh_constant);
    }
    scene.rotations[i] = turns[i % 3];
    scene.opacities[i] = std::round(scene.opacities[i] * 255) / 255;
  }
  for (float& value : scene.sh_rest) value = std::round(value * 256) / 256;
  return scene;
}

void check_read(const SceneFile& file, const Scene& scene, int level) {
  check_whole(file, ".ksplat (level " + std::to_string(level) + ")", scene.size());
  const Difference apart = difference(scene, file.scene);
  CHECK(apart.means <= (level == 0 ? 0 : block / 4 / range + 1e-6));
  CHECK(file.scene.scales == scene.scales);
  CHECK(file.scene.rotations == scene.rotations);
  CHECK(apart.opacities < 1e-7);
  CHECK(apart.sh0 < 1e-6);
  CHECK(apart.sh_rest <= (level < 2 ? 0 : 1.5 / 255 + 1e-6));
}

std::string complaint_of(const std::string& content) { return complaint_about(content, "a.ksplat"); }

}  // namespace

TEST_CASE("ksplat: every level and degree is decoded within its quantisation") {
  for (int level = 0; level <= 2; ++level)
    for (int degree = 0; degree <= 3; ++degree) {
      CAPTURE(level);
      CAPTURE(degree);
      const Scene scene = exact_scene(37, degree);
      check_read(read(ksplat({encode_section(scene, 0, 37, level, 8)}, level)), scene, level);
      const Scene even = exact_scene(32, degree);
      check_read(read(ksplat({encode_section(even, 0, 32, level, 8)}, level)), even, level);
    }
}

TEST_CASE("ksplat: sections follow one another and may differ in degree") {
  const Scene scene = exact_scene(8, 2);
  Scene plain = scene;
  plain.sh_degree = 1, plain.sh_rest.assign(8 * 9, 0.5f);
  const Scene got =
      read(ksplat({encode_section(plain, 0, 8, 1, 8), encode_section(scene, 0, 8, 1, 8)}, 1)).scene;
  REQUIRE(got.size() == 16);
  CHECK(got.sh_degree == 2);
  for (std::size_t i = 0; i < 8; ++i) {
    CHECK(got.scales[i] == scene.scales[i]);
    CHECK(got.means[i] == got.means[8 + i]);
    for (std::size_t k = 0; k < 24; ++k) {
      CHECK(got.sh_rest[i * 24 + k] == (k < 9 ? 0.5f : 0));
      CHECK(got.sh_rest[(8 + i) * 24 + k] == scene.sh_rest[i * 24 + k]);
    }
  }
}

TEST_CASE("ksplat: buckets that are partly filled have counts of their own") {
  const Scene scene = exact_scene(24, 0);
  Section section = encode_section(scene, 0, 24, 1, 8);
  // One full bucket; of the others the first is empty, so its centre is stepped over.
  set(section.header, 12, std::uint32_t(4)), set(section.header, 32, std::uint32_t(1)),
      set(section.header, 36, std::uint32_t(3));
  std::string buckets;
  append(buckets, std::uint32_t(0)), append(buckets, std::uint32_t(8)), append(buckets, std::uint32_t(8));
  const std::string stray = std::string(12, '\x40');
  section.buckets = buckets + section.buckets.substr(0, 12) + stray + section.buckets.substr(12);
  check_read(read(ksplat({section}, 1)), scene, 1);
}

TEST_CASE("ksplat: buckets of level 0 are stepped over") {
  const Scene scene = exact_scene(9, 1);
  Section section = encode_section(scene, 0, 9, 0, 8);
  set(section.header, 12, std::uint32_t(2)), set(section.header, 20, std::uint16_t(12));
  section.buckets = std::string(24, 'x');
  check_read(read(ksplat({section}, 0)), scene, 0);
}

TEST_CASE("ksplat: a range in the header is what bytes of harmonics stand for") {
  std::string file = ksplat({encode_section(exact_scene(5, 1), 0, 5, 2, 8)}, 2);
  set(file, 36, -2.0f), set(file, 40, 6.0f);
  file.replace(file.size() - 9, 3, std::string("\x00\xff\x80", 3));
  const Scene scene = read(file).scene;
  CHECK(scene.sh_rest[4 * 9] == -2);
  CHECK(scene.sh_rest[4 * 9 + 3] == 6);
  CHECK(scene.sh_rest[4 * 9 + 6] == doctest::Approx(-2 + 128 / 255.0 * 8));
}

TEST_CASE("ksplat: a scale range in the header is what coordinates count from") {
  Section section = encode_section(exact_scene(5, 0), 0, 5, 1, 8);
  set(section.header, 24, std::uint32_t(1000));
  set(section.records, 0, std::uint16_t(1000)), set(section.records, 2, std::uint16_t(2000)),
      set(section.records, 4, std::uint16_t(0));
  CHECK(read(ksplat({section}, 1)).scene.means[0] == vec3(0, 2, -2));
}

TEST_CASE("ksplat: positions that float cannot hold are relative to an origin") {
  Section section = encode_section(exact_scene(5, 0), 0, 5, 1, 8);
  CHECK(read(ksplat({section}, 1)).notes.empty());
  // Floats are 1/2 apart there, and a bucket's side is 4.
  std::string centre;
  for (const float coordinate : {0.0f, 5403209.5f, 0.0f}) append(centre, coordinate);
  section.buckets.replace(section.buckets.size() - centre.size(), centre.size(), centre);
  for (int i = 0; i < 5; ++i) set(section.records, std::size_t(i) * 24 + 2, std::uint16_t(32767 + 2048));
  const SceneFile file = read(ksplat({section}, 1));
  REQUIRE(file.notes.size() == 1);
  CHECK(contains(file.notes[0], "relative to the origin "));
  for (const vec3& mean : file.scene.means)
    CHECK(std::abs(file.scene.origin.y + double(mean.y) - 5403209.625) < 1e-4);
}

TEST_CASE("ksplat: Gaussians that are not finite are dropped") {
  Section section = encode_section(exact_scene(5, 1), 0, 5, 1, 8);
  set(section.records, 6, std::uint16_t(0x7c00));
  const SceneFile file = read(ksplat({section}, 1));
  CHECK(file.stored == 5);
  CHECK(file.left_out.not_finite == 1);
  CHECK(file.scene.size() == 4);
}

TEST_CASE("ksplat: a quaternion of zeros leaves its Gaussian out") {
  for (int level = 0; level <= 2; ++level) {
    CAPTURE(level);
    Scene scene = exact_scene(5, 1);
    scene.rotations[3] = {0, 0, -0.0f, 0}, scene.rotations[4] = {0, 0, 1.0f / 1024, 0};
    const SceneFile file = read(ksplat({encode_section(scene, 0, 5, level, 8)}, level));
    CHECK(file.left_out.no_rotation == 1);
    CHECK(file.left_out.not_finite == 0);
    REQUIRE(file.scene.size() == 4);
    CHECK(file.scene.rotations[3] == Quaternion{0, 0, 1, 0});
  }
}

TEST_CASE("ksplat: a file that ends early is refused wherever it ends") {
  const Scene scene = exact_scene(9, 1);
  for (int level = 0; level <= 2; ++level) {
    const std::string file =
        ksplat({encode_section(scene, 0, 5, level, 2), encode_section(scene, 5, 9, level, 2)}, level);
    CHECK(complaint_of(file) == "");
    for (std::size_t length = 0; length<file.size(); length += length> 6144 ? 1 : 127)
      CHECK(contains(complaint_of(file.substr(0, length)), "expected"));
    CHECK(contains(complaint_of(file + "x"), "expected the end of the file"));
  }
}

TEST_CASE("ksplat: numbers of the header are refused only where they are used") {
  for (int level = 0; level <= 2; ++level) {
    const std::string file = ksplat({encode_section(exact_scene(9, 1), 0, 9, level, 4)}, level);
    CHECK(contains(complaint_of(with(file, 36, INFINITY)), "byte 36: expected a finite range") ==
          (level == 2));
    // More full buckets than there are, and none that would take bytes.
    CHECK(contains(complaint_of(with(file, 4096 + 32, 9u)), "buckets, found 9 full") == (level > 0));
    Section section = encode_section(exact_scene(9, 1), 0, 9, level, 4);
    const std::size_t centres = level == 0 ? 0 : 3 * 12;
    section.buckets.resize(section.buckets.size() - centres);
    set(section.header, 12, 3u), set(section.header, 20, std::uint16_t(0));
    CHECK(contains(complaint_of(ksplat({section}, level)), "12 bytes for the centre") == (level > 0));
  }
}

TEST_CASE("ksplat: a header that lies is refused") {
  const std::string file = ksplat({encode_section(exact_scene(9, 1), 0, 9, 1, 4)}, 1);
  CHECK(complaint_of(file) == "");
  const std::pair<std::string, const char*> cases[] = {
      {with(file, 0, char(1)), "byte 0: expected version 0.1 or later of .ksplat, found 1.1"},
      {with(file, 1, char(0)), "found 0.0"},
      {with(file, 20, std::uint16_t(3)), "byte 20: expected compression level 0 to 2, found 3"},
      {with(file, 4, 0xffffffffu), "headers of sections"},
      {with(file, 4, 0u), "expected the end of the file"},
      {with(file, 16, 8u), "byte 16: expected as many Gaussians"},
      {with(file, 4096, 10u), "byte 4096: expected at most 9 Gaussians"},
      {with(file, 4096 + 4, 0xffffffffu), "room for 4294967295 Gaussians"},
      {with(file, 4096 + 40, std::uint16_t(4)), "SH degree 0 to 3, found 4"},
      {with(file, 4096 + 20, std::uint16_t(16)), "12 bytes for the centre"},
      {with(file, 4096 + 12, 2u), "at most 2 buckets, found 2 full and 1 others"},
      {with(file, 4096 + 12, 0xffffffffu), "centres of buckets"},
      {with(file, 4096 + 8, 0xffffffffu), "full buckets of at most 9 Gaussians"},
      {with(file, 4096 + 8, 3u), "buckets for 9 Gaussians, found 7"},
      {with(file, 5120, 0u), "buckets for 9 Gaussians, found 8"}};
  for (const auto& [changed, expected] : cases)
    CHECK_MESSAGE(contains(complaint_of(changed), expected), expected);
  for (std::size_t i = 0; i < file.size(); ++i) {
    if (i == 100) i = 4096;
    if (i == 4200) i = 5120;
    CHECK_NOTHROW(complaint_of(with(file, i, char(file[i] ^ 0x95))));
  }
}

}  // namespace swiftgs::test::ksplat_test
