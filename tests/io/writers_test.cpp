// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <cstring>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <stdexcept>
#include <system_error>

#include <sys/resource.h>
#include <sys/stat.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/image.hpp>

#include "far_scene.hpp"
#include "scene_format.hpp"
#include "scenes.hpp"
#include "text.hpp"

namespace swiftgs::test::writers_test {

namespace fs = std::filesystem;

namespace {

/// While it lives a file of this process takes no more than `bytes`, as a full disk would.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    REQUIRE(::getrlimit(RLIMIT_FSIZE, &before_) == 0);
    const rlimit limit{bytes, before_.rlim_max};
    REQUIRE(::setrlimit(RLIMIT_FSIZE, &limit) == 0);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int) = SIG_DFL;
};

Frame noise() {
  Frame frame;
  frame.width = 96, frame.height = 64;
  std::uint32_t state = 1;
  for (std::size_t i = 0; i < 3 * frame.pixels(); ++i) {
    state = state * 1664525 + 1013904223;
    frame.colour.push_back(float(state >> 8) * 0x1p-24f);
  }
  return frame;
}

/// Endings of all formats that are written.
const Strings scene_endings = [] {
  Strings endings;
  for (const io::SceneFormat* format : io::scene_formats)
    if (format->write) endings.emplace_back(format->names[0]);
  return endings;
}();

using Writer = std::function<void(const fs::path&)>;

/// Every writer of a large file, by its ending; EXR where this build has it.
std::map<std::string, Writer> writers() {
  std::map<std::string, Writer> all{
      {"png", [](const fs::path& path) { write_png(path, noise()); }},
      {"pfm", [](const fs::path& path) { write_pfm(path, noise()); }},
  };
  const auto scene = std::make_shared<const Scene>(make_builtin_scene(2000));
  for (const std::string& ending : scene_endings)
    all[ending.substr(1)] = [=](const fs::path& path) { write_scene(path, *scene, {.ending = ending}); };
  const TemporaryFolder place;
  const Writer exr = [](const fs::path& path) { write_exr(path, noise()); };
  try {
    exr(place / "a.exr");
    all["exr"] = exr;
  } catch (const std::runtime_error&) {  // a build without OpenEXR
  }
  return all;
}

/// Numbers within what every format holds, and of degree 0.
Scene modest_scene(std::size_t count) {
  Scene scene = some_scene(count, 0);
  for (vec3& colour : scene.sh0) colour *= 0.5f;
  return scene;
}

}  // namespace

TEST_CASE("writers: a file that does not fit leaves what was there and nothing beside it") {
  for (const auto& [ending, write] : writers()) {
    CAPTURE(ending);
    const TemporaryFolder place;
    const fs::path old = place / ("old." + ending), none = place / ("none." + ending);
    place.write("old." + ending, "old");
    for (const fs::path& path : {old, none}) {
      const FileSizeLimit limit(8192);
      CHECK_THROWS_WITH_AS(write(path), doctest::Contains(path.filename().c_str()), std::system_error);
    }
    CHECK(content_of(old) == "old");
    CHECK(files_in(place.path()).size() == 1);
    write(old);
    CHECK(fs::file_size(old) > 8192);
    CHECK(files_in(place.path()).size() == 1);
  }
}

TEST_CASE("writers: a scene that is cancelled at any time leaves what was there, and else is written") {
  const Scene scene = make_builtin_scene(1000);
  const std::pair<std::string, int> formats[] = {{".compressed.ply", 4}, {".ply", 4}, {".sog", 4},
                                                 {".splat", 4},          {".spz", 4}, {".spz", 3}};
  for (const auto& [ending, spz_version] : formats) {
    CAPTURE(ending);
    CAPTURE(spz_version);
    const int version = spz_version;
    const TemporaryFolder place;
    const fs::path path = place / ("old" + ending);
    Listener writing;
    write_scene(path, scene, {.spz_version = version, .progress = writing.progress()});
    writing.check_whole();
    // How often a writer reports may differ from run to run, as it depends on time.
    for (int stop = 1; stop <= int(writing.told.size()); ++stop) {
      place.write("old" + ending, "old");
      int left = stop;
      bool stopped = false;
      try {
        write_scene(path, scene, {.spz_version = version, .progress = [&](double) { return --left > 0; }});
      } catch (const Cancelled&) {
        stopped = true;
      }
      CHECK(stopped == (left <= 0));
      CHECK((content_of(path) == "old") == stopped);
      CHECK(files_in(place.path()).size() == 1);
    }
  }
}

