// SPDX-License-Identifier: Apache-2.0
#include <cstring>
#include <string>

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <swiftgs/error.hpp>
#include <swiftgs/tools/split_mix.hpp>

#include "pages/scenes.hpp"

namespace swiftgs::test::file_of_pages {
namespace {

PagedScene opened(std::string content) {
  const std::size_t size = content.size();
  return PagedScene(
      [content = std::move(content)](std::uint64_t offset, std::span<std::byte> to) {
        REQUIRE(offset + to.size() <= content.size());
        std::memcpy(to.data(), content.data() + offset, to.size());
      },
      size, "broken.sgp");
}

/// Opens a file and reads all of it. Empty, or what was wrong with it.
std::string complaint(const std::string& content) {
  try {
    const PagedScene pages = opened(content);
    for (std::uint32_t i = 0; i < pages.pages().size; ++i) pages.read(i);
  } catch (const FormatError& error) {
    return error.what();
  }
  return "";
}

std::string file_of(std::size_t count) {
  const TemporaryFolder folder;
  build_pages(make_builtin_scene(count), folder / "a.sgp", small_pages());
  return content_of(folder / "a.sgp");
}

TEST_CASE("pages: a file that ends early anywhere is refused") {
  const std::string whole = file_of(1500);
  CHECK(complaint(whole).empty());
  for (std::size_t size = 0; size < whole.size(); size += size < 400 ? 1 : 997)
    CHECK(contains(complaint(whole.substr(0, size)), "broken.sgp: byte "));
  CHECK(contains(complaint(whole + '\0'), "expected the size of the file"));
}

TEST_CASE("pages: no flipped bit of header table or content goes unnoticed") {
  const std::string whole = file_of(1500);
  SplitMix64 random(5);
  const std::size_t table = whole.size() - 11 * sizeof(Page);
  const auto flips = [&](std::size_t begin, std::size_t end, int count) {
    for (int k = 0; k < count; ++k) {
      std::string broken = whole;
      const std::size_t at = begin + random.bits() % (end - begin);
      broken[at] = char(broken[at] ^ (1 << random.bits() % 8));
      // Between pages there are zeros that nobody reads.
      const bool gap = [&] {
        const PagedScene pages = opened(whole);
        for (const Page& page : pages.pages())
          if (at >= page.offset && at < page.offset + page.bytes) return false;
        return at >= 192 && at < table;
      }();
      CHECK(complaint(broken).empty() == gap);
    }
  };
  CHECK(opened(whole).pages().size == 11);
  flips(0, 192, 400), flips(192, table, 100), flips(table, whole.size(), 200);
}

TEST_CASE("pages: a file says what it expected where") {
  const std::string whole = file_of(300);
  CHECK(complaint("ply\n") == "broken.sgp: byte 0: expected a header of 192 bytes, found 4");
  CHECK(complaint(std::string(500, 'x')) ==
        "broken.sgp: byte 0: expected a page file, as swiftgs pages writes it");
  std::string newer = whole;
  newer[8] = 9;
  CHECK(complaint(newer) == "broken.sgp: byte 8: expected version 1, found 9");
  const TemporaryFolder folder;
  CHECK_THROWS_AS(open_pages(folder / "none.sgp"), FileError);
  CHECK_THROWS_AS(open_pages(folder.path()), FileError);
  REQUIRE(::mkfifo((folder / "pipe").c_str(), 0600) == 0);  // which nobody writes to
  CHECK_FALSE(is_page_file(folder / "pipe"));
  CHECK_THROWS_AS(open_pages(folder / "pipe"), FileError);
  folder.write("empty.sgp", "");
  CHECK_THROWS_AS(open_pages(folder / "empty.sgp"), FormatError);
  CHECK_THROWS_AS(opened(whole).read(3), InvalidArgument);
}

TEST_CASE("pages: harmonics of every form come back as they were") {
  const TemporaryFolder folder;
  Scene scene = ordered_scene(600);
  const auto check = [&] { check_same(read_leaves(pages_of(folder, scene)), scene); };
  check();
  for (float& value : scene.sh_rest) value = std::round(value * 64) / 64;
  check();
  for (float& value : scene.sh_rest) value = std::round(value * 1024) / 1024;
  check();
  for (std::size_t i = 0; i < scene.sh_rest.size(); ++i) scene.sh_rest[i] = scene.sh_rest[i % 45] + 1e-7f;
  check();
  scene.origin = {4e6, 0, 1};
  scene.model = {.blur = 0.1f, .antialiased = true, .order = SplatOrder::distance};
  check();
  scene = with_degree(scene, 0);
  check();
}

}  // namespace
}  // namespace swiftgs::test::file_of_pages
