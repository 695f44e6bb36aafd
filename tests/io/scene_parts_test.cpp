// SPDX-License-Identifier: Apache-2.0

// Parts of a scene make up the whole, whether they are read or made.
#include <algorithm>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit/select.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/tools/scene_part.hpp>

#include "far_scene.hpp"
#include "ply_text.hpp"

namespace swiftgs::test::scene_parts_test {

namespace {

bool same_bits(const Scene& a, const Scene& b) {
  bool same = a.sh_degree == b.sh_degree && a.model == b.model && a.origin == b.origin;
  for_each_array(
      [&](const char*, std::size_t, const auto& one, const auto& other) {
        same = same && std::ranges::equal(std::as_bytes(std::span(one)), std::as_bytes(std::span(other)));
      },
      a, b);
  return same;
}

/// The scene of parts 0 to `of` - 1, which `make(part)` returns.
template <class Make>
Scene joined(std::size_t of, const Make& make) {
  Scene whole = make(ScenePart{0, of});
  for (std::size_t i = 1; i < of; ++i) {
    const Scene part = make(ScenePart{i, of});
    CHECK(part.sh_degree == whole.sh_degree);
    CHECK(part.origin == whole.origin);
    append(whole, part);
  }
  return whole;
}

}  // namespace

TEST_CASE("scene parts: they are of one size and follow each other") {
  for (const std::size_t count : {0, 1, 5, 1000, 1001}) {
    std::size_t before = 0;
    for (std::size_t i = 0; i < 7; ++i) {
      const ScenePart::Range range = ScenePart{i, 7}.range(count);
      CHECK(range.begin == before);
      CHECK((range.size() == count / 7 || range.size() == count / 7 + 1));
      before = range.end;
    }
    CHECK(before == count);
  }
  CHECK_THROWS_WITH_AS(validate(ScenePart{3, 3}),
                       "scene: the part is number 3 of 3, expected 0 and up of 1 to 65535",
                       std::invalid_argument);
}

TEST_CASE("scene parts: the built-in scene is made in parts") {
  for (const auto& [count, of] : {std::pair{1u, 3u}, {997u, 2u}, {997u, 16u}})
    CHECK(same_bits(joined(of, [size = count](ScenePart part) { return make_builtin_scene(size, part); }),
                    make_builtin_scene(count)));
}

TEST_CASE("scene parts: files are read in parts") {
  const test::TemporaryFolder folder;
  Scene scene = make_builtin_scene(1'001);
  for (const char* name : {"a.ply", "a.compressed.ply", "a.splat", "a.spz"}) {
    const auto path = folder / name;
    write_scene(path, scene);
    const SceneFile whole = read_scene(path);
    CAPTURE(name);
    for (const std::size_t of : {1, 2, 3, 5}) {
      std::uint64_t stored = 0;
      const Scene parts = joined(of, [&](ScenePart part) {
        SceneFile file = read_scene(path, {.part = part});
        stored += file.stored;
        return std::move(file.scene);
      });
      CHECK(same_bits(parts, whole.scene));
      CHECK(stored == 1'001);
    }
  }
}

TEST_CASE("scene parts: text is read in parts and what cannot be drawn is dropped from each") {
  const test::TemporaryFolder folder;
  std::string text = test::ply(test::plain_gaussian(), {.format = "ascii", .repeat = 5});
  for (std::size_t i = 0, at = 0; i < 5; ++i)
    text.replace(at = text.find("\n1 2", at), 2, i == 3 ? "\nnan" : "\n" + std::to_string(i));
  text.replace(text.rfind(" 2 0 0 0"), 8, " 0 0 0 0");
  const auto path = folder.write("text.ply", text);
  const SceneFile whole = read_scene(path), last = read_scene(path, {.part = {1, 2}});
  CHECK(whole.scene.size() == 3);
  CHECK(last.stored == 3);
  CHECK(last.left_out.not_finite == 1);
  CHECK(last.left_out.no_rotation == 1);
  CHECK(same_bits(joined(2, [&](ScenePart part) { return read_scene(path, {.part = part}).scene; }),
                  whole.scene));
}

TEST_CASE("scene parts: all have the origin of the whole") {
  const test::TemporaryFolder folder;
  const dvec3 far(10'000'000, 0, -10'000'000);
  const auto path = folder.write("far.ply", test::far_scene(far, "double"));
  const Scene whole = load_scene(path);
  CHECK(whole.origin == far);
  CHECK(same_bits(joined(3, [&](ScenePart part) { return load_scene(path, {.part = part}); }), whole));
}

TEST_CASE("scene parts: a format that is read as a whole is refused") {
  const test::TemporaryFolder folder;
  const auto path = folder / "a.sog";
  write_scene(path, make_builtin_scene(500));
  const std::string expected =
      path.string() + ": a part of it was asked for, expected a PLY, SPZ or .splat file";
  CHECK_THROWS_WITH_AS(read_scene(path, {.part = {0, 2}}), doctest::Contains(expected.c_str()),
                       std::invalid_argument);
  CHECK_THROWS_AS(read_scene(path, {.part = {2, 2}}), std::invalid_argument);
  CHECK(read_scene(path, {.part = {0, 1}}).scene.size() == 500);
}

}  // namespace swiftgs::test::scene_parts_test
