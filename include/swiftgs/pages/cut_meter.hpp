// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/views.hpp>
#include <swiftgs/pages/cut.hpp>

namespace swiftgs::detail {

/// Measures in a thread how far cuts are from their scenes: draws some pixels of the views by `Serial`, of
/// the cut and of a cut of a sixteenth of its error, 1 pixel at most, by pages that it reads for itself into
/// the host's memory. Where these pages do not fit, it halves the part of a view that it draws at a time.
class SWIFTGS_API CutMeter {
 public:
  /// Pages take at most `bytes`, as in a pool without `ahead`. Throws as the pool.
  CutMeter(std::vector<PlacedPages> placed, std::size_t bytes);
  /// Waits for the page that is being read or the part that is being drawn.
  ~CutMeter();
  CutMeter(const CutMeter&) = delete;
  CutMeter& operator=(const CutMeter&) = delete;

  /// Places scenes anew for cuts that are requested from now on. Trusts them.
  void place(std::vector<PlacedPages> placed);
  /// Measures a complete cut of such views and goal next, in place of one that was requested before. Its
  /// pages err by at most `error` pixels; none: it draws leaves alone. One like the last changes nothing.
  /// Does not wait.
  void request(Span<const View> views, const CutGoal& goal, std::optional<double> error);
  /// PSNR of the last cut that was measured, of colours before conversion. NaN before the first, of
  /// panoramas, and where pages could not be read or did not fit. @units{dB}
  double decibels() const;
  /// The same of the last request, measured again if a page could not be read. @sync waits for it.
  double wait();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace swiftgs::detail
