// SPDX-License-Identifier: Apache-2.0

// Renderers of the device that are chosen at run time, against those of their types.
#include "policies/any_renderer.hpp"

#include <memory>
#include <string>

#include <swiftgs/any_renderer.hpp>

#include "cuda/graph.hpp"
#include "cuda/stream_pool.hpp"
#include "cuda/views.hpp"
#include "policies/rasterizers.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

template <class Sort = EarlySort, class Raster = AxisSharedThreshold<FloatCholesky>>
using With = Renderer<Cuda, Sort, Raster, Ellipse>;

}  // namespace

TEST_CASE("cuda any renderer: draws and records all that a view asks for as the renderer of its type") {
  if (without_device()) return;
  const auto scene = std::make_shared<const Scene>(random_scene(2000, 1, 7));
  for_each_raster([&]<class Raster>(Raster) {
    With<EarlySort, Raster> typed;
    const DeviceScene uploaded = typed.backend().upload(scene);
    for_each_type(AllSorts(), [&]<class Sort>(Sort) {
      const auto any = make_renderer(With<Sort, Raster>::name);
      CAPTURE(std::string(any->name()));
      any->set_scene(scene);
      check_drawn_frames<OnDevice>(*any, typed, uploaded.view());
      check_recorded_frames<OnDevice>(*any, typed, uploaded.view(),
                                      [&](FrameReport* report) { any->record(report); });
    });
  });
}

TEST_CASE("cuda any renderer: works on the stream and in the memory that its options name") {
  if (without_device()) return;
  const auto scene = std::make_shared<const Scene>(random_scene(2000, 1, 8));
  With<> typed;
  const DeviceScene uploaded = typed.backend().upload(scene);
  const Stream stream;
  StreamPool pool(stream.get());
  {
    const auto any = make_renderer(With<>::name, {.stream = stream.get(), .memory = pool.hook()});
    any->set_scene(scene);
    const std::size_t of_scene = pool.in_use();
    CHECK(of_scene >= 2000 * 14 * sizeof(float));
    check_drawn_frames<OnDevice>(*any, typed, uploaded.view());
    CHECK(any->memory().total() > 0);
    CHECK(pool.in_use() >= of_scene + any->memory().total());
    // A capture records work on this stream alone, so the graph draws only if the renderer uses it.
    check_recorded_frames<OnDevice>(*any, typed, uploaded.view(), [&](FrameReport* report) {
      const Graph graph(stream, [&] { any->record(report); });
      CHECK(graph.nodes() > 5);
      graph.run();
      stream.wait();
    });
    any->trim();
    CHECK(pool.in_use() == of_scene);
  }
  CHECK(pool.in_use() == 0);
}
