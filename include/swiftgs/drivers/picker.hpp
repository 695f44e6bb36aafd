// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <utility>
#include <vector>

#include <swiftgs/drivers/pick.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/frame_renderer.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs {

/// Picks in the last frame of a renderer, whose stages still hold its splats, colours and tile lists.
template <class B>
class Picker {
 public:
  /// The pixels of `rectangle`, by rows; complete when it returns. Throws `OrderError` if there is no
  /// last frame, `InvalidArgument` for an unknown view and for a rectangle that does not lie in its
  /// frame, and `DeviceError` on a device.
  std::vector<PickedPixel> pick(FrameRenderer<B>& renderer, const PickRectangle& rectangle) {
    Stages<B>& stages = renderer.stages();
    check_ready(stages.backend());
    const LastFrame& last = renderer.last();
    const Views& views = last.views;
    if (last.kind == LastFrame::Kind::none || views.size() == 0)
      throw OrderError("pick: expected a frame before");
    check(last, rectangle);
    std::vector<PickedPixel> picked(std::size_t(rectangle.width) * std::size_t(rectangle.height));
    picked_.reset(picked.size());
    int left = 0;  // of the part in the whole frame
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (owner_of(last.owners, i) != rectangle.view) continue;
      const int begin = std::max(rectangle.x, left), width = views[i].frame.width;
      const int end = std::min(rectangle.x + rectangle.width, left + width);
      if (begin < end)
        pick_pixels(stages.backend(),
                    PickJob{stages.splats().view(), stages.colours(), stages.lists().view(), views[i],
                            begin - left, rectangle.y, end - begin, rectangle.height,
                            picked_.data() + (begin - rectangle.x), std::size_t(rectangle.width)});
      left += width;
    }
    stages.backend().download(std::as_const(picked_).span(), picked.data());
    return picked;
  }

  static auto buffers(auto& self) { return std::tie(self.picked_); }

 private:
  static void check(const LastFrame& last, const PickRectangle& rectangle) {
    const Views& views = last.views;
    int width = 0, height = 0;
    for (std::size_t i = 0; i < views.size(); ++i)
      if (owner_of(last.owners, i) == rectangle.view)
        width += views[i].frame.width, height = views[i].frame.height;
    if (width == 0)
      detail::refuse("pick: the view is number ", rectangle.view, ", expected less than ",
                     owner_of(last.owners, views.size() - 1) + 1);
    validate(rectangle, width, height);
  }

  typename B::template Buffer<PickedPixel> picked_;
};

}  // namespace swiftgs
