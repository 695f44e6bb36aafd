// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <numeric>
#include <span>
#include <sstream>
#include <utility>

#include <swiftgs/edit/origin.hpp>
#include <swiftgs/edit/select.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/io/capture.hpp>
#include <swiftgs/io/replace_file.hpp>
#include <swiftgs/pages/build_pages.hpp>
#include <swiftgs/project/chunks.hpp>
#include <swiftgs/tools/parallel.hpp>
#include <swiftgs/version.hpp>

#include "nodes.hpp"
#include "output_file.hpp"
#include "page_file.hpp"
#include "page_writer.hpp"
#include "records.hpp"
#include "scene_building.hpp"

namespace swiftgs {
namespace {

using pages::Nodes, pages::PageWriter, pages::Records;

/// Memory of a Gaussian while a subtree is made of it: as read, in another order, and its indices.
/// @units{bytes}
constexpr std::size_t bytes_of_gaussian = 500;

/// What nodes take that wait for their neighbours, two pages for each level of a deep tree. @units{bytes}
std::size_t bytes_of_waiting(const PageBuildOptions& options) {
  return std::size_t(48) * 240 * options.page_size;
}

void validate(const PageBuildOptions& options) {
  if (options.page_size == 0 || options.page_size % chunk_size != 0 || options.page_size > 1u << 20)
    detail::refuse("pages: a page of ", options.page_size, " Gaussians, expected a multiple of ", chunk_size,
                   " up to ", 1u << 20);
  const std::size_t least = bytes_of_waiting(options) + 2 * bytes_of_gaussian * options.page_size;
  if (options.memory < least)
    detail::refuse("pages: ", options.memory, " bytes of memory, expected ", least, " or more for pages of ",
                   options.page_size, " Gaussians");
}

/// Gaussians of all sources in a temporary file, and what they have in common.
class Gathered {
 public:
  Gathered(const std::filesystem::path& folder, std::string model)
      : records_(folder), model_(std::move(model)) {}

  void add(const Scene& scene, const std::string& name) {
    if (scene.size() == 0) return;
    if (scene.feature_channels != 0)
      detail::refuse(name, ": a scene with features, expected none: pages do not hold them");
    const RenderingModel model = model_.empty() ? scene.model : model_from(model_, scene.model);
    if (records_.size() == 0) like_ = empty_like(scene), like_.model = model;
    if (model != like_.model)
      detail::refuse(name, ": another rendering model than that of the first scene, expected the same");
    const std::size_t most = std::numeric_limits<std::uint32_t>::max(), all = records_.size() + scene.size();
    if (all > most) throw CapacityError("Gaussians in a page file", all, most);
    if (scene.origin != like_.origin) return add(with_origin(scene, like_.origin), name);
    like_.sh_degree = std::max(like_.sh_degree, scene.sh_degree);
    records_.append(scene, std::uint32_t(records_.size()));
  }

  Records& records() { return records_; }
  const Scene& like() const { return like_; }

 private:
  Records records_;
  std::string model_;
  Scene like_;
};

/// Makes pages of Gaussians from the leaves up.
class Builder {
 public:
  Builder(const PageBuildOptions& options, const Scene& like, std::uint64_t gaussians, PageWriter& writer,
          Progress progress)
      : options_(options),
        like_(like),
        gaussians_(gaussians),
        threads_(thread_count(options.threads)),
        in_memory_((options.memory - bytes_of_waiting(options)) / bytes_of_gaussian),
        writer_(writer),
        progress_(std::move(progress)) {}

  struct Subtree {
    std::uint32_t page;
    Nodes nodes;
  };

  Subtree build(Records records) {
    if (!options_.order || records.size() <= in_memory_) return build(records, 0, records.size());
    return found_or(records.size(), [&] {
      auto [left, right] = split(std::move(records));
      Subtree a = build(std::move(left));
      return join(std::move(a), build(std::move(right)));
    });
  }

 private:
  /// The subtree of the next `count` Gaussians: as an earlier build left it, else what `make` returns.
  template <class Make>
  Subtree found_or(std::size_t count, const Make& make) {
    const std::size_t leaves = (count + options_.page_size - 1) / options_.page_size;
    if (!writer_.take_found(2 * leaves - 1)) return make();
    tell_written(count);
    const std::uint32_t root = writer_.pages() - 1;
    return {root, writer_.nodes(root)};
  }

