// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace swiftgs::cli {

/// Says how large frames are drawn: at half the size while the camera moves, unless whole frames are quick,
/// and at the whole size when it stands. Times are in seconds, and only differences of them count.
class Resolution {
 public:
  static constexpr double settles_after = 0.2;     ///< standing still for less is a pause in moving
  static constexpr double quick_frame = 1 / 45.0;  ///< a display shows more than the half of these

  /// The camera moved, or anything else that shows changed, at `now`.
  void changed(double now) { changed_at_ = now, drawn_ = 0; }
  /// A frame at `scale` was drawn and took `seconds`.
  void drew(double scale, double seconds) {
    drawn_ = scale;
    if (scale == 1) whole_frame_ = seconds;
  }

  /// The scale at which a frame is due at `now`, or nothing where the last one is as good.
  std::optional<double> due(double now) const {
    const bool whole = now - changed_at_ >= settles_after || whole_frame_ <= quick_frame;
    const double scale = whole ? 1 : 0.5;
    if (drawn_ >= scale) return std::nullopt;
    return scale;
  }

 private:
  double changed_at_ = -settles_after;  ///< the first frame is a whole one
  double whole_frame_ = 1;              ///< how long the last took
  double drawn_ = 0;                    ///< scale of what is shown since the last change
};

}  // namespace swiftgs::cli
