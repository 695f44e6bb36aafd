// SPDX-License-Identifier: Apache-2.0
#include "zip_write.hpp"

#include <limits>

#include <zlib.h>

#include <swiftgs/error.hpp>

namespace swiftgs::io {
namespace {

void append16(std::string& to, std::uint32_t value) {
  to += char(value & 0xff);
  to += char(value >> 8 & 0xff);
}

void append32(std::string& to, std::uint32_t value) {
  append16(to, value & 0xffff);
  append16(to, value >> 16);
}

std::uint32_t in_32_bits(std::uint64_t value) {
  if (value >= std::numeric_limits<std::uint32_t>::max())
    throw CapacityError("bytes of a ZIP file", value, std::numeric_limits<std::uint32_t>::max() - 1);
  return std::uint32_t(value);
}

}  // namespace

std::uint32_t ZipWriter::offset() const { return in_32_bits(file_.size()); }

void ZipWriter::add(const std::string& name, const std::string& content) {
  const std::uint32_t size = in_32_bits(content.size());
  const auto sum = crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size());
  // What the entry and the directory both hold.
  std::string common;
  append16(common, 10);  // read by version 1.0
  append16(common, 0);   // flags
  append16(common, 0);   // stored
  append16(common, 0);   // time and date: the first that there is, so that equal scenes make equal files
  append16(common, 1 << 5 | 1);
  append32(common, std::uint32_t(sum));
  append32(common, size);
  append32(common, size);
  append16(common, std::uint32_t(name.size()));
  append16(common, 0);  // extra field

  append32(directory_, 0x02014b50);
  append16(directory_, 10);  // written by version 1.0
  directory_ += common;
  append16(directory_, 0);  // comment
  append16(directory_, 0);  // disk
  append16(directory_, 0);  // internal attributes
  append32(directory_, 0);  // external attributes
  append32(directory_, offset());
  directory_ += name;
  ++entries_;

  std::string header;
  append32(header, 0x04034b50);
  header += common + name;
  file_.write(header.data(), header.size());
  file_.write(content.data(), content.size());
}

void ZipWriter::finish() {
  std::string end;
  append32(end, 0x06054b50);
  append16(end, 0);  // disk
  append16(end, 0);  // disk of the directory
  append16(end, entries_);
  append16(end, entries_);
  append32(end, in_32_bits(directory_.size()));
  append32(end, offset());
  append16(end, 0);  // comment
  file_.write(directory_.data(), directory_.size());
  file_.write(end.data(), end.size());
}

}  // namespace swiftgs::io
