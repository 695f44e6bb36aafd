// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/io/image.hpp>

#include "commands.hpp"
#include "draw/choice.hpp"
#include "draw/lenses.hpp"
#include "draw/page_frames.hpp"
#include "draw/reference_frame.hpp"
#include "draw/team.hpp"
#include "draw/video.hpp"
#include "json.hpp"
#include "notes.hpp"
#include "options.hpp"
#include "read/distinct_files.hpp"
#include "read/placed_input.hpp"
#include "read/scene_input.hpp"
#include "read/views.hpp"
#include "result_file.hpp"

namespace swiftgs::cli {
namespace {

struct RenderOptions {
  std::vector<std::string> scenes;
  bool place = false;
  SceneOptions scene;  ///< how to read them; of the first one
  ViewOptions view;
  LensOptions lens;
  std::string renderer;  ///< empty for `default_renderer()`
  std::string out = "renders";
  std::string format = "png";
  std::string video;  ///< file in place of images, or empty
  std::string harmonics = "smallest";
  std::string json;  ///< file for the results, or empty
  int batch = 1;
  bool stats = false;
  PageOptions pages;
};

using Writer = void (*)(const std::filesystem::path&, const Frame&);

Writer writer_of(const std::string& format) {
  if (format == "png") return write_png;
  if (format == "pfm") return write_pfm;
  if (format == "exr") return write_exr;
  throw std::invalid_argument("--format '" + format + "': expected png, pfm or exr" +
                              (format == "npy" ? ", or npy with --renderer reference" : ""));
}

/// Throws `InvalidArgument` that names the first option that the reference cannot follow.
void require_reference(const RenderOptions& options) {
  const RenderOptions usual;
  const auto refuse_if = [](bool given, const char* option, const char* why) {
    if (given)
      throw std::invalid_argument(std::string(option) + ": expected another renderer than reference, which " +
                                  why);
  };
  if (options.format != "npy") writer_of(options.format);
  const bool alpha_of_png = options.view.planes == "alpha" && options.format == "png";
  refuse_if(!options.view.planes.empty() && !alpha_of_png, "--planes", "has no planes but alpha in a PNG");
  refuse_if(options.lens.depth_at != usual.lens.depth_at, "--depth-at", "has no planes of depth");
  refuse_if(!options.video.empty(), "--video", "writes images");
  refuse_if(options.batch != usual.batch, "--batch", "draws one view at a time");
  refuse_if(options.harmonics != usual.harmonics, "--harmonics", "takes them as they are");
  refuse_if(!options.json.empty(), "--json", "has no times");
  refuse_if(options.stats, "--stats", "has no counts");
}

/// Draws all views by the float64 reference.
void render_by_reference(const RenderOptions& options, const DrawnScenes& drawn,
                         const std::vector<View>& views, const RenderSettings& settings) {
  ReferenceScenes scenes;
  for (const Placement& placement : drawn.placements)
    scenes.add(*drawn.gaussians[placement.scene], placement);
  std::filesystem::create_directories(options.out);
  const auto file_of = [&](const View& view) {
    return std::filesystem::path(options.out) / (view.name + "." + options.format);
  };
  const Team& team = Team::here();
  Progress progress(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!team.takes(i)) continue;
    progress.start(views[i].name);
    draw_reference(file_of(views[i]), scenes, views[i].camera, settings);
    progress.step();
  }
  progress.await_others();
  progress.clear();
  for (const View& view : views)
    std::printf("%s  %dx%d\n", file_of(view).c_str(), view.camera.width, view.camera.height);
}

/// What the scenes are called in results, and their files.
struct SceneNames {
  std::string all;
  std::vector<NamedFile> files;

