// SPDX-License-Identifier: Apache-2.0
#include "read/scene_edits.hpp"

#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string_view>

#include <swiftgs/edit/rotation.hpp>

#include "words.hpp"

namespace swiftgs::cli {
namespace {

/// A word and the numbers behind its colon.
struct Worded {
  std::string_view word;
  std::vector<double> numbers;  ///< empty where one of them is none

  bool is(std::string_view name, std::size_t count) const { return word == name && numbers.size() == count; }
  dvec3 three(std::size_t first) const { return {numbers[first], numbers[first + 1], numbers[first + 2]}; }
};

Worded worded(const std::string& text) {
  const std::size_t colon = text.find(':');
  Worded result{std::string_view(text).substr(0, colon), {}};
  if (colon == std::string::npos) return result;
  for (const std::string_view part : split(std::string_view(text).substr(colon + 1), ',')) {
    const std::optional<double> number = parse<double>(part);
    if (!number) return {result.word, {}};
    result.numbers.push_back(*number);
  }
  return result;
}

/// Runs `check`, and puts the option before what it complains of.
template <class Check>
void checked(const std::string& option, const Check& check) {
  try {
    check();
  } catch (const std::invalid_argument& error) {
    const std::string_view what = error.what();
    throw std::invalid_argument(option + ": " + std::string(what.substr(what.find("expected"))));
  }
}

dmat3 rotation_about(const dvec3& axis, double degrees) {
  const double half = degrees * std::numbers::pi / 360, s = std::sin(half) / glm::length(axis);
  return matrix_of(unit({std::cos(half), s * axis.x, s * axis.y, s * axis.z}));
}

Affine affine_of_rows(const std::vector<double>& rows) {
  Affine by;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) by.linear[column][row] = rows[std::size_t(4 * row + column)];
    by.translation[row] = rows[std::size_t(4 * row + 3)];
  }
  return by;
}

}  // namespace

Affine movement_named(const std::string& text) {
  const Worded w = worded(text);
  const std::string option = "--transform '" + text + "'";
  Affine by;
  if (w.is("scale", 1) || w.is("scale", 3)) {
    for (const double scale : w.numbers)
      if (!(std::isfinite(scale) && scale > 0))
        throw std::invalid_argument(option + ": expected a finite scale above 0");
    for (int axis = 0; axis < 3; ++axis) by.linear[axis][axis] = w.numbers[w.numbers.size() == 3 ? axis : 0];
  } else if (w.is("move", 3)) {
    by.translation = w.three(0);
  } else if (w.is("rotate", 4)) {
    if (w.three(0) == dvec3(0.0)) throw std::invalid_argument(option + ": expected an axis other than 0,0,0");
    by.linear = rotation_about(w.three(0), w.numbers[3]);
  } else if (w.is("matrix", 12)) {
    by = affine_of_rows(w.numbers);
  } else {
    throw std::invalid_argument(option +
                                ": expected scale:S, scale:X,Y,Z, move:X,Y,Z, rotate:X,Y,Z,DEGREES or "
                                "matrix: and three rows of four numbers");
  }
  checked(option, [&] { validate(by); });
  return by;
}

Region region_named(const std::string& text) {
  const Worded w = worded(text);
  const std::string option = "--crop '" + text + "'";
  Region region;
  if (w.is("box", 6))
    region = Box{w.three(0), w.three(3)};
  else if (w.is("sphere", 4))
    region = Sphere{w.three(0), w.numbers[3]};
  else if (w.is("half-space", 4))
    region = HalfSpace{w.three(0), w.numbers[3]};
  else
    throw std::invalid_argument(option +
                                ": expected box:X,Y,Z,X,Y,Z, sphere:X,Y,Z,RADIUS or half-space:X,Y,Z,OFFSET");
  checked(option, [&] { std::visit([](const auto& r) { validate(r); }, region); });
  return region;
}

}  // namespace swiftgs::cli
