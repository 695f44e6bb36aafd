// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Renderers that are chosen at run time against those of their types.

#include <cstddef>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/swiftgs.hpp>

#include "policies/views.hpp"

namespace swiftgs::test {

/// Checks that `any`, whose scenes are set, draws views of every kind and frames that stay with it as `typed`
/// does.
template <class B>
void check_drawn_frames(AnyRenderer& any, BoundRenderer<B>& typed, const PlacedScenes& scenes) {
  const B& backend = typed.backend();
  PlacedViews expected(backend, views_of_every_kind()), drawn(backend, views_of_every_kind());
  typed.render_into(scenes, expected.span(), {.count = true});
  any.render_into(drawn.span(), {.count = true});
  any.wait();
  CHECK(differing(drawn.finish(backend), expected.finish(backend)) == 0);
  const Statistics found = any.statistics(), taken = typed.statistics();
  CHECK(taken.raster.contributing_pairs > 1000);
  CHECK(found.visible == taken.visible);
  CHECK(found.intersections == taken.intersections);
  CHECK(same_counts(found.raster, taken.raster));

  const Camera cameras[] = {forward_camera(50, 40), turned_camera(33, 17, 0.2, 0.3)};
  const RenderSettings settings = settings_of({true, true}, vec3(0.1f, 0.2f, 0.3f));
  std::vector<Frame> frames(2), by_type(2);
  typed.render(scenes, {cameras, 2}, settings, span_of(by_type));
  any.render({cameras, 2}, settings, span_of(frames));
  const Span<const FrameView> resident = any.render_resident({cameras, 2}, settings);
  REQUIRE(resident.size == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(same_planes(frames[i], by_type[i]));
    CHECK(resident[i].width == cameras[i].width);
    CHECK(resident[i].height == cameras[i].height);
    const auto same = [&](const auto& plane, const std::vector<float>& values, int channels) {
      const Span all{static_cast<const float*>(plane.data), values.size()};  // rows lie close together
      return plane.pitch == std::ptrdiff_t(sizeof(float)) * channels * cameras[i].width &&
             to_host(backend, all) == values;
    };
    CHECK(same(resident[i].colour, by_type[i].colour, 3));
    CHECK(same(resident[i].alpha, by_type[i].alpha, 1));
    CHECK(same(resident[i].depth, by_type[i].depth, 1));
  }
}

/// Checks that `any`, whose scenes are set, records views of every kind as `typed` renders them.
template <class B>
void check_recorded_frames(AnyRenderer& any, BoundRenderer<B>& typed, const PlacedScenes& scenes) {
  const B& backend = typed.backend();
  const std::vector<AskedView> asked = views_of_every_kind();
  std::vector<AskedView> moved = asked;
  for (AskedView& view : moved) view.camera.translation.x += 0.1;
  PlacedViews reserved(backend, asked), set(backend, moved), expected(backend, moved);
  typed.render_into(scenes, expected.span());
  Report<B> report;
  const Statistics taken = typed.statistics();
  any.reserve(reserved.span(), {2 * taken.visible, 2 * taken.intersections});
  any.set_views(set.span());
  any.record(report.data());
  any.wait();
  const FrameReport found = report.get(backend);
  CHECK(found.overflowed == 0);
  CHECK(found.visible == taken.visible);
  CHECK(found.intersections == taken.intersections);
  CHECK(differing(set.finish(backend), expected.finish(backend)) == 0);
  PlacedViews untouched(backend, asked);
  CHECK(differing(reserved.finish(backend), untouched.finish(backend)) == 0);
}

}  // namespace swiftgs::test
