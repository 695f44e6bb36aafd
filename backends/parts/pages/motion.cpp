// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <iterator>

#include <glm/matrix.hpp>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/pages/motion.hpp>

namespace swiftgs::detail {
namespace {

dmat3 rotation_of(const ViewConstants& v) {
  dmat3 all;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) all[column][row] = v.rotation[row][column];
  return all;
}

/// `now` in some frames if the camera moves and turns by as much in each as from `before`.
ViewConstants gone_on(const ViewConstants& before, const ViewConstants& now, int frames) {
  const dmat3 turn = rotation_of(now) * glm::transpose(rotation_of(before));
  dmat3 turned = rotation_of(now);
  for (int k = 0; k < frames; ++k) turned = turn * turned;
  ViewConstants later = now;
  for (int row = 0; row < 3; ++row) {
    later.centre[row] += frames * (now.centre[row] - before.centre[row]);
    for (int column = 0; column < 3; ++column) {
      later.rotation[row][column] = turned[column][row];
      later.axes[row][column] = float(turned[column][row]);
    }
  }
  later.set_pairs();
  return later;
}

bool has_moved(const View& before, const View& now) {
  const ViewConstants &a = before.camera, &b = now.camera;
  return !std::equal(std::begin(a.centre), std::end(a.centre), b.centre) || rotation_of(a) != rotation_of(b);
}

}  // namespace

Motion::Motion(int frames) : frames_(frames) {
  if (frames < 0 || frames > 1000) refuse("page pool: ", frames, " frames ahead, expected 0 to 1000");
}

std::vector<View> Motion::ahead(Span<const View> views) {
  std::vector<View> all;
  bool moved = false;
  if (last_.size() == views.size)
    for (std::size_t i = 0; i < views.size; ++i) moved = moved || has_moved(last_[i], views[i]);
  const auto go_on = [&](int frames) {
    for (std::size_t i = 0; i < views.size; ++i) {
      all.push_back(views[i]);
      all.back().camera = gone_on(last_[i].camera, views[i].camera, frames);
    }
  };
  if (moved && frames_ > 2) go_on(2);  // cameras that turn pass what the last view does not show
  if (moved && frames_ > 0) go_on(frames_);
  last_.assign(views.begin(), views.end());
  return all;
}

}  // namespace swiftgs::detail