TEST_CASE("writers: a pipe takes the bytes that a file would hold") {
  for (const auto& [ending, write] : writers()) {
    CAPTURE(ending);
    const TemporaryFolder place;
    const fs::path pipe = place / "pipe", file = place / "file";
    REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
    auto read = std::async(std::launch::async, [&] { return content_of(pipe); });
    write(pipe);
    write(file);
    CHECK(fs::is_fifo(pipe));
    CHECK(read.get() == content_of(file));
    CHECK(files_in(place.path()).size() == 2);
  }
}

TEST_CASE("writers: scales of 0 are written as finite numbers") {
  for (const bool all : {false, true})
    for (const std::string& ending : scene_endings) {
      CAPTURE(ending);
      CAPTURE(all);
      Scene scene = modest_scene(300);
      for (std::size_t i = 0; i < scene.size(); ++i)
        if (all)
          scene.scales[i] = vec3(0.0f);
        else if (i % 2 == 0)
          scene.scales[i].z = 0;
      const Written written = write_and_read(scene, ending);
      const std::string& content = written.content;
      const std::size_t header = content.find("end_header\n");
      if (header != std::string::npos)  // floats: all of a PLY, and the ranges of a compressed one
        for (std::size_t at = header + 11, k = 0; at + 4 <= content.size() && (ending == ".ply" || k < 36);
             at += 4, ++k) {
          float number = 0;
          std::memcpy(&number, content.data() + at, 4);
          CHECK(std::isfinite(number));
        }
      for (const char* word : {"inf", "nan", "null"})
        if (ending == ".sog") CHECK(!contains(content.substr(0, content.find("means_l.webp")), word));
      REQUIRE(written.gaussians == 300);
      // The least scale of the format: SPZ and compressed PLY have no 0, and their writers say so.
      const float least = ending == ".spz"              ? std::exp(-10.0f)
                          : ending == ".compressed.ply" ? std::exp(-20.0f)
                                                        : 0;
      std::size_t flat = 0;
      for (const vec3& scale : written.scene().scales) flat += scale.z >= 0 && scale.z <= least * 1.0001f;
      CHECK(flat == (all ? 300 : 150));
    }
}

TEST_CASE("writers: every format leaves out or changes the same numbers and counts them") {
  Scene scene = modest_scene(300);
  scene.means[10].y = INFINITY;
  scene.scales[11].z = NAN;
  scene.rotations[12].w = -INFINITY;
  scene.opacities[13] = NAN;
  scene.sh0[14].x = INFINITY;
  scene.opacities[20] = 1.5f, scene.opacities[21] = -0.25f, scene.opacities[22] = 1, scene.opacities[23] = 0;
  scene.scales[30] = vec3(-1, 2, -0.5f);
  scene.rotations[40] = {0, 0, 0, 0};
  const Strings notes = {"Gaussians with a NaN or an infinity are left out: 5.",
                         "Gaussians whose quaternion is no rotation are left out: 1.",
                         "Opacities are clamped to 0 to 1: 2.",
                         "Scales below 0 are written without their sign, of Gaussians: 1."};
  for (const std::string& ending : scene_endings) {
    CAPTURE(ending);
    const Written written = write_and_read(scene, ending);
    CHECK(written.notes == notes);
    REQUIRE(written.gaussians == 294);
    const Scene& found = written.scene();
    const auto index_of = [&](std::size_t i) {  // in the file, as orders differ
      const auto distance = [&](const vec3& mean) { return glm::distance(mean, scene.means[i]); };
      const auto nearest = std::min_element(found.means.begin(), found.means.end(),
                                            [&](auto a, auto b) { return distance(a) < distance(b); });
      return std::size_t(nearest - found.means.begin());
    };
    CHECK(std::abs(found.opacities[index_of(20)] - 1) <= 2e-6);
    CHECK(std::abs(found.opacities[index_of(21)]) <= 2e-6);
    CHECK(found.scales[index_of(30)].x == doctest::Approx(1).epsilon(0.05));
    CHECK(found.scales[index_of(30)].z == doctest::Approx(0.5).epsilon(0.05));
    CHECK(glm::distance(found.means[index_of(40)], scene.means[40]) > 0.1f);
  }
}

