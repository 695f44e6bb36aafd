// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <future>
#include <optional>
#include <string>
#include <vector>

#include <swiftgs/camera.hpp>

#include "view/drawing.hpp"

namespace swiftgs::cli {

/// The part of `camera`'s image, at most `side` pixels wide and high, around a pixel, as a camera of its own.
Camera crop_around(const Camera& camera, int x, int y, int side);

/// How far a small part of the image is from the float64 reference, which is drawn beside the viewer.
class CropError {
 public:
  static constexpr int side = 64;

  struct Error {
    double psnr_db, max_abs;
  };

  /// The error of `drawing` through `crop`; nothing while the reference is under way. Starts it where there
  /// is none of this picture.
  std::optional<Error> of(Drawing& drawing, const Camera& crop);
  bool is_under_way() const { return running_.valid(); }

 private:
  /// What a reference is of.
  struct Subject {
    Camera crop{};
    std::size_t version = 0;  ///< of the drawing

    bool operator==(const Subject& other) const;
  };

  std::future<std::vector<double>> running_;
  Subject running_subject_, subject_;
  std::vector<double> reference_;  ///< of `subject_`; empty before the first
  std::string renderer_;           ///< that `error_` is of, or empty
  Error error_{};
};

}  // namespace swiftgs::cli
