// SPDX-License-Identifier: Apache-2.0
#include "mapped_file.hpp"

#include <fstream>
#include <numeric>
#include <string>

#include <unistd.h>

#include <swiftgs/io/scene_file.hpp>

#include "files.hpp"
#include "scenes.hpp"

using namespace swiftgs::test;
using swiftgs::io::MappedFile;

namespace {

/// Bytes of files that lie in this process's memory.
long resident_of_files() {
  std::ifstream statm("/proc/self/statm");
  long total = 0, resident = 0, shared = 0;
  statm >> total >> resident >> shared;
  return shared * ::sysconf(_SC_PAGESIZE);
}

long sum(std::span<const std::byte> bytes) {
  return std::accumulate(bytes.begin(), bytes.end(), 0L, [](long s, std::byte b) { return s + long(b); });
}

}  // namespace

TEST_CASE("mapped file: bytes that are let go of leave the memory and can be read again") {
  const TemporaryFolder folder;
  const long size = 16 << 20;
  const MappedFile file(folder.write("a", std::string(std::size_t(size), '\3')));
  const long before = resident_of_files();
  CHECK(sum(file.bytes()) == 3 * size);
  REQUIRE(resident_of_files() - before > size / 2);
  swiftgs::io::let_go({file.bytes(), "a", folder.path(), true}, 1000, std::uint64_t(size) - 1000);
  CHECK(resident_of_files() - before < size / 2);
  CHECK(sum(file.bytes()) == 3 * size);
}

TEST_CASE("mapped file: bytes from elsewhere stay when they are let go of") {
  const std::string content(1 << 20, '\3');
  swiftgs::io::let_go({as_bytes(content), "a"}, 0, content.size());
  CHECK(sum(as_bytes(content)) == 3 << 20);
}

TEST_CASE("mapped file: a scene's file does not stay in memory beside the scene") {
  const TemporaryFolder folder;
  for (const char* ending : {".ply", ".compressed.ply", ".splat"}) {
    CAPTURE(ending);
    const auto path = folder / (std::string("a") + ending);
    const auto size = long(swiftgs::write_scene(path, some_scene(60'000, 3)).bytes);
    const long before = resident_of_files();
    long at_end = -1;
    swiftgs::read_scene(path, {.progress = [&](double part) {
                          if (part == 1) at_end = resident_of_files() - before;
                          return true;
                        }});
    REQUIRE(at_end != -1);
    CHECK(at_end < size / 2);
  }
}
