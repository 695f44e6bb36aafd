// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include <swiftgs/error.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

/// One of several parts of a scene, each of consecutive Gaussians and as many as any other, give or take one.
/// The whole is its only part.
struct ScenePart {
  std::size_t index = 0, of = 1;

  struct Range {
    std::size_t begin, end;
    std::size_t size() const { return end - begin; }
  };
  /// Gaussians of this part, of a scene that has `count`.
  Range range(std::size_t count) const {
    const auto before = [&](std::size_t part) { return count / of * part + count % of * part / of; };
    return {before(index), before(index + 1)};
  }

  bool is_whole() const { return of == 1; }
};

/// Throws `InvalidArgument` unless `index` is below `of`, which is 1 to 65535.
inline void validate(const ScenePart& part) {
  if (part.of < 1 || part.of > 65535 || part.index >= part.of)
    detail::refuse("scene: the part is number ", part.index, " of ", part.of,
                   ", expected 0 and up of 1 to 65535");
}

/// A copy of a part of `scene`. Readers and `make_builtin_scene` make a part without the rest.
inline Scene part_of(const Scene& scene, const ScenePart& part) {
  validate(part);
  const ScenePart::Range range = part.range(scene.size());
  Scene out = empty_like(scene);
  for_each_array(
      [&](const char*, std::size_t each, const auto& from, auto& to) {
        to.assign(from.begin() + std::ptrdiff_t(range.begin * each),
                  from.begin() + std::ptrdiff_t(range.end * each));
      },
      scene, out);
  return out;
}

}  // namespace swiftgs
