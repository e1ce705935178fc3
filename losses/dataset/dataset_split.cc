// SPDX-License-Identifier: Apache-2.0
#include "losses/dataset/dataset_split.h"

#include <glog/logging.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <sstream>
#include <tuple>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/math/random.h"

namespace drape {
namespace {

constexpr int kLargest = 9999;

// One part of a list, "3" or "3-5".
class Part {
 public:
  Part(const std::string& text, const std::string& where) : text_(text), where_(where) {}

  void AddTo(std::set<int>* numbers) const {
    const size_t dash = text_.find('-');
    const int first = Number(text_.substr(0, dash));
    const int last = dash == std::string::npos ? first : Number(text_.substr(dash + 1));
    if (last < first) Fail("an ascending range");
    for (int number = first; number <= last; ++number) numbers->insert(number);
  }

 private:
  int Number(const std::string& digits) const {
    int number = 0;
    const char* end = digits.data() + digits.size();
    const auto [stop, error] = std::from_chars(digits.data(), end, number);
    if (error != std::errc() || stop != end || number < 1 || number > kLargest)
      Fail("whole numbers from 1 to 9999 and ranges like 3-5, with commas between them");
    return number;
  }

  [[noreturn]] void Fail(const std::string& expected) const {
    throw InputError(where_, "found '" + text_ + "', expected " + expected);
  }

  const std::string& text_;
  const std::string& where_;
};

constexpr char kSplitFormat[] = "drapefit-split";

using Sample = std::pair<int, int>;  // fabric, sample
Sample MakeSample(const Capture& capture) { return {capture.fabric, capture.sample}; }

// Returns the first `count` items of a random order (shuffle of Fisher and Yates).
std::vector<int> SelectRandomly(std::vector<int> items, int count, std::mt19937_64& random) {
  for (int i = 0; i < count; ++i) {
    const double left = static_cast<double>(items.size()) - i;
    std::swap(items[i], items[i + static_cast<size_t>(left * SampleUniform(random))]);
  }
  items.resize(count);
  return items;
}

nlohmann::ordered_json SideJson(const std::vector<Capture>& captures) {
  auto side = nlohmann::ordered_json::array();
  for (const Capture& c : captures) side.push_back({c.fabric, c.sample, c.capture});
  return side;
}

std::vector<Capture> ReadSide(const JsonInput& side, const Dataset& dataset) {
  std::vector<Capture> captures;
  side.ExpectArray();
  for (int i = 0; i < side.Size(); ++i) {
    const JsonInput entry = side.At(i);
    entry.ExpectArray(3);
    const auto wanted =
        std::tuple(entry.At(0).Integer(), entry.At(1).Integer(), entry.At(2).Integer());
    const auto found = std::find_if(
        dataset.captures.begin(), dataset.captures.end(),
        [&](const Capture& c) { return std::tuple(c.fabric, c.sample, c.capture) == wanted; });
    if (found == dataset.captures.end())
      throw InputError(entry.Name(), "the data set lacks this fabric, sample, capture");
    captures.push_back(*found);
  }
  return captures;
}

void CheckDisjoint(const Split& split, const std::string& path) {
  std::set<Sample> train;
  for (const Capture& capture : split.train) train.insert(MakeSample(capture));
  for (const Capture& capture : split.held_out) {
    if (train.contains(MakeSample(capture)))
      throw InputError(path, "the sample of " + capture.Name() + " is on both sides");
  }
}

}  // namespace

std::vector<int> ParseIndexList(const std::string& text, const std::string& where) {
  std::set<int> numbers;
  for (size_t begin = 0; !text.empty();) {
    const size_t comma = text.find(',', begin);
    Part(text.substr(begin, comma - begin), where).AddTo(&numbers);
    if (comma == std::string::npos) break;
    begin = comma + 1;
  }
  return {numbers.begin(), numbers.end()};
}

std::string IndexListText(const std::vector<int>& numbers) {
  std::ostringstream text;
  for (size_t i = 0; i < numbers.size();) {
    size_t last = i;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    text << (i == 0 ? "" : ",") << numbers[i];
    if (last > i) text << '-' << numbers[last];
    i = last + 1;
  }
  return text.str();
}

Split SplitBySample(const std::vector<Capture>& captures, int train_samples, uint64_t seed) {
  CHECK_GE(train_samples, 1);
  std::map<int, std::set<int>> samples;  // of each fabric
  for (const Capture& capture : captures) samples[capture.fabric].insert(capture.sample);
  std::mt19937_64 random(seed);
  std::set<Sample> train;
  for (const auto& [fabric, all] : samples) {
    if (static_cast<int>(all.size()) <= train_samples) {
      throw InputError("train", "found " + std::to_string(train_samples) +
                                    " training samples, expected fewer than the " +
                                    std::to_string(all.size()) + " of fabric " +
                                    std::to_string(fabric));
    }
    for (const int sample : SelectRandomly({all.begin(), all.end()}, train_samples, random))
      train.insert({fabric, sample});
  }
  Split split{seed, {}, {}};
  for (const Capture& capture : captures)
    (train.contains(MakeSample(capture)) ? split.train : split.held_out).push_back(capture);
  return split;
}

void WriteSplit(const std::string& path, const Split& split) {
  const nlohmann::ordered_json json = {{"format", kSplitFormat},
                                       {"seed", split.seed},
                                       {"train", SideJson(split.train)},
                                       {"held_out", SideJson(split.held_out)}};
  WriteFileAtomically(path, json.dump() + "\n");
}

Split ReadSplit(const std::string& path, const Dataset& dataset) {
  const nlohmann::json json = ReadJsonFile(path);
  const JsonInput input(json, path);
  input.ExpectKeys({"format", "seed", "train", "held_out"});
  if (input.At("format").String() != kSplitFormat) input.At("format").Fail(kSplitFormat);
  if (!input.At("seed").value().is_number_unsigned())
    input.At("seed").Fail("a whole number that is not negative");
  Split split{input.At("seed").value().get<uint64_t>(), ReadSide(input.At("train"), dataset),
              ReadSide(input.At("held_out"), dataset)};
  CheckDisjoint(split, path);
  return split;
}

}  // namespace drape
