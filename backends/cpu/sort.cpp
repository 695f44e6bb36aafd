// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <swiftgs/cpu.hpp>

namespace swiftgs {
namespace {

/// Elements [begin, end) of part `part` of `parts`.
struct Part {
  std::size_t begin, end;
};
Part part_of(std::size_t n, std::size_t parts, std::size_t part) {
  return {n * part / parts, n * (part + 1) / parts};
}

/// Parts of at least `grain` elements, a few a thread so that an uneven machine does not wait for one.
std::size_t part_count(const Cpu& cpu, std::size_t n, std::size_t grain) {
  const std::size_t wanted = cpu.threads() == 1 ? 1 : 3 * std::size_t(cpu.threads());
  return std::clamp<std::size_t>(n / grain, 1, wanted);
}

/// Digits of about 11 bits keep a histogram and its write positions in the first-level cache; up to 13 bits
/// one pass over more positions still beats two passes.
int digit_bits(int bits) {
  if (bits <= 13) return bits;
  const int passes = (bits + 10) / 11;
  return (bits + passes - 1) / passes;
}

template <class Key>
class RadixPass {
 public:
  RadixPass(const Cpu& cpu, Cpu::Buffer<std::uint32_t>& histograms, std::size_t n, int shift, int bits)
      : cpu_(cpu), n_(n), shift_(shift), bins_(std::size_t(1) << bits), parts_(part_count(cpu, n, 8192)) {
    histograms.reset(parts_ * bins_);
    histograms_ = histograms.data();
  }

  /// Counts digits a part, then turns counts into first positions. False where all keys share the digit.
  bool count(const Key* keys) {
    cpu_.for_parts(parts_, 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t part = first; part < last; ++part) {
        std::uint32_t* histogram = histograms_ + part * bins_;
        std::fill_n(histogram, bins_, 0u);
        const Part range = part_of(n_, parts_, part);
        for (std::size_t i = range.begin; i < range.end; ++i) ++histogram[digit(keys[i])];
      }
    });
    std::uint32_t sum = 0;
    for (std::size_t bin = 0; bin < bins_; ++bin) {
      const std::uint32_t before = sum;
      for (std::size_t part = 0; part < parts_; ++part)
        sum += std::exchange(histograms_[part * bins_ + bin], sum);
      if (sum - before == n_) return false;
    }
    return true;
  }

  /// Moves every pair to its position; parts in order keep equal digits in order.
  void scatter(const Key* keys, const std::uint32_t* values, Key* to_keys, std::uint32_t* to_values) {
    cpu_.for_parts(parts_, 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t part = first; part < last; ++part) {
        std::uint32_t* position = histograms_ + part * bins_;
        const Part range = part_of(n_, parts_, part);
        for (std::size_t i = range.begin; i < range.end; ++i) {
          const std::uint32_t to = position[digit(keys[i])]++;
          to_keys[to] = keys[i];
          to_values[to] = values[i];
        }
      }
    });
  }

 private:
  std::size_t digit(Key key) const { return std::size_t(key >> shift_) & (bins_ - 1); }

  const Cpu& cpu_;
  std::size_t n_;
  int shift_;
  std::size_t bins_, parts_;
  std::uint32_t* histograms_ = nullptr;
};

template <class Key>
void radix_sort(const Cpu& cpu, Cpu::Buffer<std::uint32_t>& histograms, Pairs<Cpu, Key>& pairs, std::size_t n,
                int bits) {
  if (n < 2) return;
  const int step = digit_bits(bits);
  for (int shift = 0; shift < bits; shift += step) {
    RadixPass<Key> pass(cpu, histograms, n, shift, std::min(step, bits - shift));
    if (!pass.count(pairs.keys.data())) continue;
    pass.scatter(pairs.keys.data(), pairs.values.data(), pairs.spare_keys.data(), pairs.spare_values.data());
    std::swap(pairs.keys, pairs.spare_keys);
    std::swap(pairs.values, pairs.spare_values);
  }
}

}  // namespace

void Cpu::sort_pairs(Pairs<Cpu, std::uint32_t>& pairs, std::size_t n, int bits) {
  radix_sort(*this, histograms_, pairs, n, bits);
}

void Cpu::sort_pairs(Pairs<Cpu, std::uint64_t>& pairs, std::size_t n, int bits) {
  radix_sort(*this, histograms_, pairs, n, bits);
}

std::uint64_t Cpu::exclusive_scan(Span<std::uint32_t> counts) {
  // Sum each part, scan the sums, then scan the parts from there.
  const std::size_t parts = part_count(*this, counts.size, 32768);
  part_sums_.reset(parts);
  for_parts(parts, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t part = first; part < last; ++part) {
      const Part range = part_of(counts.size, parts, part);
      std::uint64_t sum = 0;
      for (std::size_t i = range.begin; i < range.end; ++i) sum += counts[i];
      part_sums_.data()[part] = sum;
    }
  });
  std::uint64_t total = 0;
  for (std::size_t part = 0; part < parts; ++part) total += std::exchange(part_sums_.data()[part], total);
  for_parts(parts, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t part = first; part < last; ++part) {
      const Part range = part_of(counts.size, parts, part);
      std::uint64_t sum = part_sums_.data()[part];
      for (std::size_t i = range.begin; i < range.end; ++i) {
        const std::uint32_t here = counts[i];
        counts[i] = std::uint32_t(sum);
        sum += here;
      }
    }
  });
  return total;
}

}  // namespace swiftgs
