// SPDX-License-Identifier: Apache-2.0

/// @file
/// A walk through many copies of a page file at the pace of a display: how long frames take, how often one
/// has all of its pages, and how far it is from the scene. docs/pages.md has the numbers.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <limits>
#include <memory>
#include <numeric>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fcntl.h>
#include <unistd.h>

#include <swiftgs/default_view.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/pages/page_pool.hpp>
#include <swiftgs/swiftgs.hpp>
#if defined(SWIFTGS_TEST_CUDA)
#include <cuda_runtime_api.h>
#endif

namespace {

using namespace swiftgs;
using Clock = std::chrono::steady_clock;

struct Options {
  std::string file, renderer, disk, images;
  std::vector<double> pools{2000, 512};
  int side = 10, views = 3000, width = 1920, height = 1080, compared = 10, threads = 8, ahead = 10;
  double spacing = 0, speed = 14, hertz = 60, pixels = 4, millions = 4, upload = 16, estimate = 0;
  bool wait = false, aliased = false;
};

/// The walk: a curve that crosses the copies in many directions, at eye height, looking ahead and about.
class Walk {
 public:
  Walk(const Options& options, const Scene& coarse, double spacing) : options_(options) {
    const OrbitView view = default_view(coarse, options.width, options.height);
    up_ = view.up / length(view.up);
    const dvec3 back = view.camera.centre() - view.target;
    height_ = 0.9 * dot(back, up_);
    target_ = view.target;
    const dvec3 level = back - dot(back, up_) * up_;
    x_ = level / length(level);
    y_ = detail::cross(up_, x_);
    reach_ = std::max(0.45 * spacing * options.side, 1e-6);
    for (double t = 0; int(times_.size()) < options.views; t += step(t)) times_.push_back(t);
  }

  /// Where copy (i, j) of the grid stands.
  dvec3 place(int i, int j, double spacing) const {
    const double middle = 0.5 * (options_.side - 1);
    return spacing * (i - middle) * x_ + spacing * (j - middle) * y_;
  }

  Camera camera(std::size_t view) const {
    const double t = times_[view];
    const dvec3 eye = target_ + height_ * up_ + at(t);
    const dvec3 ahead = at(t + 1e-3) - at(t);
    const double turn = 0.6 * std::sin(9 * t);
    const dvec3 side = detail::cross(up_, ahead);
    const dvec3 look = std::cos(turn) * ahead + std::sin(turn) * side - 0.2 * length(ahead) * up_;
    return look_at(eye, eye + look / length(look), up_, 1.0, options_.width, options_.height);
  }

 private:
  static double dot(const dvec3& a, const dvec3& b) { return detail::dot(a, b); }
  static double length(const dvec3& v) { return std::sqrt(dot(v, v)); }

  dvec3 at(double t) const { return reach_ * (std::sin(t) * x_ + std::sin(1.618 * t + 1) * y_); }
  /// How far the curve's parameter goes in a frame.
  double step(double t) const {
    return options_.speed / options_.hertz * 1e-4 / std::max(length(at(t + 1e-4) - at(t)), 1e-9);
  }

  const Options& options_;
  dvec3 up_, x_, y_, target_;
  double height_ = 0, reach_ = 1;
  std::vector<double> times_;
};

/// The pages of every copy: of one file that is opened often, or of copies of it in a folder.
class Copies {
 public:
  explicit Copies(const Options& options) {
    for (int k = 0; k < options.side * options.side; ++k) {
      files_.push_back(options.file);
      if (options.disk.empty()) continue;
      files_[k] = (std::filesystem::path(options.disk) / (std::to_string(k) + ".sgp")).string();
      std::filesystem::create_directories(options.disk);
      std::filesystem::copy_file(options.file, files_[k], std::filesystem::copy_options::skip_existing);
    }
  }

  std::vector<PagedScene> open() const {
    std::vector<PagedScene> all;
    for (const std::string& file : files_) all.push_back(open_pages(file));
    return all;
  }
  /// Has the system forget the content of the files, which nobody has open.
  void make_cold() const {
    for (const std::string& file : files_) {
      const int opened = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
      if (opened < 0) continue;
      ::fdatasync(opened);
      ::posix_fadvise(opened, 0, 0, POSIX_FADV_DONTNEED);
      ::close(opened);
    }
  }

