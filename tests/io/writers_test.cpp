// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <fstream>
#include <functional>
#include <future>
#include <map>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "support/files.hpp"

using namespace swiftgs;
using swiftgs::test::content_of;
using swiftgs::test::TemporaryFolder;

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

using Writer = std::function<void(const fs::path&)>;

/// Every writer of a large file, by its ending; EXR where this build has it.
std::map<std::string, Writer> writers() {
  std::map<std::string, Writer> all{
      {"png", [](const fs::path& path) { write_png(path, noise()); }},
      {"pfm", [](const fs::path& path) { write_pfm(path, noise()); }},
      {"spz", [](const fs::path& path) { write_scene(path, make_builtin_scene(2000), {.ending = ".spz"}); }},
      {"sog", [](const fs::path& path) { write_scene(path, make_builtin_scene(1000), {.ending = ".sog"}); }},
  };
  for (const std::string ending : {".compressed.ply", ".ply", ".splat"})
    all[ending.substr(1)] = [ending](const fs::path& path) {
      write_scene(path, make_builtin_scene(1000), {.ending = ending});
    };
  const TemporaryFolder place;
  const Writer exr = [](const fs::path& path) { write_exr(path, noise()); };
  try {
    exr(place / "a.exr");
    all["exr"] = exr;
  } catch (const std::runtime_error&) {  // a build without OpenEXR
  }
  return all;
}

std::ptrdiff_t files_in(const TemporaryFolder& place) {
  return std::distance(fs::directory_iterator(place.path()), fs::directory_iterator());
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
    CHECK(files_in(place) == 1);
    write(old);
    CHECK(fs::file_size(old) > 8192);
    CHECK(files_in(place) == 1);
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
    int calls = 0;
    double last = 0;
    const auto count = [&](double part) {
      CHECK(part >= last);
      CHECK(part <= 1);
      last = part;
      return ++calls > 0;
    };
    write_scene(path, scene, {.spz_version = version, .progress = count});
    CHECK(last == 1);
    // How often a writer reports may differ from run to run, as it depends on time.
    for (int stop = 1; stop <= calls; ++stop) {
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
      CHECK(files_in(place) == 1);
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
    CHECK(files_in(place) == 2);
  }
}
