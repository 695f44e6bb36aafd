// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <zstd.h>

#include <swiftgs/error.hpp>

#include "output_file.hpp"
#include "packed_output.hpp"
#include "scene_encoding.hpp"
#include "scene_format.hpp"
#include "spz_content.hpp"
#include "spz_encode.hpp"
#include "tasks.hpp"

namespace swiftgs::io {
namespace {

/// One zstd frame of a size known before.
class ZstdFrame {
 public:
  explicit ZstdFrame(std::uint64_t size) : context_(ZSTD_createCCtx()) {
    if (!context_) throw std::bad_alloc();
    check(ZSTD_CCtx_setPledgedSrcSize(context_, size));
    check(ZSTD_CCtx_setParameter(context_, ZSTD_c_compressionLevel, level));
    // Refused where zstd was built without threads. Frames do not depend on how many there are.
    ZSTD_CCtx_setParameter(context_, ZSTD_c_nbWorkers,
                           int(std::max(1u, std::thread::hardware_concurrency())));
  }
  ~ZstdFrame() { ZSTD_freeCCtx(context_); }
  ZstdFrame(const ZstdFrame&) = delete;
  ZstdFrame& operator=(const ZstdFrame&) = delete;

  void add(std::span<const std::byte> bytes) { compress(bytes, ZSTD_e_continue); }

  std::vector<std::byte> finish() {
    compress({}, ZSTD_e_end);
    return std::move(packed_);
  }

 private:
  // Niantic's library takes 12, which makes files 3 % smaller, and three times as long.
  static constexpr int level = 6;

  static std::size_t check(std::size_t result) {
    if (ZSTD_isError(result)) throw Unavailable(ZSTD_getErrorName(result));
    return result;
  }

  void compress(std::span<const std::byte> bytes, ZSTD_EndDirective directive) {
    ZSTD_inBuffer input{bytes.data(), bytes.size(), 0};
    for (;;) {
      const std::size_t before = packed_.size();
      packed_.resize(before + ZSTD_CStreamOutSize());
      ZSTD_outBuffer output{packed_.data() + before, packed_.size() - before, 0};
      const std::size_t left = check(ZSTD_compressStream2(context_, &output, &input, directive));
      packed_.resize(before + output.pos);
      if (directive == ZSTD_e_end ? left == 0 : input.pos == input.size) return;
    }
  }

  ZSTD_CCtx* context_;
  std::vector<std::byte> packed_{};
};

void append(std::string& to, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) to += char(value >> 8 * i & 255);
}

/// A scene on its way into a file.
class SpzWriter {
 public:
  SpzWriter(const std::filesystem::path& path, const Scene& scene, int fractional_bits,
            const SceneWriteOptions& options, LossMeter& losses)
      : path_(path), scene_(scene), losses_(losses), progress_(options.progress, path.string()) {
    encoding_ = {flip_of(options.spz_frame), fractional_bits};
    header_ = {.version = std::uint32_t(options.spz_version),
               .count = std::uint32_t(scene.size()),
               .sh_degree = scene.sh_degree,
               .fractional_bits = encoding_.fractional_bits,
               .antialiased = scene.model.antialiased,
               .has_extensions = encoding_.flip != rub_to_rdf};
    // Readers that know the extension convert, and those that do not step over it and take the numbers as
    // they are, as they do without it. In version 3 some releases of Niantic's library are among the latter.
    if (!header_.has_extensions) return;
    append(extensions_, spz_coordinate_system, 4), append(extensions_, 4, 4);
    append(extensions_, encoding_.flip == luf_to_rdf ? 7 : 6, 4);
  }

  std::uint64_t write() {
    progress_.report(0);
    OutputFile file(path_);
    header_.version == 4 ? write_streams(file) : write_gzip(file);
    progress_.report(1);  // a file that has taken its place cannot be cancelled
    file.close();
    return file.size();
  }

  std::vector<std::string> notes() const {
    std::vector<std::string> notes;
    const int bits = encoding_.fractional_bits;
    if (bits < 12) {
      const auto beyond = std::count_if(scene_.means.begin(), scene_.means.end(), [](const vec3& mean) {
        return std::max({std::abs(mean.x), std::abs(mean.y), std::abs(mean.z)}) >= 2048;
      });
      notes.push_back("Positions are rounded to 1/" + std::to_string(1 << bits) +
                      " instead of 1/4096, because of Gaussians beyond 2048: " + std::to_string(beyond) +
                      ".");
    }
    if (const auto sentence = losses_.sentence()) {
      if (notes.empty())
        notes.push_back(*sentence);
      else
        notes.back() += " " + *sentence;
    }
    note_clamped(clamped_[spz_positions], "Coordinates", "-8388607 to 8388607", notes);
    note_clamped(clamped_[spz_colours], "SH coefficients of band 0", "-3.33 to 3.33", notes);
    note_clamped(clamped_[spz_scales], "Scales", "exp(-10) to exp(5.94)", notes);
    note_clamped(clamped_[spz_sh], "SH coefficients above band 0", "-1 to 0.99", notes);
    return notes;
  }

