// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <stdexcept>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/lens/view.hpp>
#include <swiftgs/pages/page_pool.hpp>
#include <swiftgs/serial.hpp>

using namespace swiftgs;

namespace {

/// A backend whose memory ends after some pages.
struct Bounded : Serial {
  std::size_t uploads_left;

  SceneOn upload(Scene scene) {
    if (uploads_left == 0) throw std::runtime_error("no memory");
    --uploads_left;
    return Serial::upload(std::move(scene));
  }
};

}  // namespace

TEST_CASE("pages: waiting for a cut again goes on where an upload failed") {
  Bounded backend{{}, 1};
  PagePool<Bounded> pool(backend, open_pages(SWIFTGS_TEST_PAGES));
  const std::vector<View> views{
      make_view(builtin_camera(64, 48), Conventions::gsplat(), {.width = 64, .height = 48})};
  Cut cut = pool.cut({views.data(), views.size()}, {.pixels = 0});
  CHECK_THROWS_WITH(pool.wait(cut), "no memory");
  CHECK(cut.scenes().empty());
  backend.uploads_left = 100;
  pool.wait(cut);
  CHECK(cut.is_settled());
  CHECK(cut.splats() == 130);
}