  SceneNames(const std::vector<ListedScene>& scenes, SceneOptions reading) {
    for (const ListedScene& scene : scenes) {
      reading.scene = scene.file;
      const Capture capture = capture_of(reading);
      all += (all.empty() ? "" : "+") + capture.name;
      files.push_back({"SCENE", capture.scene.string()});
    }
  }
};

void render(RenderOptions options) {
  const bool by_reference = options.renderer == reference_name;
  if (by_reference) require_reference(options);
  const Writer write = by_reference ? nullptr : writer_of(options.format);
  const std::string& planes = options.view.planes;
  if (!planes.empty() && options.format != "exr" && !(planes == "alpha" && options.format == "png"))
    throw std::invalid_argument(
        "--planes: expected --format exr, whose channels hold them, or alpha in a PNG");
  require_batch(options.batch);
  const HarmonicsKept harmonics = harmonics_of(options.harmonics);
  validate(options.lens);
  const std::vector<ListedScene> listed = scenes_of(options.scenes, options.place);
  options.scene.scene = listed[0].file;
  SceneNames names(listed, options.scene);
  names.files.push_back({"--cameras", cameras_of(options.scene, options.view.cameras)});
  require_distinct({{"--video", options.video}, {"--json", options.json}}, names.files);
  std::unique_ptr<AnyRenderer> renderer;
  if (!by_reference)
    renderer = make_renderer(options.renderer.empty() ? default_renderer() : options.renderer);
  std::vector<std::string> notes;
  const Cameras known = read_cameras_of(options.scene, options.view.cameras, notes);
  std::vector<View> views = views_of(known, options.view, "all");
  RenderSettings settings = settings_of(options.view);
  settings.conventions.depth = depth_of(options.lens);
  settings.conventions.depth_at = depth_at_of(options.lens);
  const DrawnScenes drawn = load_to_place(listed, options.scene, notes);
  const auto scene = drawn.gaussians[0];
  place_views(views, drawn);
  use_lens(views, options.lens, *scene);
  if (options.format == "png" && settings.outputs.alpha && settings.background != vec3(0))
    throw std::invalid_argument("--background " + options.view.background +
                                ": expected 0,0,0 in a PNG with alpha, whose colours are straight");
  if (by_reference && drawn.has_pages())
    throw std::invalid_argument("--renderer reference: expected another renderer for pages");
  if (by_reference) return render_by_reference(options, drawn, views, settings);
  ResultFile json(options.json);
  ResultHead head = json.is_wanted() ? head_of("swiftgs-render") : ResultHead();
  head.notes = std::move(notes);
  Numbered<RenderResult> numbered;
  const std::unique_ptr<Video> video = video_of(options.video, views, known.frames_a_second);
  if (!video) std::filesystem::create_directories(options.out);
  std::optional<PageFrames> pages;
  if (drawn.has_pages()) {
    PagePoolOptions pool = options.pages.pool();
    pool.ahead = 0;  // every frame waits for its pages
    pages.emplace(*renderer, drawn, harmonics, pool);
  } else {
    for (const auto& each : drawn.gaussians) renderer->add_scene(each, harmonics);
    renderer->place({drawn.placements.data(), drawn.placements.size()});
  }
  if (options.stats && !pages) {
    std::size_t next = 0;  // each file once
    for (std::size_t i = 0; i < listed.size(); ++i)
      if (drawn.placements[i].scene == next)
        std::printf("%s: harmonics as %s\n", listed[i].file.c_str(), renderer->harmonics(next++));
  }

  const std::size_t batch = std::min(std::size_t(options.batch), views.size());
  std::vector<Camera> cameras;
  for (const View& view : views) cameras.push_back(view.camera);
  std::vector<Frame> frames;
  std::uint64_t most_splats = 0;
  double most_pixels = 0, least_db = std::numeric_limits<double>::infinity();
  const auto draw = [&](std::size_t first, const RenderSettings& with) {
    frames.resize(std::min(batch, views.size() - first));
    if (pages) {
      const Cut& cut =
          pages->show_complete({cameras.data() + first, frames.size()}, with, options.pages.goal());
      most_splats = std::max(most_splats, cut.splats()), most_pixels = std::max(most_pixels, cut.pixels());
      const double db = cut.estimated_db();
      least_db = std::isnan(least_db + db) ? std::nan("") : std::min(least_db, db);
    }
    renderer->render({cameras.data() + first, frames.size()}, with, {frames.data(), frames.size()});
  };
  // Counting costs time, so it has a frame of its own.
  const auto count = [&](const Camera& camera) {
    RenderSettings counting = settings;
    counting.count = true;
    Frame counted;
    renderer->render(camera, counting, counted);
  };
  const Team& team = Team::here();
  Progress progress(views.size());
  // The first batch is rendered twice: the first time allocates memory, which no frame's time should contain.
  draw(0, settings);
  StageTimes ms;
  for (std::size_t at = 0; at < views.size(); ++at) {
    if (!team.takes(at / batch)) continue;
    const View& view = views[at];
    progress.start(view.name);
    if (at % batch == 0) draw(at, timed(settings)), ms = a_view(renderer->times(), frames.size());
    const Frame& frame = frames[at % batch];
    const std::filesystem::path file =
        video ? std::filesystem::path(options.video)
              : std::filesystem::path(options.out) / (view.name + "." + options.format);
    if (video)
      video->add(frame);
    else
      write(file, frame);
    RenderResult result{.renderer = std::string(renderer->name()),
                        .scene = names.all,
                        .view = view.name,
                        .conventions = options.view.conventions,
                        .lens = words_of(view.camera.lens),
                        .width = frame.width,
                        .height = frame.height,
                        .scale = options.view.scale,
                        .batch = frames.size(),
                        .image = file.string(),
                        .ms = ms,
                        .counts = std::nullopt};
    if (options.stats) {
      count(view.camera);
      result.counts = renderer->statistics();
    }
    progress.clear();
    if (!team.is_shared() && !video) print(result);
    numbered.emplace_back(at, std::move(result));
    progress.step();
  }
  progress.await_others();
  progress.clear();
  if (video) video->finish();
  team.join(numbered);
  const std::vector<RenderResult> results = rows_of(std::move(numbered));
  if (!team.leads()) return;
  std::vector<double> totals;
  for (const RenderResult& result : results) {
    if (team.is_shared()) print(result);
    totals.push_back(result.ms.total);
  }
  std::nth_element(totals.begin(), totals.begin() + std::ptrdiff_t(totals.size() / 2), totals.end());
  std::printf("%zu %s with %s, median %.2f ms a %s\n", views.size(), views.size() == 1 ? "image" : "images",
              std::string(renderer->name()).c_str(), totals[totals.size() / 2],
              batch == 1 ? "frame" : "view");
  if (pages)
    std::printf("pages: %.3g million splats in a frame at most, with errors of %.3g pixels at most\n",
                1e-6 * double(most_splats), most_pixels);
  const bool estimates = pages && options.pages.estimate != 0;
  if (estimates && std::isnan(least_db))
    std::printf("pages: no estimate, as of panoramas and where pages of a few pixels exceed its memory\n");
  else if (estimates)
    std::printf("pages: frames are estimated to be %.1f dB from the scene at least\n", least_db);
  if (json.is_wanted()) json.write(to_json(head, results));
  json.finish();
}

constexpr const char* render_help =
    R"(Prints where each image is and how long its frame took, memory and files left out.
A scene without cameras gets one view, which is found for it; 'builtin' has a front view,
number 0, and an orbit, 1 to 24. Images are called as the cameras are, or by number.
Scenes are drawn as their files say that they were trained, or as --model says.
Each camera has the lens of its file unless --lens or --panorama gives all the same.
With --place, or a list, a frame shows several scenes, and splats of all are blended in one order.
The first one has the cameras. A list is a JSON array of objects with "file", beside the list,
and where they differ from these defaults "rotation": [1, 0, 0, 0] (a quaternion w, x, y, z, or
three rows), "scale": 1, "translation": [0, 0, 0], "opacity": 1,
"tint": [red, green, blue, amount], "visible": true, "first" and "count" of the Gaussians that
show, and "clip" with what of them shows, in
numbers of the file: "box": [x, y, z, x, y, z], "sphere": [x, y, z, radius], and "half_spaces":
[[x, y, z, offset]]. A scene with an origin stands at its origin.
--video has as many frames a second as a camera_path.json says, and 24 of other cameras.
--renderer reference draws in float64, slowly. NAME.npy has RGBA as doubles, premultiplied, and
NAME.ambiguous.npy how far decisions on the edge may move each pixel; an EXR has that as channel
features.0.
With --batch N a frame has N views, the last frame what is left. The time of an image is then
that of its frame, divided by the views of the frame.

Examples:
  swiftgs render builtin:1000000 --scale 2 --out big
  swiftgs render garden/ --views 0,8,DSC08050
  swiftgs render garden.spz --cameras cameras.json --views 0,8 --stats
  swiftgs render fox.spz --cameras fox/sparse/0 --views every:8 --format exr
  swiftgs render garden/ --views 0 --panorama --scale 2
  swiftgs render garden.spz --cameras camera_path.json --video garden.mp4
  swiftgs render room.spz chair.ply lamp.ply --place
  swiftgs render garden/ --views 0 --renderer reference --format npy
  swiftgs render city.sgp --cameras camera_path.json --pixels 2 --video walk.mp4
  swiftgs render scenes.json)";

}  // namespace