  void tell_written(std::size_t count) {
    written_ += count;
    progress_(double(written_) / double(gaussians_));
  }

  /// The first part of `count` Gaussians, which fills pages.
  std::size_t half(std::size_t count) const {
    const std::size_t page = options_.page_size, pages = (count + page - 1) / page;
    return (pages + 1) / 2 * page;
  }

  std::pair<Records, Records> split(Records records) {
    return records.split(half(records.size()));  // the file of both is gone when it returns
  }

  Subtree build(Records& records, std::size_t first, std::size_t count) {
    return found_or(count, [&] {
      if (count > in_memory_) {
        Subtree a = build(records, first, half(count));
        return join(std::move(a), build(records, first + half(count), count - half(count)));
      }
      PageContent all = records.read(first, count, like_);
      if (options_.order) {
        std::vector<std::uint32_t> order(count);
        std::iota(order.begin(), order.end(), 0u);
        pages::order_by_halves(all.scene.means, order, options_.page_size, chunk_size, threads_);
        all.scene = subset(all.scene, order);
        for (std::uint32_t& number : order) number = all.ids[number];
        all.ids = std::move(order);
      }
      return build(all, 0, count);
    });
  }

  Subtree build(const PageContent& all, std::size_t first, std::size_t count) {
    return found_or(count, [&] {
      if (count > options_.page_size) {
        Subtree a = build(all, first, half(count));
        return join(std::move(a), build(all, first + half(count), count - half(count)));
      }
      std::vector<std::uint32_t> members(count);
      std::iota(members.begin(), members.end(), std::uint32_t(first));
      Nodes nodes{subset(all.scene, members), std::vector<float>(count)};
      std::span<const std::uint32_t> ids;
      if (options_.order) ids = std::span(all.ids).subspan(first, count);
      Page page;
      page.first = written_;
      const std::uint32_t number = writer_.add(page, nodes, ids);
      tell_written(count);
      return Subtree{number, std::move(nodes)};
    });
  }

  Subtree join(Subtree a, Subtree b) {
    Nodes nodes = pages::merge(a.nodes, b.nodes, threads_);
    Page page;
    page.left = a.page, page.right = b.page, page.first = writer_.page(a.page).first;
    for (const std::uint32_t child : {a.page, b.page})
      detail::add_bounds(page.bounds, writer_.page(child).bounds);
    pages::set_errors(page, nodes);
    return {writer_.add(page, nodes, {}), std::move(nodes)};
  }

