// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/io/image.hpp>

#include "bench/measure.hpp"
#include "bench/results.hpp"
#include "draw/team.hpp"
#include "notes.hpp"
#include "read/views.hpp"
#include "result_file.hpp"

namespace swiftgs::cli {

/// Views of one scene at one scale, with one preset of conventions, on one number of threads.
struct Session {
  SceneResult scene;
  std::shared_ptr<const Scene> gaussians;
  HarmonicsKept harmonics{};
  std::vector<View> views;
  std::vector<std::optional<Image>> photos;  ///< of each view, or empty
  double scale = 1;
  std::string conventions;
  RenderSettings settings;
  int threads = 0;
};

/// Measures renderers on sessions and adds what it finds to results.
class Runner {
 public:
  struct Options {
    Plan plan;
    std::size_t judged = 0;  ///< how many of a session's views are compared with a reference
    std::size_t batch = 1;   ///< views of a frame that is timed
    std::string planes{};    ///< of rows
  };

  /// Rows that `results` hold already are not measured again. `file` is written after every row.
  Runner(std::vector<RendererEntry> entries, Options options, Results& results, ResultFile& file,
         Progress& progress)
      : entries_(std::move(entries)),
        options_(std::move(options)),
        results_(results),
        file_(file),
        progress_(progress),
        resumed_(results.rows.size(), true) {}

  /// Throws `Interrupted` after Ctrl-C.
  void run(const Session& session);

  /// Brings what all processes of a team have measured to the results of the first, in the order of one
  /// process. Collective.
  void join();

 private:
  /// A renderer, and which views it has no rows of.
  struct Task {
    const RendererEntry* entry;
    std::vector<bool> lacks;
  };
  struct Subject {
    std::unique_ptr<AnyRenderer> renderer;
    std::vector<bool> lacks{};
    std::uint64_t device_bytes = 0, host_bytes = 0;
  };

  /// Of the frame that is timed for a view: the view and those after it, and the first ones after the last.
  std::vector<Camera> batch_of(const Session& session, std::size_t view) const;
  /// Whether the session's row was there at the beginning. Each answers once, so that views of one name
  /// count.
  bool was_measured(const Session& session, std::size_t view, std::string_view renderer);
  std::vector<Task> tasks_of(const Session& session);
  void begin(const std::string& what);
  std::vector<Subject> prepare(const Session& session, const std::vector<Task>& tasks, std::size_t first);
  void add_view(const Session& session, std::size_t view, Judge& judge);
  void add(ViewResult result);
  void measure_view(const Session& session, std::size_t view, const std::vector<Subject*>& subjects,
                    Judge& judge);
  void write();
  RowResult row_of(const Session& session, std::size_t view, const Subject& subject, const Samples& samples,
                   Judge& judge);

  std::vector<RendererEntry> entries_;
  Options options_;
  Results& results_;
  ResultFile& file_;
  Progress& progress_;
  std::vector<bool> resumed_;       ///< of the rows that were there, whether each still stands for one
  std::uint64_t views_so_far_ = 0;  ///< that renderers have taken turns on before
  Numbered<RowResult> rows_;        ///< of this process, where several share the views
  Numbered<ViewResult> views_;
};

}  // namespace swiftgs::cli
