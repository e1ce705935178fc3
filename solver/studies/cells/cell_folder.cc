// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/cells/cell_folder.h"

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/stored/stored_json.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

constexpr StoredFormat kSettingsFormat = {"drapefit-cells", 1}, kCellFormat = {"drapefit-cell", 1};

std::string SettingsPath(const std::string& folder) { return folder + "/settings.json"; }

// FNV-1a of 64 bits.
std::uint64_t Hash(const std::string& text) {
  constexpr std::uint64_t kBasis = 14695981039346656037ull, kPrime = 1099511628211ull;
  std::uint64_t hash = kBasis;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * kPrime;
  return hash;
}

}  // namespace

CellFolder::CellFolder(std::string folder, std::string settings)
    : folder_(std::move(folder)), settings_(std::move(settings)) {
  const std::string path = SettingsPath(folder_);
  if (!fs::exists(path)) return;
  const nlohmann::json stored = ReadStoredJson(path, kSettingsFormat);
  const std::string found = JsonInput(stored, path).At("settings").String();
  if (found != settings_)
    throw InputError(path, "found '" + found + "', expected '" + settings_ +
                               "': the cells there were made with other settings, take another "
                               "--out or undo the change");
  continues_ = true;
}

void CellFolder::Create() {
  if (continues_) return;
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) throw InputError(folder_, "cannot make the folder: " + error.message());
  WriteStoredJson(SettingsPath(folder_), kSettingsFormat, {{"settings", settings_}});
}

std::string CellFolder::Path(const std::string& cell) const {
  return folder_ + "/" + Format("%016llx", static_cast<unsigned long long>(Hash(cell))) + ".json";
}

std::optional<std::string> CellFolder::Read(const std::string& cell) const {
  const std::string path = Path(cell);
  if (!continues_ || !fs::exists(path)) return std::nullopt;
  const nlohmann::json stored = ReadStoredJson(path, kCellFormat);
  const JsonInput input(stored, path);
  if (input.At("cell").String() != cell) input.At("cell").Fail('"' + cell + '"');
  return input.At("result").String();
}

void CellFolder::Write(const std::string& cell, const std::string& result) const {
  WriteStoredJson(Path(cell), kCellFormat, {{"cell", cell}, {"result", result}});
}

}  // namespace drape
