// SPDX-License-Identifier: Apache-2.0

// Times of frames of one scene over ranks: mpirun -n N frames_over_ranks SCENE [options]. Prints a line of
// JSON for each carrier: medians over frames, and a checksum of the image, the same for any
// number of ranks and any carrier. A rank alone also times `Renderer` on the same frame. With --views, each
// rank holds the whole scene instead, and draws its share of the views with a `Renderer`.
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/io/cameras.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/mpi.hpp>
#include <swiftgs/swiftgs.hpp>
#if defined(SWIFTGS_HAS_CUDA)
#include <swiftgs/mpi/cuda.hpp>
#endif

using namespace swiftgs;
using Json = nlohmann::ordered_json;

namespace {

struct Options {
  std::string scene, cameras, backend = "cpu";
  std::size_t view = 0;
  double scale = 1;
  int frames = 20, warm_ups = 8, threads = 0;
  std::size_t views = 0;              ///< 0: one frame over ranks
  std::vector<std::string> carriers;  ///< one after the other; none for the one that renderers choose
};

Scene part_named(const std::string& name, const ScenePart& part, const Ranks& ranks) {
  constexpr std::string_view builtin = "builtin:";
  if (!name.starts_with(builtin)) {
    ranks.require_same(name, file_identity(name));
    return load_scene(name, {.part = part});
  }
  std::size_t count = 0;
  const char* const end = name.data() + name.size();
  const auto parsed = std::from_chars(name.data() + builtin.size(), end, count);
  if (parsed.ec != std::errc() || parsed.ptr != end || count < 1)
    throw std::invalid_argument("scene '" + name + "': expected builtin:N or a file");
  return make_builtin_scene(count, part);
}

Camera camera_of(const Options& options) {
  if (options.cameras.empty()) return scaled(builtin_camera(), options.scale);
  const std::vector<Camera> cameras = load_cameras(options.cameras);
  return scaled(cameras.at(options.view), options.scale);
}

std::string checksum_of(const Frame& frame) {
  const std::string_view bytes(reinterpret_cast<const char*>(frame.colour.data()),
                               frame.colour.size() * sizeof(float));
  char text[17];
  std::snprintf(text, sizeof text, "%016zx", std::hash<std::string_view>()(bytes));
  return text;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
  return values[values.size() / 2];
}

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point begun) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begun).count();
}

/// Times of `draw`, which all ranks begin together and which waits for its own work, until the last is done.
template <class Draw>
std::vector<double> times_of(Ranks& ranks, const Options& options, const Draw& draw) {
  std::vector<double> times;
  for (int k = 0; k < options.warm_ups + options.frames; ++k) {
    ranks.all(true);
    const Clock::time_point begun = Clock::now();
    draw();
    std::vector<double> each = ranks.all_gather(ms_since(begun));
    if (k >= options.warm_ups) times.push_back(*std::max_element(each.begin(), each.end()));
  }
  return times;
}

/// Times frames of a part, and prints a line on rank 0. Returns the checksum of the image, empty elsewhere.
template <class Make>
std::string measure(Ranks& ranks, const Options& options, const Make& make, const SceneView& part,
                    const std::string& carrier) {
  using B = decltype(make());
  ranks.set_direct(carrier != "host");
  DistributedRenderer<B> renderer(ranks, make());
  if (!carrier.empty() && renderer.carrier() != carrier)
    throw std::invalid_argument("--carriers '" + carrier + "': expected '" + std::string(renderer.carrier()) +
                                "', by which splats go in this build on these ranks");
  const Camera camera = camera_of(options);
  std::vector<double> imbalance;
  const std::vector<double> with_strips = times_of(ranks, options, [&] {
    renderer.render_strips(part, {&camera, 1}, {});
    imbalance.push_back(renderer.counters().imbalance());
  });
  imbalance.erase(imbalance.begin(), imbalance.begin() + options.warm_ups);
  Frame frame;
  const std::vector<double> with_image =
      times_of(ranks, options, [&] { renderer.render(part, camera, {}, frame); });
  std::optional<double> without_ranks;
  if (ranks.size() == 1) {
    Renderer<B> one(make());
    without_ranks = median(times_of(ranks, options, [&] {
      one.render_resident(part, camera, {});
      one.backend().wait();
    }));
  }
  if (ranks.rank() != 0) return {};
  Json line{{"scene", options.scene},
            {"width", camera.width},
            {"height", camera.height},
            {"renderer", std::string(renderer.name)},
            {"ranks", ranks.size()},
            {"carrier", ranks.size() > 1 ? std::string(renderer.carrier()) : ""},
            {"frames", options.frames},
            {"ms", {{"wall", {{"median", median(with_strips)}}}}},
            {"ms_with_image", median(with_image)},
            {"imbalance", median(imbalance)},
            {"checksum", checksum_of(frame)}};
  if (without_ranks) line["ms_renderer"] = *without_ranks;
  std::printf("%s\n", line.dump().c_str());
  std::fflush(stdout);
  return line["checksum"];
}

