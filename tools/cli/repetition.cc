// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/repetition.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/math/sha256.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr int kMostBytes = 1 << 30;  // of a file that ReadWholeFile reads

bool IsSha256(const std::string& text) {
  return text.size() == 64 && std::all_of(text.begin(), text.end(), [](unsigned char c) {
           return std::isdigit(c) != 0 || (c >= 'a' && c <= 'f');
         });
}

InputFile ReadInputFile(const JsonInput& input) {
  input.ExpectKeys({"path", "bytes", "sha256"});
  InputFile file{input.At("path").String(),
                 static_cast<std::uintmax_t>(input.At("bytes").IntegerWithin(0, kMostBytes)),
                 input.At("sha256").String()};
  if (!IsSha256(file.sha256)) input.At("sha256").Fail("64 hexadecimal digits");
  return file;
}

// "3,210 bytes with SHA-256 12ab34cd56ef…".
std::string ContentText(const InputFile& file) {
  constexpr std::size_t kDigits = 12;
  return std::to_string(file.bytes) + " bytes with SHA-256 " + file.sha256.substr(0, kDigits) + "…";
}

}  // namespace

InputFile DescribeInput(const std::string& path, std::string_view content) {
  return {MakeUtf8(path), content.size(), Sha256(content)};
}

std::string MakeUtf8(std::string_view text) {
  std::string valid;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = Utf8Length(text, at);
    if (length == 0)
      valid += Format("\\x%02x", static_cast<unsigned char>(text[at]));
    else
      valid += text.substr(at, length);
    at += std::max<std::size_t>(length, 1);
  }
  return valid;
}

StoredRun ReadStoredRun(const JsonInput& provenance, const std::string& summary,
                        const std::string& tool) {
  const std::string program = provenance.At("program").String();
  if (program != tool) provenance.At("program").Fail("\"" + tool + "\", whose run is repeated");
  if (!provenance.Has("options"))
    throw InputError(summary, "is of a part of a run of " + program +
                                  ", expected the summary of the whole run, which has its options");
  StoredRun run;
  run.summary = summary;
  run.working_directory = provenance.At("working_directory").String();
  if (provenance.Has("build")) run.build = provenance.At("build").value().dump();
  const JsonInput inputs = provenance.At("inputs").ExpectArray();
  for (int i = 0; i < inputs.Size(); ++i) run.inputs.push_back(ReadInputFile(inputs.At(i)));
  return run;
}

void CheckInputs(const StoredRun& run) {
  for (const InputFile& expected : run.inputs) {
    const std::string origin = "is an input of the run of " + run.summary + " in " +
                               run.working_directory + ", " + ContentText(expected);
    std::string content;
    try {
      content = ReadOwnFile(expected.path);
    } catch (const std::exception& error) {
      throw InputError(error.what(), "it " + origin);
    }
    const InputFile found = DescribeInput(expected.path, content);
    if (found != expected)
      throw InputError(expected.path, origin + ", and has changed: found " + ContentText(found));
  }
}

}  // namespace drape
