// SPDX-License-Identifier: Apache-2.0
#include "bench/runner.hpp"

#include <algorithm>
#include <utility>

#include <swiftgs/bounds/three_sigma_square.hpp>

#include "bench/machine.hpp"
#include "interruptible.hpp"
#include "words.hpp"

namespace swiftgs::cli {
namespace {

constexpr std::uint64_t spare_bytes = 2ull << 30;

Place place_of(const Session& session, std::size_t view) {
  const Camera& camera = session.views[view].camera;
  return {session.scene.scene, session.scene.gaussians, session.scene.enlarge, session.views[view].name,
          camera.width,        camera.height,           session.scale,         session.conventions};
}

std::uint64_t grown(std::uint64_t before, std::uint64_t after) { return after > before ? after - before : 0; }

std::uint64_t device_bytes(const AnyRenderer& renderer) {
  const std::optional<MemoryUse> use = renderer.device_memory();
  return use ? use->in_use : 0;
}

/// Whether the memory of `like`'s machine or device has as many `bytes` left.
bool fits_memory(const AnyRenderer& like, std::uint64_t bytes) {
  const std::optional<MemoryUse> use = like.device_memory();
  const bool on_device = !use || use->total - use->in_use > bytes + spare_bytes;
  return on_device && available_memory() > bytes + spare_bytes;
}

}  // namespace

bool Runner::was_measured(const Session& session, std::size_t view, std::string_view renderer) {
  const Place place = place_of(session, view);
  for (std::size_t i = 0; i < resumed_.size(); ++i) {
    const RowResult& row = results_.rows[i];
    if (!resumed_[i] || row.renderer != renderer || row.threads != session.threads || row.place != place)
      continue;
    resumed_[i] = false;
    return true;
  }
  return false;
}

std::vector<Runner::Task> Runner::tasks_of(const Session& session) {
  std::vector<Task> tasks;
  for (const RendererEntry& entry : entries_) {
    Task task{&entry, {}};
    for (std::size_t view = 0; view < session.views.size(); ++view)
      task.lacks.push_back(!was_measured(session, view, entry.name));
    if (std::find(task.lacks.begin(), task.lacks.end(), true) != task.lacks.end())
      tasks.push_back(std::move(task));
  }
  return tasks;
}

void Runner::begin(const std::string& what) {
  Interruptible::stop_if_interrupted();
  progress_.start(what);
}

void Runner::run(const Session& session) {
  const std::vector<Task> tasks = tasks_of(session);
  // As many renderers alternate as fit the memory.
  for (std::size_t first = 0; first < tasks.size();) {
    std::vector<Subject> subjects = prepare(session, tasks, first);
    // Processes that share the views count on as one.
    subjects.resize(Team::here().least(subjects.size()));
    for (std::size_t view = 0; view < session.views.size(); ++view) {
      if (!Team::here().takes(view)) continue;
      std::vector<Subject*> wanted;
      for (Subject& subject : subjects)
        if (subject.lacks[view]) wanted.push_back(&subject);
      if (wanted.empty()) continue;
      Judge judge(session.gaussians, session.views[view].camera, session.settings,
                  session.photos.empty() ? std::nullopt : session.photos[view]);
      add_view(session, view, judge);
      measure_view(session, view, wanted, judge);
    }
    first += subjects.size();
    views_so_far_ += session.views.size();
  }
}

void Runner::write() {
  if (file_.is_wanted()) file_.write(to_json(results_));
}

void Runner::join() {
  progress_.await_others();
  const Team& team = Team::here();
  if (!team.is_shared()) return;
  team.join(rows_), team.join(views_);
  results_.rows = rows_of(std::move(rows_)), results_.views.clear();
  for (ViewResult& view : rows_of(std::move(views_))) add(std::move(view));
  write();
}

std::vector<Camera> Runner::batch_of(const Session& session, std::size_t view) const {
  std::vector<Camera> cameras;
  for (std::size_t i = 0; i < options_.batch; ++i)
    cameras.push_back(session.views[(view + i) % session.views.size()].camera);
  return cameras;
}

std::vector<Runner::Subject> Runner::prepare(const Session& session, const std::vector<Task>& tasks,
                                             std::size_t first) {
  std::vector<Subject> subjects;
  std::uint64_t largest = 0;
  for (std::size_t i = first; i < tasks.size(); ++i) {
    begin("warm up " + std::string(tasks[i].entry->name));
    Subject subject{tasks[i].entry->make(), tasks[i].lacks};
    AnyRenderer& renderer = *subject.renderer;
    if (!subjects.empty() && !fits_memory(renderer, largest)) break;
    if (std::none_of(subjects.begin(), subjects.end(),
                     [&](const Subject& other) { return renderer.share_scene(*other.renderer); }))
      renderer.set_scene(session.gaussians, session.harmonics);
    release_free_memory();
    const std::uint64_t device = device_bytes(renderer), host = resident_memory();
    // Every frame once, so that nothing grows later.
    for (std::size_t view = 0; view < session.views.size(); ++view) {
      const std::vector<Camera> cameras = batch_of(session, view);
      renderer.render_resident({cameras.data(), cameras.size()}, session.settings);
    }
    subject.device_bytes = grown(device, device_bytes(renderer));
    subject.host_bytes = grown(host, resident_memory());
    largest = std::max({largest, subject.device_bytes, subject.host_bytes});
    subjects.push_back(std::move(subject));
  }
  return subjects;
}

void Runner::add_view(const Session& session, std::size_t view, Judge& judge) {
  ViewResult result{place_of(session, view), std::nullopt};
  if (view < options_.judged) {
    begin("reference " + result.place.view);
    judge.render_reference();
    result.photo = judge.reference_photo();
  }
  if (Team::here().is_shared()) views_.emplace_back(views_so_far_ + view, result);
  add(std::move(result));
}

void Runner::add(ViewResult result) {
  // Another number of threads has the same views.
  const auto same = [&](const ViewResult& other) { return other.place == result.place; };
  if (std::none_of(results_.views.begin(), results_.views.end(), same))
    results_.views.push_back(std::move(result));
}

void Runner::measure_view(const Session& session, std::size_t view, const std::vector<Subject*>& subjects,
                          Judge& judge) {
  std::vector<AnyRenderer*> renderers;
  for (const Subject* subject : subjects) renderers.push_back(subject->renderer.get());
  const std::vector<Camera> batch = batch_of(session, view);
  const Span<const Camera> cameras{batch.data(), batch.size()};
  begin(session.scene.scene + " " + session.views[view].name);
  for (AnyRenderer* renderer : renderers) adapt(*renderer, cameras, session.settings);
  std::vector<std::size_t> finished;  // those with a row, in the order of `subjects`, as are the rows
  measure(renderers, cameras, session.settings, options_.plan, [&](std::size_t i, const Samples& samples) {
    RowResult row = row_of(session, view, *subjects[i], samples, judge);
    const auto place = std::lower_bound(finished.begin(), finished.end(), i);
    results_.rows.insert(results_.rows.end() - (finished.end() - place), std::move(row));
    finished.insert(place, i);
    if (!Team::here().is_shared()) write();
    progress_.step();
    begin(session.scene.scene + " " + session.views[view].name + " " + std::string(renderers[i]->name()));
  });
  if (!Team::here().is_shared()) return;
  for (auto row = results_.rows.end() - std::ptrdiff_t(subjects.size()); row != results_.rows.end(); ++row)
    rows_.emplace_back(views_so_far_ + view, *row);
}

RowResult Runner::row_of(const Session& session, std::size_t view, const Subject& subject,
                         const Samples& samples, Judge& judge) {
  AnyRenderer& renderer = *subject.renderer;
  RowResult row;
  row.place = place_of(session, view);
  row.threads = session.threads;
  row.renderer = renderer.name(), row.planes = options_.planes;
  row.harmonics = renderer.harmonics(0);
  row.frames = samples.frames();
  row.batch = options_.batch;
  row.ms = samples.summary();
  row.bytes = renderer.memory();
  row.device_bytes = subject.device_bytes, row.host_bytes = subject.host_bytes;

  const Camera& camera = session.views[view].camera;
  RenderSettings counting = session.settings;
  counting.count = true;
  renderer.render_resident(camera, session.settings);  // the next frame has the tiles that this one teaches
  renderer.render_resident(camera, counting);
  const Statistics counts = renderer.statistics();
  row.visible = counts.visible, row.intersections = counts.intersections;
  row.contributing_pairs = counts.raster.contributing_pairs;

  const bool judged = view < options_.judged, photographed = !session.photos.empty() && session.photos[view];
  if (!judged && !photographed) return row;
  Frame frame;
  renderer.render(camera, session.settings, frame);
  const Judge::Verdict verdict =
      judge.of(frame, RendererWords(row.renderer).bounds == ThreeSigmaSquare::name);
  row.errors = verdict.errors, row.photo = verdict.photo;
  return row;
}

}  // namespace swiftgs::cli