 private:
  /// The fields that all versions share, up to the last.
  std::string start() const {
    std::string start;
    append(start, spz_magic, 4), append(start, header_.version, 4), append(start, header_.count, 4);
    append(start, std::uint64_t(header_.sh_degree), 1);
    append(start, std::uint64_t(header_.fractional_bits), 1);
    append(start, std::uint64_t(header_.antialiased) | std::uint64_t(header_.has_extensions) << 1, 1);
    return start;
  }

  /// Hands an attribute to `take` in pieces.
  template <class Take>
  void encode(SpzAttribute attribute, const Take& take) {
    constexpr std::size_t step = 1 << 17;
    const std::size_t size = spz_sizes(header_)[attribute];
    std::vector<std::byte> piece(std::min(step, scene_.size()) * size);
    for (std::size_t begin = 0; begin < scene_.size() && size != 0; begin += step) {
      const std::size_t count = std::min(step, scene_.size() - begin);
      std::atomic<std::uint64_t> clamped = 0;
      for_parts(count, [&](std::size_t first, std::size_t end) {
        clamped +=
            encode_spz(scene_, encoding_, attribute, begin + first, begin + end, piece.data() + first * size);
        measure_spz(header_, encoding_.flip, attribute, begin + first, begin + end,
                    piece.data() + first * size, losses_);
      });
      clamped_[attribute] += clamped;
      take(std::span<const std::byte>(piece).first(count * size));
      done_ += count * size;
      progress_.report(double(done_) / double(spz_total(header_)));
    }
  }

  void write_gzip(OutputFile& file) {
    GzipWriter gzip(file);
    const std::string first = start() + '\0';
    const auto add = [&](std::span<const std::byte> bytes) { gzip.add(bytes); };
    add(std::as_bytes(std::span(first)));
    for (int a = 0; a < spz_attributes; ++a) encode(SpzAttribute(a), add);
    add(std::as_bytes(std::span(extensions_)));
    gzip.finish();
  }

  void write_streams(OutputFile& file) {
    std::string table;
    std::vector<std::vector<std::byte>> frames;
    for (int a = 0; a < spz_attributes; ++a) {
      const std::uint64_t size = scene_.size() * spz_sizes(header_)[a];
      if (size == 0) continue;  // an attribute without bytes has no stream
      ZstdFrame frame(size);
      encode(SpzAttribute(a), [&](std::span<const std::byte> bytes) { frame.add(bytes); });
      frames.push_back(frame.finish());
      append(table, frames.back().size(), 8), append(table, size, 8);
    }
    std::string head = start();
    append(head, frames.size(), 1), append(head, spz_streams_header_size + extensions_.size(), 4);
    head.resize(spz_streams_header_size);
    head += extensions_ + table;
    file.write(head.data(), head.size());
    for (const auto& frame : frames) file.write(frame.data(), frame.size());
  }

  std::filesystem::path path_;
  const Scene& scene_;
  LossMeter& losses_;
  ProgressMeter progress_;
  SpzEncoding encoding_;
  SpzHeader header_;
  std::string extensions_{};
  std::array<std::uint64_t, spz_attributes> clamped_{};
  std::size_t done_ = 0;
};

}  // namespace

WrittenScene write_spz(const std::filesystem::path& path, const Scene& scene,
                       const SceneWriteOptions& options, LossMeter& losses) {
  if (options.spz_version != 3 && options.spz_version != 4)
    detail::refuse(path.string(), ": expected SPZ version 3 or 4 to write, found ", options.spz_version);
  constexpr std::size_t most = std::numeric_limits<std::int32_t>::max();
  if (scene.size() < 1 || scene.size() > most)
    detail::refuse(path.string(), ": expected 1 to ", most,
                   " Gaussians of finite numbers for an SPZ file, found ", scene.size());
  const SpzReach reach = reach_of(scene);
  const std::optional<Scene> nearer =
      reach.beyond.empty() ? std::nullopt : std::optional(drawn_in(scene, reach));
  SpzWriter writer(path, nearer ? *nearer : scene, reach.fractional_bits, options, losses);
  WrittenScene written = written_whole("SPZ version " + std::to_string(options.spz_version), scene);
  written.model = {.antialiased = scene.model.antialiased};
  written.bytes = writer.write();
  written.notes = writer.notes();
  if (nearer)
    written.notes.push_back(
        "Gaussians far from all others, beyond coordinates of " +
        std::to_string(std::uint32_t(std::ceil(reach.largest()))) +
        ", are moved nearer and made smaller, so that they look the same from the middle of the scene: " +
        std::to_string(reach.beyond.size()) + ".");
  return written;
}

}  // namespace swiftgs::io
