// SPDX-License-Identifier: Apache-2.0
#include "result_head.hpp"

#include "json_text.hpp"

namespace swiftgs::cli {
namespace {

constexpr int version_of_formats = 1;

Json json_of(const Machine& m) {
  Json json{{"date", m.date},
            {"cpu", m.cpu},
            {"cores", m.cores},
            {"memory_gib", m.memory_gib},
            {"system", m.system}};
  if (m.gpu)
    json.update(Json{{"gpu", m.gpu->name},
                     {"driver", m.gpu->driver},
                     {"cuda", m.gpu->cuda},
                     {"gpu_memory_gib", rounded(m.gpu->memory_gib, 4)}});
  json.update(Json{{"compiler", m.compiler},
                   {"flags", m.flags},
                   {"commit", m.commit},
                   {"version", m.version},
                   {"load", rounded(m.load, 3)}});
  return json;
}

}  // namespace

ResultHead head_of(std::string_view format) {
  return {.format = std::string(format), .machine = describe_machine(), .command = command_line()};
}

std::string document_of(const ResultHead& head, const std::vector<Member>& members) {
  std::string text =
      "{\"format\": " + text_of(head.format) + ", \"version\": " + std::to_string(version_of_formats) +
      ",\n\"machine\": " + text_of(json_of(head.machine)) + ",\n\"command\": " + text_of(head.command) +
      ",\n\"notes\": " + text_of(Json(head.notes));
  for (const auto& [name, value] : members) text += ",\n\"" + name + "\": " + value;
  return text + "}\n";
}

std::string array_of(const std::vector<std::string>& elements) {
  std::string text = "[";
  for (const std::string& element : elements) text += (text.size() > 1 ? ",\n " : "\n ") + element;
  return text + "]";
}

}  // namespace swiftgs::cli