TEST_CASE("writers: a NaN among the harmonics leaves its Gaussian out in every format") {
  Scene scene = some_scene(20, 2);
  scene.sh_rest[24 * 3 + 7] = NAN;
  for (const std::string& ending : scene_endings) {
    CAPTURE(ending);
    const Written written = write_and_read(scene, ending);
    CHECK(written.gaussians == 19);
    CHECK(written.notes.at(0) == "Gaussians with a NaN or an infinity are left out: 1.");
  }
}

TEST_CASE("writers: a scene with an origin keeps its places in a PLY and its shape in other formats") {
  const TemporaryFolder folder;
  const dvec3 far(10'000'000, -6'378'137, 4'000'000);
  const Scene scene = load_scene(folder.write("far.ply", far_scene(far, "double")));
  REQUIRE(scene.origin == far);
  for (const std::string& ending : scene_endings) {
    CAPTURE(ending);
    const WrittenScene written = write_scene(folder / ("a" + ending), scene);
    const std::string notes = all_notes(written.notes);
    const SceneFile file = read_scene(folder / ("a" + ending));
    CHECK(file.scene.size() == scene.size());
    CHECK(written.bytes == std::filesystem::file_size(folder / ("a" + ending)));
    if (ending == ".ply") {
      CHECK(contains(notes, "written as doubles, those in the world: the scene's origin is 10000000,"));
      CHECK(written.notes.size() == 1);
      CHECK(file.scene.origin == far);
      CHECK(file.scene.means == scene.means);
      CHECK(file.scene.opacities.size() == scene.opacities.size());
      CHECK(file.scene.scales[7].x == doctest::Approx(scene.scales[7].x));
    } else {
      CHECK(contains(notes, "The origin 10000000,-6378137,4000000 is left out: positions in the file are "));
      CHECK(file.scene.origin == dvec3(0));
      for (const vec3& mean : scene.means) {
        float nearest = INFINITY;
        for (const vec3& stored : file.scene.means) nearest = std::min(nearest, glm::distance(mean, stored));
        CHECK(nearest < 0.002f);
      }
    }
  }
}

TEST_CASE("writers: endings are known in upper and lower case") {
  const TemporaryFolder folder;
  const Scene scene = some_scene(10, 0);
  CHECK(write_scene(folder / "A.PLY", scene).format == "INRIA PLY (binary_little_endian)");
  CHECK(write_scene(folder / "A.Compressed.Ply", scene).format == "compressed PLY");
  CHECK(write_scene(folder / "A.SpZ", scene).format == "SPZ version 4");
  CHECK(write_scene(folder / "A.x", scene, {.ending = ".SOG"}).format == "SOG version 2");
  CHECK_NOTHROW(require_scene_ending("B.SPLAT"));
  CHECK_THROWS_AS(require_scene_ending("B.PLYX"), std::invalid_argument);
  CHECK(!io::has_ending("ly", ".ply"));
  CHECK(!io::has_ending("a[ply", ".ply"));
}

}  // namespace swiftgs::test::writers_test