void add_render(CLI::App& app) {
  CLI::App* command = app.add_subcommand("render", "Renders views of a scene to image files");
  command->footer(render_help);
  const auto options = std::make_shared<RenderOptions>();
  command
      ->add_option(
          "SCENE", options->scenes,
          std::string("Files, folders of captures, builtin, or builtin:N for N Gaussians; files are\n") +
              readable_scenes() + ",\nor a .json list of scenes, shown in one frame")
      ->required();
  command->add_flag("--place", options->place,
                    "Show several SCENEs in one frame, each where its file has it");
  add_scene_reading(*command, options->scene);
  add_views(*command, options->view, "all");
  add_planes(*command, options->view.planes);
  add_lens(*command, options->lens);
  command->add_option("--renderer", options->renderer,
                      "A name from 'swiftgs list', or reference [the quickest on the CPU]");
  command->add_option("--out", options->out, "Folder for the images")->capture_default_str();
  command
      ->add_option("--format", options->format, "Format of the images: png, pfm or exr; npy of the reference")
      ->capture_default_str();
  command->add_option("--video", options->video,
                      "Video of all views in place of images, such as flight.mp4, by the program ffmpeg");
  add_batch(*command, options->batch);
  add_harmonics(*command, options->harmonics);
  add_page_options(*command, options->pages, options->scene);
  add_json(*command, options->json);
  command->add_flag("--stats", options->stats, "Print what each frame had to do");
  command->callback([options] { render(*options); });
}

}  // namespace swiftgs::cli
