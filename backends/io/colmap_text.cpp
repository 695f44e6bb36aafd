// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string>

#include "camera_parsing.hpp"
#include "colmap_models.hpp"
#include "tokens.hpp"

namespace swiftgs::io {
namespace {

/// Lines of a file, each of which must end in a line break if `next` is to return it.
class Lines {
 public:
  explicit Lines(const Source& source) : source_(source) {}

  /// The next line that is neither empty nor a comment. False at the end.
  bool next(std::string_view& line) {
    while (next_any(line)) {
      if (Tokens(line).at_end() || line.front() == '#') continue;
      // Without its line break a last line may be half of what was written.
      if (!ended_) fail("a line that ends in a line break");
      return true;
    }
    return false;
  }

  /// The next line, whatever it holds. False at the end.
  bool next_any(std::string_view& line) {
    const std::string_view text = source_.text();
    start_ = position_;
    if (position_ == text.size()) return false;
    const std::size_t end = text.find('\n', position_);
    ended_ = end != std::string_view::npos;
    line = text.substr(start_, ended_ ? end - start_ : end);
    position_ = ended_ ? end + 1 : text.size();
    return true;
  }

  std::uint64_t start() const { return start_; }
  [[noreturn]] void fail(const std::string& expected) const { source_.fail(start_, expected); }

 private:
  const Source& source_;
  std::size_t position_ = 0, start_ = 0;
  bool ended_ = true;
};

template <class T>
T number(const Lines& lines, Tokens& tokens, const char* what) {
  T value{};
  if (!to_number(tokens.next(), value)) lines.fail(std::string("a number for ") + what);
  return value;
}

ColmapIntrinsics parse_cameras(const Source& source) {
  ColmapIntrinsics intrinsics;
  Lines lines(source);
  for (std::string_view line; lines.next(line);) {
    Tokens tokens(line);
    const auto id = number<std::uint32_t>(lines, tokens, "a camera id");
    const ColmapModel model = colmap_model(source, lines.start(), tokens.next());
    Camera camera;
    camera.width = to_side(source, lines.start(), number<double>(lines, tokens, "a width"));
    camera.height = to_side(source, lines.start(), number<double>(lines, tokens, "a height"));
    std::array<double, 4> parameters{};
    for (int p = 0; p < model.parameters; ++p)
      parameters[p] = number<double>(lines, tokens, "a camera parameter");
    if (!tokens.at_end()) lines.fail(std::to_string(model.parameters) + " camera parameters, found more");
    set_intrinsics(camera, parameters.data(), model.parameters);
    if (!intrinsics.emplace(id, camera).second)
      lines.fail("each camera id once, found " + std::to_string(id) + " again");
  }
  return intrinsics;
}

}  // namespace

std::vector<Camera> parse_colmap_text(const Source& cameras, const Source& images) {
  const ColmapIntrinsics intrinsics = parse_cameras(cameras);
  std::vector<Camera> result;
  Lines lines(images);
  for (std::string_view line; lines.next(line);) {
    Tokens tokens(line);
    number<std::uint32_t>(lines, tokens, "an image id");
    std::array<double, 7> numbers;
    for (double& value : numbers) value = number<double>(lines, tokens, "a pose");
    const auto [w, x, y, z, tx, ty, tz] = numbers;
    const auto camera_id = number<std::uint32_t>(lines, tokens, "a camera id");
    const std::string_view name = tokens.rest();  // may hold blanks
    if (name.empty()) lines.fail("an image name");
    result.push_back(
        place(images, lines.start(), intrinsics, {w, x, y, z, dvec3(tx, ty, tz), camera_id}, name));

    // The line of 2D points, which is empty for an image without any.
    lines.next_any(line);
  }
  return result;
}

}  // namespace swiftgs::io
