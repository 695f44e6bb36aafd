// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs::detail {

/// Tells from the views of frames where their cameras go.
class SWIFTGS_API Motion {
 public:
  /// Throws `InvalidArgument` unless `frames` is 0 to 1000.
  explicit Motion(int frames);

  /// The views in 2 frames, if `frames` are more, and in `frames`, if each camera moves and turns on as it
  /// did since the call before. None if all stand still, if their number changed, and of 0 frames.
  std::vector<View> ahead(Span<const View> views);

 private:
  int frames_;
  std::vector<View> last_;
};

}  // namespace swiftgs::detail
