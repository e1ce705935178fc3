// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/run/judge.h"

#include <signal.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace drape::attack {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestMessage = 440;  // characters, without a list of what is allowed
constexpr std::size_t kMostRead = 4 << 20;    // bytes of a file that are looked at

std::string ReadStart(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string text;
  char buffer[4096];
  while (text.size() < kMostRead && (in.read(buffer, sizeof buffer), in.gcount() > 0))
    text.append(buffer, static_cast<std::size_t>(in.gcount()));
  return text;
}

// The length of the UTF-8 character at `at`, 0 where there is none.
std::size_t CharacterLength(const std::string& text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(at);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xf5   ? 0
                             : first >= 0xf0 ? 4
                             : first >= 0xe0 ? 3
                             : first >= 0xc2 ? 2
                                             : 0;
  if (length == 0 || at + length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(at + i) & 0xc0) != 0x80) return 0;
  return length;
}

// Control bytes, those of C1 in UTF-8 among them, and bytes that are no UTF-8.
bool IsHostileAt(const std::string& text, std::size_t at, std::size_t length) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (length == 0) return true;
  // A terminal only moves to the right for a tab.
  if (length == 1) return (byte(at) < 0x20 && text[at] != '\t') || byte(at) == 0x7f;
  return length == 2 && byte(at) == 0xc2 && byte(at + 1) < 0xa0;
}

// nan, inf or infinity as a word of its own: "info", "nano" and "inf.json" are none.
bool HoldsNoNumber(const std::string& text) {
  const auto in_word = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || std::strchr("_./#", c) != nullptr;
  };
  for (std::size_t i = 0; i < text.size();) {
    std::size_t end = i;
    while (end < text.size() && in_word(text[end])) ++end;
    if (end == i + 3 || end == i + 8) {
      std::string word = text.substr(i, end - i);
      for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      if (word == "nan" || word == "inf" || word == "infinity") return true;
    }
    i = end + 1;
  }
  return false;
}

bool IsLeftover(const std::string& path) {
  if (path.rfind("tmp/", 0) == 0 || path.rfind("home/", 0) == 0) return true;
  const std::string name = fs::path(path).filename().string();
  return name.rfind(".drapefit", 0) == 0 || name.find(".tmp") != std::string::npos;
}

bool HoldsNumbers(const std::string& path) {
  const std::string kind = fs::path(path).extension().string();
  return kind == ".json" || kind == ".csv" || kind == ".obj" || kind == ".md";
}

// One run and what it left.
class Judgement {
 public:
  Judgement(const Request& request, const Outcome& outcome, const Expectation& expectation,
            const FolderState& before, const FolderState& after)
      : request_(request),
        outcome_(outcome),
        expectation_(expectation),
        before_(before),
        after_(after) {}

  std::vector<std::string> Reasons() {
    JudgeEnd();
    JudgeFiles();
    if (outcome_.exit_code == 2) JudgeError();
    if (outcome_.exit_code != 2 && expectation_.prints_numbers) JudgeNumbers();
    return reasons_;
  }

 private:
  void Add(const std::string& reason) { reasons_.push_back(reason); }

  bool MayEndWith(int code) const {
    const std::string name = fs::path(request_.command.front()).filename().string();
    const bool is_check = name == "drape_check";
    constexpr int kNotLoaded = 127;  // of the system's loader, without memory
    return code == 0 || code == 2 || code == 3 || code == 130 || (code == 1 && is_check) ||
           (code == kNotLoaded && expectation_.may_be_killed);
  }

  void JudgeEnd() {
    if (outcome_.hung) return Add("did not end after SIGINT");
    if (outcome_.signal != 0) {
      if (!expectation_.may_be_killed)
        Add(std::string("was ended by ") + strsignal(outcome_.signal));
    } else if (!MayEndWith(outcome_.exit_code)) {
      Add("ended with exit code " + std::to_string(outcome_.exit_code));
    }
    const bool refused = outcome_.exit_code == 2;
    if (expectation_.verdict == Verdict::kRefused && !refused)
      Add("took a bad input, exit code " + std::to_string(outcome_.exit_code));
    if (expectation_.verdict == Verdict::kTaken && refused) Add("refused a good input");
    // What ends a child when its parent is killed may take a moment.
    const bool killed = expectation_.may_be_killed && outcome_.signal == SIGKILL;
    if (outcome_.left_process && !killed) Add("left a process behind");
  }

  bool IsResult(const std::string& path) const {
    const std::vector<std::string>& results = expectation_.results;
    return std::any_of(results.begin(), results.end(), [&](const std::string& result) {
      // The folders above it are made with it.
      return result == "." || path == result || path.rfind(result + "/", 0) == 0 ||
             result.rfind(path + "/", 0) == 0;
    });
  }