 private:
  std::vector<std::string> files_;
};

/// What a walk measured.
struct Measured {
  std::vector<double> cut;    ///< of each frame @units{milliseconds}
  std::vector<double> frame;  ///< with its cut @units{milliseconds}
  std::size_t complete = 0;   ///< frames that lack nothing
  std::size_t late = 0;       ///< frames that lack what the one before did
  double seconds = 0;
  double worst_pixels = 0;
  double mean_splats = 0;
  double decibels = 0;
  double saved = 0;  ///< visible splats of the whole scene over those of the cut
  double least_decibels = std::numeric_limits<double>::infinity();
  double off = 0;  ///< estimates, root mean square @units{dB}
  std::uint64_t uploads = 0;
  std::uint64_t bytes = 0;  ///< that were uploaded
  std::size_t most_bytes = 0;
};

double part_of(std::vector<double> values, double part) {
  const auto at = values.begin() + std::ptrdiff_t(part * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}
double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

#if defined(SWIFTGS_TEST_CUDA)
/// Memory of a device in the order of a stream. What pages give back stays for the next ones, so that neither
/// waits for the device.
MemoryHook device_memory(cudaStream_t stream) {
  cudaMemPool_t pool = nullptr;
  std::uint64_t all = UINT64_MAX;
  if (cudaDeviceGetDefaultMemPool(&pool, 0) == cudaSuccess)
    cudaMemPoolSetAttribute(pool, cudaMemPoolAttrReleaseThreshold, &all);
  return {
      [](void* order, std::size_t bytes) {
        void* memory = nullptr;
        cudaMallocAsync(&memory, bytes, static_cast<cudaStream_t>(order));
        return memory;
      },
      [](void* order, void* memory, std::size_t) { cudaFreeAsync(memory, static_cast<cudaStream_t>(order)); },
      stream};
}
#endif

/// A renderer. `apart` has a stream of its own on a device.
std::unique_ptr<AnyRenderer> renderer_of(const std::string& name, [[maybe_unused]] bool apart = false) {
  const RendererEntry& entry = find_renderer(name);
  BackendOptions options;
#if defined(SWIFTGS_TEST_CUDA)
  if (entry.name.starts_with("cuda")) {
    if (apart) cudaStreamCreateWithFlags(&options.stream, cudaStreamNonBlocking);
    options.memory = device_memory(options.stream);
  }
#endif
  return make_renderer(entry.name, options);
}

/// A frame that is compared with another.
struct Compared {
  Frame frame;
  double visible = 0;    ///< splats
  double estimated = 0;  ///< of a cut @units{dB}
};
Compared drawn(AnyRenderer& renderer, const Camera& camera, const RenderSettings& settings) {
  Compared compared;
  renderer.render(camera, settings, compared.frame);
  compared.visible = double(renderer.statistics().visible);
  return compared;
}

/// Images of the whole scene.
class WholeScene {
 public:
  WholeScene(const Options& options, const std::vector<PlacedPages>& placed)
      : renderer_(renderer_of(options.renderer)), scene_(renderer_->upload(read_leaves(placed[0].pages))) {
    std::vector<PlacedScene> all;
    for (const PlacedPages& each : placed) all.push_back({scene_.view(), each.world_from_scene});
    renderer_->show({all.data(), all.size()});
  }
  Compared draw(const Camera& camera, const RenderSettings& settings) {
    return drawn(*renderer_, camera, settings);
  }

 private:
  std::unique_ptr<AnyRenderer> renderer_;
  UploadedScene scene_;
};

Measured walk(const Options& options, const Walk& path, const std::vector<PlacedPages>& placed,
              double megabytes) {
  const std::unique_ptr<AnyRenderer> renderer = renderer_of(options.renderer),
                                     uploader = renderer_of(options.renderer, true);
  PagePool<AnyRenderer> pool(*renderer, placed,
                             {.bytes = std::size_t(1e6 * megabytes),
                              .upload_per_frame = std::size_t(1e6 * options.upload),
                              .waiting = std::size_t(1e6 * std::clamp(megabytes / 16, 16.0, 64.0)),
                              .ahead = options.ahead,
                              .estimate = std::size_t(1e6 * options.estimate),
                              .threads = options.threads},
                             uploader.get());
  RenderSettings settings;
  settings.conventions.antialiased = !options.aliased;
  const CutGoal goal{.pixels = options.pixels, .splats = std::uint64_t(1e6 * options.millions)};
  Measured measured;
  std::vector<View> views;
  std::vector<std::pair<std::size_t, Compared>> kept;
  const auto prepare_cut = [&](std::size_t i) {
    const Camera camera = path.camera(i);
    make_views({&camera, 1}, settings, views);
    return camera;
  };
  {  // begins where the first frame is complete, as a program would behind its first picture
    const Camera camera = prepare_cut(0);
    Cut cut = pool.cut({views.data(), views.size()}, goal);
    pool.wait(cut);
    renderer->show({cut.scenes().data(), cut.scenes().size()});
    for (int k = 0; k < 20; ++k) renderer->render_resident(camera, settings);
  }
  const std::uint64_t uploads = pool.uploads(), bytes = pool.uploaded_bytes();
  Clock::duration paused{};
  const auto begin = Clock::now();
  for (std::size_t i = 0; i < std::size_t(options.views); ++i) {
    const Camera camera = prepare_cut(i);
    std::this_thread::sleep_until(begin + paused +
                                  std::chrono::duration_cast<Clock::duration>(
                                      std::chrono::duration<double>(double(i) / options.hertz)));
    const auto start = Clock::now();
    Cut cut = pool.cut({views.data(), views.size()}, goal);
    if (options.wait) pool.wait(cut);
    const auto chosen = Clock::now();
    renderer->show({cut.scenes().data(), cut.scenes().size()});
    renderer->render_resident(camera, settings);
    const auto end = Clock::now();
    const auto ms = [](Clock::duration d) { return std::chrono::duration<double, std::milli>(d).count(); };
    measured.cut.push_back(ms(chosen - start)), measured.frame.push_back(ms(end - start));
    measured.complete += cut.missing() == 0, measured.late += cut.late() != 0;
    measured.worst_pixels = std::max(measured.worst_pixels, cut.pixels());
    measured.mean_splats += double(cut.splats()) / options.views;
    measured.most_bytes = std::max(measured.most_bytes, pool.bytes());
    if (options.compared > 0 && (i + 1) % std::size_t(std::max(options.views / options.compared, 1)) == 0) {
      kept.emplace_back(i, drawn(*renderer, camera, settings));
      kept.back().second.estimated = cut.estimated_db();
      paused += Clock::now() - end;
    }
  }
  measured.seconds = std::chrono::duration<double>(Clock::now() - begin - paused).count();
  measured.uploads = pool.uploads() - uploads, measured.bytes = pool.uploaded_bytes() - bytes;
  if (kept.empty()) return measured;
  WholeScene whole(options, placed);
  for (const auto& [i, cut] : kept) {
    if (!options.images.empty())
      write_png(std::filesystem::path(options.images) / (std::to_string(i) + ".png"), cut.frame);
    const Compared all = whole.draw(path.camera(i), settings);
    const double db = psnr(cut.frame.colour, all.frame.colour);
    measured.decibels += db / double(kept.size());
    measured.off += (cut.estimated - db) * (cut.estimated - db) / double(kept.size());
    measured.saved += all.visible / cut.visible / double(kept.size());
    measured.least_decibels = std::min(measured.least_decibels, db);
  }
  measured.off = std::sqrt(measured.off);
  return measured;
}

void print(double megabytes, const char* cache, const Options& options, const Measured& m) {
  const double all = double(options.views);
  const auto quick = std::count_if(m.frame.begin(), m.frame.end(), [](double ms) { return ms <= 2; });
  std::printf(
      "| %.0f | %s | %.2f | %.2f | %.2f | %.2f | %.2f | %.1f | %.1f | %.1f | %.1f | %zu | %.2f | %.2f | %.0f "
      "| %.2f | %.1f | %.1f | %.2f |\n",
      megabytes, cache, mean_of(m.frame), part_of(m.frame, 0.5), part_of(m.frame, 0.99), part_of(m.frame, 1),
      mean_of(m.cut), 100 * double(quick) / all, 100 * double(m.complete) / all,
      100 * (1 - double(m.late) / all), 1e-6 * double(m.bytes) / m.seconds, std::size_t(m.uploads),
      m.worst_pixels, 1e-6 * m.mean_splats, 1e-6 * double(m.most_bytes), m.saved, m.decibels,
      m.least_decibels, m.off);
  std::fflush(stdout);
}

void run(const Options& options) {
  const PagedScene first = open_pages(options.file);
  const Scene coarse = first.read(first.root()).scene;
  const double spacing = options.spacing > 0 ? options.spacing : 3 * robust_bounds(coarse).radius;
  const Walk path(options, coarse, spacing);
  const Copies copies(options);
  std::printf(
      "%s: %d copies of %.2f million Gaussians, %.3g units apart, %d views of %dx%d, %.3g units a second at "
      "%.3g frames a second, at most %.3g pixels, %.3g million splats, %.3g MB a frame, %d threads\n\n",
      find_renderer(options.renderer).name.c_str(), options.side * options.side,
      1e-6 * double(first.gaussians()), spacing, options.views, options.width, options.height, options.speed,
      options.hertz, options.pixels, options.millions, options.upload, options.threads);
  std::printf(
      "| pool, MB | cache | frame, ms | median | 99 %% | worst | of these cut | %% in 2 ms | %% complete | "
      "%% within one frame | MB/s | faults | pixels | M splats | most MB | saved | dB | least dB | estimates "
      "off |\n"
      "|---:|---:|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n");
  for (const double megabytes : options.pools)
    for (const char* cache : {"warm", "cold"}) {
      const bool cold = std::string(cache) == "cold";
      if (cold && options.disk.empty()) continue;
      if (cold) copies.make_cold();
      std::vector<PlacedPages> placed;
      for (const PagedScene& pages : copies.open()) {
        const int k = int(placed.size());
        placed.push_back({pages, {.translation = path.place(k / options.side, k % options.side, spacing)}});
      }
      print(megabytes, cache, options, walk(options, path, placed, megabytes));
    }
}

}  // namespace

int main(int argc, char** argv) try {
  Options options;
  CLI::App app("Walks through copies of a page file", "page_walk");
  app.add_option("FILE", options.file, "A page file")->required();
  app.add_option("--renderer", options.renderer, "A name from 'swiftgs list', or a backend");
  app.add_option("--disk", options.disk,
                 "Folder for a copy of the file for each copy: warm and cold caches differ");
  app.add_option("--pools", options.pools, "Memory of pages, in MB")->delimiter(',')->capture_default_str();
  app.add_option("--side", options.side, "Copies along each side of the grid")->capture_default_str();
  app.add_option("--spacing", options.spacing, "Between copies; 0: three times the scene's radius");
  app.add_option("--views", options.views, "Frames of the walk")->capture_default_str();
  app.add_option("--width", options.width)->capture_default_str();
  app.add_option("--height", options.height)->capture_default_str();
  app.add_option("--speed", options.speed, "Units a second")->capture_default_str();
  app.add_option("--hertz", options.hertz, "Frames a second")->capture_default_str();
  app.add_option("--pixels", options.pixels, "Goal of cuts")->capture_default_str();
  app.add_option("--splats", options.millions, "Most millions of splats")->capture_default_str();
  app.add_option("--upload", options.upload, "MB that a frame uploads")->capture_default_str();
  app.add_option("--threads", options.threads, "That read pages")->capture_default_str();
  app.add_option("--ahead", options.ahead, "Frames that the pool expects cameras to go on for")
      ->capture_default_str();
  app.add_option("--estimate", options.estimate, "Of the host, for estimates of dB, with --wait, in MB");
  app.add_flag("--wait", options.wait, "Wait for the pages of each frame: for images");
  app.add_flag("--aliased", options.aliased, "Without anti-aliasing");
  app.add_option("--compared", options.compared, "Frames to compare with the whole scene")
      ->capture_default_str();
  app.add_option("--images", options.images, "Folder for the images of these");
  CLI11_PARSE(app, argc, argv);
  run(options);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "page_walk: %s\n", error.what());
  return 1;
}