/// Times all views of a scene that each rank holds, shared out among the ranks, and prints a line on rank 0.
template <class B>
void measure_views(Ranks& ranks, const Options& options, B backend, const SceneView& scene) {
  const std::vector<Camera> cameras =
      options.cameras.empty() ? builtin_cameras(int(options.views)) : load_cameras(options.cameras);
  Renderer<B> renderer(std::move(backend));
  const std::vector<double> all = times_of(ranks, options, [&] {
    for (std::size_t view = std::size_t(ranks.rank()); view < options.views;
         view += std::size_t(ranks.size()))
      renderer.render_resident(scene, scaled(cameras[view % cameras.size()], options.scale), {});
    renderer.backend().wait();
  });
  if (ranks.rank() != 0) return;
  const Json line{
      {"scene", options.scene}, {"scale", options.scale},
      {"batch", options.views}, {"renderer", std::string(renderer.name)},
      {"ranks", ranks.size()},  {"ms", {{"wall", {{"median", median(all) / double(options.views)}}}}}};
  std::printf("%s\n", line.dump().c_str());
  std::fflush(stdout);
}

/// All carriers in turn, of one scene that stays where it is. `make` makes a backend.
template <class Make>
void measure_each(Ranks& ranks, const Options& options, const Make& make) {
  const ScenePart own =
      options.views != 0 ? ScenePart{} : ScenePart{std::size_t(ranks.rank()), std::size_t(ranks.size())};
  auto home = make();
  std::optional<Scene> read = part_named(options.scene, own, ranks);
  const auto part = home.upload(std::move(*read));
  read.reset();
  if (options.views != 0) return measure_views(ranks, options, make(), part.view());
  std::string first;
  for (const std::string& carrier :
       options.carriers.empty() ? std::vector<std::string>{""} : options.carriers) {
    const std::string checksum = measure(ranks, options, make, part.view(), carrier);
    if (first.empty()) first = checksum;
    if (checksum != first)
      throw std::runtime_error("the image of carrier '" + carrier + "' has checksum " + checksum +
                               ", expected " + first + " as of the first");
  }
}

int run(Ranks& ranks, int argc, char** argv) {
  Options options;
  CLI::App app("Times of frames of one scene over ranks of MPI", "frames_over_ranks");
  app.add_option("SCENE", options.scene, "builtin:N, or a file that can be read in parts")->required();
  app.add_option("--cameras", options.cameras, "File or folder of cameras [the built-in view]");
  app.add_option("--view", options.view, "Number of the camera");
  app.add_option("--scale", options.scale, "Factor of the image's sides");
  app.add_option("--views", options.views, "Share out so many views of the whole scene, not one frame");
  app.add_option("--backend", options.backend, "cpu or cuda");
  app.add_option("--threads", options.threads, "Of each rank on the cpu; 0 for all");
  app.add_option("--carriers", options.carriers,
                 "host or nccl, or several in turn [what renderers choose]; their images must be the same")
      ->delimiter(',');
  app.add_option("--frames", options.frames, "Frames to time")->check(CLI::PositiveNumber);
  app.add_option("--warm-ups", options.warm_ups, "Frames before them, in which strips find their places");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return ranks.rank() == 0 ? app.exit(error) : error.get_exit_code();
  }
  if (options.views != 0 && (!options.carriers.empty() || options.view != 0))
    throw std::invalid_argument("--views: expected neither --carriers nor --view, which are of one frame");
  if (options.backend == "cpu") {
    measure_each(ranks, options, [&] { return Cpu(options.threads); });
    return 0;
  }
#if defined(SWIFTGS_HAS_CUDA)
  if (options.backend == "cuda") {
    take_device(ranks);
    measure_each(ranks, options, [] { return Cuda(); });
    return 0;
  }
#endif
  throw std::invalid_argument("--backend '" + options.backend +
                              "': expected cpu, or cuda in a build with it");
}

}  // namespace

int main(int argc, char** argv) {
  return run_on_ranks("frames_over_ranks", [&](Ranks& ranks) { return run(ranks, argc, argv); });
}