  void JudgeFiles() {
    const bool killed = expectation_.may_be_killed && outcome_.signal == SIGKILL;
    for (const auto& [path, content] : after_) {
      const auto old = before_.find(path);
      const bool is_new = old == before_.end();
      if (fs::path(path).filename().string().rfind(kPlanted, 0) == 0)
        Add("a planted command made " + Visible(path));
      if (is_new && !killed && IsLeftover(path)) Add("left " + Visible(path));
      const bool in_out = IsResult(path);
      const bool changed = is_new || old->second != content;
      if (changed && !in_out && !IsLeftover(path)) Add("changed " + Visible(path));
      if (changed && in_out && outcome_.exit_code == 2 && expectation_.keeps_results)
        Add("was refused, but changed " + Visible(path));
    }
    for (const auto& [path, content] : before_)
      if (!after_.contains(path) && (outcome_.exit_code == 2 || !IsResult(path)))
        Add("lost " + Visible(path));
  }

  void JudgeError() {
    if (request_.err != Stream::kFile) return;
    std::string text = outcome_.err;
    // Notes on unusual values precede the error.
    for (std::size_t end; text.starts_with("note: ") && (end = text.find('\n')) != text.npos;)
      text.erase(0, end + 1);
    const auto lines = std::count(text.begin(), text.end(), '\n');
    if (lines != 1 || text.back() != '\n')
      return Add("was refused with " + std::to_string(lines) + " lines on stderr");
    text.pop_back();
    for (const std::string& reason : JudgeMessage(text, expectation_.named)) Add(reason);
  }

  // Ignores what the command itself says, which a program may repeat.
  bool HoldsNewNoNumber(std::string text) const {
    for (const std::string& argument : request_.command) {
      const std::string value = argument.substr(argument.find('=') + 1);
      if (!HoldsNoNumber(value)) continue;
      for (std::size_t at; (at = text.find(value)) != text.npos;) text.erase(at, value.size());
    }
    return HoldsNoNumber(text);
  }

  void JudgeNumbers() {
    if (HoldsNewNoNumber(outcome_.out)) Add("printed nan or inf on stdout");
    if (HoldsNewNoNumber(outcome_.err)) Add("printed nan or inf on stderr");
    for (const auto& [path, content] : after_) {
      const auto old = before_.find(path);
      if (old != before_.end() && old->second == content) continue;
      if (HoldsNumbers(path) && HoldsNewNoNumber(content))
        Add("wrote nan or inf to " + Visible(path));
    }
  }

  const Request& request_;
  const Outcome& outcome_;
  const Expectation& expectation_;
  const FolderState &before_, &after_;
  std::vector<std::string> reasons_;
};

std::size_t CountCharacters(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
  }));
}

bool HoldsHostileBytes(const std::string& text) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = CharacterLength(text, i);
    if (IsHostileAt(text, i, length)) return true;
    i += length;
  }
  return false;
}

}  // namespace

FolderState ReadFolder(const std::string& folder) {
  FolderState state;
  std::error_code ignored;
  for (fs::recursive_directory_iterator entry(folder, ignored), end; entry != end;
       entry.increment(ignored)) {
    const std::string path = fs::path(entry->path()).lexically_relative(folder).string();
    if (entry->is_symlink(ignored)) {
      state[path] = "link " + fs::read_symlink(entry->path(), ignored).string();
    } else if (entry->is_directory(ignored)) {
      state[path] = "folder";
    } else if (entry->is_regular_file(ignored)) {
      state[path] = "file " + ReadStart(entry->path());
    } else {
      state[path] = "other";
    }
  }
  return state;
}

std::vector<std::string> JudgeRun(const Request& request, const Outcome& outcome,
                                  const Expectation& expectation, const FolderState& before,
                                  const FolderState& after) {
  return Judgement(request, outcome, expectation, before, after).Reasons();
}

std::vector<std::string> JudgeMessage(const std::string& text,
                                      const std::vector<std::string>& named) {
  std::vector<std::string> reasons;
  if (text.find('\n') != std::string::npos) reasons.push_back("the error has several lines");
  if (HoldsHostileBytes(text)) reasons.push_back("the error echoes control bytes");
  std::size_t length = CountCharacters(text);
  for (const char* list : {", allowed:", "expected one of ", "expected some of "})
    if (const auto at = text.find(list); at != std::string::npos)
      length = std::min(length, CountCharacters(text.substr(0, at)));
  if (length > kLongestMessage)
    reasons.push_back("the error has " + std::to_string(length) + " characters");
  const bool names = std::any_of(named.begin(), named.end(), [&](const std::string& name) {
    return text.find(name) != std::string::npos;
  });
  if (!names && !named.empty())
    reasons.push_back("the error does not name " + Visible(named.front(), 60));
  if (text.find("exception") != std::string::npos)
    reasons.push_back("the error shows the exception of a library");
  return reasons;
}

std::string Visible(const std::string& text, std::size_t longest) {
  std::string visible;
  for (std::size_t i = 0; i < text.size() && visible.size() < longest;) {
    const std::size_t length = CharacterLength(text, i);
    if (IsHostileAt(text, i, length)) {
      char octal[5];
      std::snprintf(octal, sizeof octal, "\\%03o", static_cast<unsigned char>(text[i]));
      visible += octal;
      ++i;
    } else {
      visible += text.substr(i, length);
      i += length;
    }
  }
  return visible.size() < longest ? visible : visible + "…";
}

}  // namespace drape::attack