  const PageBuildOptions& options_;
  const Scene& like_;
  std::uint64_t gaussians_, written_ = 0;
  int threads_;
  std::size_t in_memory_;  ///< Gaussians whose subtree is made without a file
  PageWriter& writer_;
  Progress progress_;
};

/// A number for all that the bytes of the file depend on: the Gaussians, the options, and the algorithm, of
/// which `build_version` and the compiler are part. Without `order` they do not depend on the memory.
std::uint64_t key_of(Gathered& gathered, const PageBuildOptions& options) {
  const Scene& like = gathered.like();
  std::ostringstream text;
  text << version << ' ' << pages::build_version << ' ' << __VERSION__ << ' ' << options.page_size << ' '
       << (options.order ? options.memory : 0) << ' ' << like.sh_degree << ' ' << text_of(like.model)
       << std::hexfloat << ' ' << like.origin.x << ' ' << like.origin.y << ' ' << like.origin.z;
  const std::string all = text.str();
  return pages::checksum_of(std::as_bytes(std::span(all)), gathered.records().checksum());
}

std::string what_remains(const PageWriter& writer) {
  return "; " + writer.unfinished().string() + " and " + writer.steps().string() +
         " remain: the same build resumes with them, deleting both gives up";
}

/// `gather(gathered, progress)` gives the Gaussians.
template <class Gather>
BuiltPages build(const std::filesystem::path& out, const PageBuildOptions& options, const Gather& gather) {
  validate(options);
  if (!options.model.empty()) (void)model_from(options.model);  // before a large file is read
  require_replaceable(out);
  if (io::is_stream(out))
    detail::refuse(out.string(),
                   ": expected a file, found a pipe or a device: a page file is not written front to back");
  PageWriter writer(out);  // refuses before large files are read
  const auto part_of_progress = [&](double begin, double end) -> Progress {
    return [&, begin, end](double part) {
      if (options.progress && !options.progress(begin + part * (end - begin)))
        throw Cancelled(out.string(), writer.leaves_files() ? what_remains(writer) : "");
      return true;
    };
  };
  constexpr double read = 0.3, found = 0.35;  // parts of the time that pass until then, roughly
  Gathered gathered(writer.folder(), options.model);
  BuiltPages built;
  gather(gathered, part_of_progress(0, read), built.notes);
  built.gaussians = gathered.records().size();
  if (built.gaussians == 0) detail::refuse(out.string(), ": no Gaussians, expected one or more");
  const Scene like = gathered.like();
  writer.begin(key_of(gathered, options), built.gaussians, like, part_of_progress(read, found));
  built.resumed = writer.found();
  if (writer.began_anew())
    built.notes.push_back(writer.unfinished().string() +
                          " was of other Gaussians, options or version: it began anew.");
  Builder builder(options, like, built.gaussians, writer, part_of_progress(found, 1));
  builder.build(std::move(gathered.records()));
  built.pages = writer.pages();
  for (std::uint32_t i = 0; i < writer.pages(); ++i) built.leaves += writer.page(i).is_leaf();
  built.bytes = writer.finish(options.page_size);
  return built;
}

/// Adds the Gaussians of pages, one page after the other.
void add_leaves(const PagedScene& from, Gathered& to, const Progress& progress) {
  const std::vector<std::uint32_t> leaves = pages::leaves_of(from);
  for (std::size_t k = 0; k < leaves.size(); ++k) {
    to.add(from.read(leaves[k]).scene, from.name());
    progress(double(k + 1) / double(leaves.size()));
  }
}

/// Parts in which to read a file so that each takes at most a quarter of the memory.
std::size_t parts_of(const std::filesystem::path& file, std::size_t memory) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  const bool in_parts = file.extension() == ".ply" || file.extension() == ".splat";
  // A scene in memory is up to eight times as large as its file.
  return error || !in_parts ? 1 : std::clamp<std::size_t>(size / (memory / 32), 1, 65535);
}

}  // namespace

BuiltPages build_pages(const std::vector<std::filesystem::path>& sources, const std::filesystem::path& out,
                       const PageBuildOptions& options) {
  return build(out, options, [&](Gathered& to, const Progress& progress, std::vector<std::string>& notes) {
    for (std::size_t k = 0; k < sources.size(); ++k) {
      const auto at = [&](double done) { return progress((double(k) + done) / double(sources.size())); };
      if (is_page_file(sources[k])) {
        add_leaves(open_pages(sources[k]), to, at);
        continue;
      }
      const std::size_t parts = parts_of(find_capture(sources[k]).scene, options.memory);
      LeftOut left_out;
      std::uint64_t signs_dropped = 0;
      std::vector<std::string> said;  // of this source
      for (std::size_t part = 0; part < parts; ++part) {
        SceneReadOptions read = options.read;
        read.part = {part, parts};
        read.progress = [&](double done) { return at((double(part) + done) / double(parts)); };
        SceneFile file = read_scene(sources[k], read);
        for (std::string& note : file.notes)
          if (std::find(said.begin(), said.end(), note) == said.end()) said.push_back(std::move(note));
        left_out += file.left_out, signs_dropped += file.signs_dropped;
        to.add(file.scene, sources[k].string());
      }
      if (parts > 1) {
        io::note_dropped_signs(signs_dropped, "taken", said);
        io::note_left_out(left_out, said);
      }
      notes.insert(notes.end(), said.begin(), said.end());
    }
  });
}

BuiltPages build_pages(const Scene& scene, const std::filesystem::path& out,
                       const PageBuildOptions& options) {
  swiftgs::validate(scene);
  validate_numbers(scene);
  for (std::size_t i = 0; i < scene.opacities.size(); ++i)
    if (!(scene.opacities[i] >= 0 && scene.opacities[i] <= 1))
      detail::refuse("opacities[", i, "] is ", scene.opacities[i], ", expected 0 to 1");
  return build(out, options,
               [&](Gathered& to, const Progress&, std::vector<std::string>&) { to.add(scene, "pages"); });
}

}  // namespace swiftgs
