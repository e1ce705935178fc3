// SPDX-License-Identifier: Apache-2.0
#include "physics/util/stored/stored_json.h"

#include <zlib.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

using nlohmann::json;

std::string Checksum(const std::string& text) {
  const auto* bytes = reinterpret_cast<const Bytef*>(text.data());
  return Format("%08lx", crc32_z(0, bytes, text.size()));
}

}  // namespace

std::string StoredJsonText(const StoredFormat& format, const json& members) {
  const std::string text = members.dump();
  const json head = {
      {"format", format.name}, {"version", format.version}, {"checksum", Checksum(text)}};
  std::string file = head.dump();
  file.back() = members.empty() ? ' ' : ',';
  return file.append(text, 1) + "\n";
}

json ParseStoredJson(const std::string& text, const std::string& where,
                     const StoredFormat& format) {
  json file = ParseJson(text, where);
  const JsonInput input(file, where);
  if (input.At("format").String() != format.name)
    input.At("format").Fail('"' + std::string(format.name) + '"');
  if (!input.Has("version") || input.At("version").value() != format.version)
    throw InputError(where, "is of another version of the program, expected version " +
                                std::to_string(format.version) + " of " + format.name);
  const std::string stored = input.At("checksum").String();
  for (const char* key : {"format", "version", "checksum"}) file.erase(key);
  if (Checksum(file.dump()) != stored)
    throw InputError(where, "is damaged or was altered: its content does not have the checksum " +
                                json(stored).dump());
  return file;
}

void CheckStored(const std::string& path, const StoredFormat& format) {
  const std::string name = Format("\"%s\"", format.name);
  std::error_code ignored;
  if (std::filesystem::is_regular_file(path, ignored) &&
      ReadOwnFile(path).find(name) == std::string::npos)
    throw InputError(path, "is no file of the format " + name +
                               ", expected one or no file of "
                               "this name: choose another folder");
}

void WriteStoredJson(const std::string& path, const StoredFormat& format, const json& members) {
  WriteFileAtomically(path, StoredJsonText(format, members));
}

json ReadStoredJson(const std::string& path, const StoredFormat& format) {
  return ParseStoredJson(ReadOwnFile(path), path, format);
}

}  // namespace drape
