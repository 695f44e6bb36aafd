// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/serial.hpp>

namespace swiftgs::test {

/// A renderer that draws nothing and whose frames take what a script says. @units{milliseconds}
class ScriptedRenderer final : public AnyRenderer {
 public:
  ScriptedRenderer(std::string name, std::function<double(int frame)> total, std::vector<std::string>* calls)
      : name_(std::move(name)), total_(std::move(total)), calls_(calls) {}

  std::string_view name() const override { return name_; }
  void set_scene(std::shared_ptr<const Scene>, HarmonicsKept) override {}
  void set_scene(const SceneArrays&) override {}
  void borrow_scene(const SceneArrays&) override {}
  std::size_t add_scene(std::shared_ptr<const Scene>, HarmonicsKept) override { return 0; }
  const char* harmonics(std::size_t) const override { return ""; }
  void place(Span<const Placement>) override {}
  UploadedScene upload(Scene scene, HarmonicsKept) override {
    return UploadedScene(Serial().upload(std::move(scene)));
  }
  void show(Span<const PlacedScene>) override {}
  bool share_scene(const AnyRenderer&) override { return true; }
  void update_scene(std::size_t, std::size_t, const SceneArrays&) override {}
  void render(Span<const Camera>, const RenderSettings&, Span<Frame>) override {}
  Span<const FrameView> render_resident(Span<const Camera>, const RenderSettings&) override {
    ++frames;
    if (calls_) calls_->push_back(name_);
    return {};
  }
  void render_into(Span<const View>, Measures) override {}
  void reserve(Span<const View>, Capacity) override {}
  void set_views(Span<const View>) override {}
  void record(FrameReport*) override {}
  void set_recorded_scenes() override {}
  Span<StoredScene> recorded_scenes() override { return {}; }
  std::vector<std::size_t> refused_scenes() const override { return {}; }
  void wait() override {}
  std::vector<PickedPixel> pick(const PickRectangle&) override { return {}; }
  StageTimes times() override {
    const double ms = total_(frames);
    return {0.1 * ms, 0.2 * ms, 0.7 * ms, ms};
  }
  Statistics statistics() const override { return {}; }
  std::vector<std::size_t> visible_by_scene() const override { return {}; }
  StageMemory memory() const override { return {}; }
  void trim() override {}
  std::string device_name() const override { return "a script"; }
  bool sort_decided() override { return name_.find("/adaptive/") == std::string::npos; }
  std::optional<MemoryUse> device_memory() const override { return std::nullopt; }

  int frames = 0;

 private:
  std::string name_;
  std::function<double(int)> total_;
  std::vector<std::string>* calls_;
};

}  // namespace swiftgs::test
