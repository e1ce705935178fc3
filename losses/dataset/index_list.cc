// SPDX-License-Identifier: Apache-2.0
#include "losses/dataset/index_list.h"

#include <charconv>
#include <set>
#include <sstream>

#include "physics/util/errors.h"

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

}  // namespace drape
