// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/reference.hpp>

#include "bench/measure.hpp"

using namespace swiftgs;
using namespace swiftgs::cli;

namespace {

struct Fixture {
  std::shared_ptr<const Scene> scene = std::make_shared<const Scene>(make_builtin_scene(800));
  Camera camera = scaled(builtin_camera(), 0.1);
  RenderSettings settings;

  Judge judge(std::optional<Image> photo = std::nullopt) const {
    return {scene, camera, settings, std::move(photo)};
  }
};

}  // namespace

TEST_CASE("bench judge: a known error has its PSNR and its largest difference") {
  const Fixture f;
  Judge judge = f.judge();
  judge.render_reference();
  Frame frame;
  frame.width = f.camera.width, frame.height = f.camera.height;
  for (const double value : render_reference(*f.scene, f.camera, f.settings.conventions).colour)
    frame.colour.push_back(float(value + 1e-3));
  const Judge::Verdict verdict = judge.of(frame, false);
  REQUIRE(verdict.errors);
  CHECK(verdict.errors->psnr_db == doctest::Approx(60).epsilon(1e-3));
  CHECK(verdict.errors->max_abs == doctest::Approx(1e-3).epsilon(1e-3));
  CHECK_FALSE(verdict.errors->cut_psnr_db);
  CHECK_FALSE(verdict.photo);
}

TEST_CASE("bench judge: what is cut at three sigma is compared with such a reference too") {
  const Fixture f;
  Judge judge = f.judge();
  judge.render_reference();
  const auto renderer = make_renderer("serial/early/per-pixel/three-sigma-square");
  renderer->set_scene(f.scene);
  Frame frame;
  renderer->render(f.camera, f.settings, frame);
  const Judge::Verdict verdict = judge.of(frame, true);
  REQUIRE(verdict.errors->cut_psnr_db);
  CHECK(*verdict.errors->cut_psnr_db > verdict.errors->psnr_db + 10);
}

TEST_CASE("bench judge: without a reference there are no errors and a photograph still counts") {
  const Fixture f;
  Frame grey;
  grey.width = f.camera.width, grey.height = f.camera.height;
  grey.colour.assign(3 * grey.pixels(), 0.5f);
  Image photo{f.camera.width, f.camera.height, 3, grey.colour};
  for (float& value : photo.pixels) value = 0.6f;
  Judge judge = f.judge(photo);
  const Judge::Verdict verdict = judge.of(grey, false);
  CHECK_FALSE(verdict.errors);
  REQUIRE(verdict.photo);
  CHECK(verdict.photo->psnr_db == doctest::Approx(20).epsilon(1e-4));
  CHECK_FALSE(judge.reference_photo());
  judge.render_reference();
  CHECK(judge.reference_photo());
}
