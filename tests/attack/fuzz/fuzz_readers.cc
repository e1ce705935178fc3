// SPDX-License-Identifier: Apache-2.0
// One libFuzzer target for each reader of inputs/readers, chosen by --reader=NAME: reads the bytes
// as its file and stops at what ReadDamaged finds. tests/attack/fuzz/run builds and calls it.
//   fuzz_readers --list               the names of the readers
//   fuzz_readers --seeds=FOLDER       writes the seeds of each reader to a folder of its name
//   fuzz_readers --reader=NAME [options of libFuzzer] [corpus ...]
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "physics/util/text_format.h"
#include "tests/attack/fuzz/json_mutator.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/pictures.h"
#include "tests/attack/inputs/readers/judged_reading.h"
#include "tests/attack/inputs/valid_inputs.h"
#include "tests/attack/run/judge.h"
#include "tests/physics/util/stored/tampering.h"

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

namespace drape::attack {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kLongestSeed = 1 << 16;

// What this process fuzzes.
struct Target {
  std::string work;  // a temporary folder
  Reader reader;
  std::string path;  // of the reader's file
};
Target target;

// The folder of a reader: its name without blanks.
std::string FolderName(std::string name) {
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

// The valid file of a reader, what this repository has of its kind, and what the attack finds bad.
class Seeds {
 public:
  explicit Seeds(const std::string& valid)
      : bad_files_(MakeFileReaders(valid)), bad_pictures_(MakeDamagedPictures()) {}

  std::vector<std::string> Of(const Reader& reader) const {
    static const std::map<std::string, std::string> kShipped = {
        {"material", "fabrics"},   {"published", "published"}, {"scene", "scenes"},
        {"contact", "scenes"},     {"start", "starts"},        {"garment", "garments"},
        {"lab test", "lab_tests"}, {"fit config", "programs"}, {"config", "programs"}};
    std::vector<std::string> seeds = {reader.content};
    if (const auto shipped = kShipped.find(reader.name); shipped != kShipped.end())
      for (const auto& file :
           fs::directory_iterator(std::string(DRAPE_SOURCE_DIR "/configs/") + shipped->second))
        if (file.is_regular_file()) seeds.push_back(ReadText(file.path()));
    for (const FileReader& bad : bad_files_)
      if (bad.name == reader.name || (bad.name == "mesh" && reader.name == "obj"))
        for (const BadFile& file : bad.bad) seeds.push_back(file.content);
    for (const BadPicture& picture : bad_pictures_)
      if (fs::path(picture.file).extension() == fs::path(reader.file).extension())
        seeds.push_back(picture.content);
    std::erase_if(seeds, [](const std::string& seed) { return seed.size() > kLongestSeed; });
    return seeds;
  }

 private:
  std::vector<FileReader> bad_files_;
  std::vector<BadPicture> bad_pictures_;
};

void WriteSeeds(const std::vector<Reader>& readers, const std::string& valid,
                const std::string& folder) {
  const Seeds seeds(valid);
  for (const Reader& reader : readers) {
    const std::string own = folder + "/" + FolderName(reader.name);
    fs::create_directories(own);
    int number = 0;
    for (const std::string& seed : seeds.Of(reader))
      test::WriteQuickly(own + Format("/seed_%03d", number++), seed);
  }
}

std::string FlagValue(int argc, char** argv, const std::string& name) {
  const std::string start = "--" + name + "=";
  for (int i = 1; i < argc; ++i)
    if (std::string(argv[i]).rfind(start, 0) == 0) return argv[i] + start.size();
  return {};
}

[[noreturn]] void Quit(int code) {
  fs::remove_all(target.work);
  std::exit(code);
}

void Initialize(int argc, char** argv) {
  std::string pattern = (fs::temp_directory_path() / "fuzz_XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) {
    std::fprintf(stderr, "fuzz_readers: error: %s: cannot be made\n", pattern.c_str());
    std::exit(2);
  }
  target.work = pattern;
  std::atexit([] { fs::remove_all(target.work); });
  MakeValidInputs(target.work, DRAPE_SOURCE_DIR);
  const std::string valid = target.work + "/valid/", scratch = target.work + "/scratch/";
  fs::create_directories(scratch);
  const std::vector<Reader> readers = MakeReaders(valid, scratch);
  if (argc == 2 && std::string(argv[1]) == "--list") {
    for (const Reader& reader : readers) std::printf("%s\n", FolderName(reader.name).c_str());
    Quit(0);
  }
  if (const std::string folder = FlagValue(argc, argv, "seeds"); !folder.empty()) {
    WriteSeeds(readers, valid, folder);
    Quit(0);
  }
  const std::string wanted = FlagValue(argc, argv, "reader");
  const auto found = std::find_if(readers.begin(), readers.end(), [&](const Reader& reader) {
    return FolderName(reader.name) == wanted;
  });
  if (found == readers.end()) {
    std::fprintf(stderr,
                 "fuzz_readers: error: option 'reader': no reader '%s', expected one of "
                 "--list\n",
                 wanted.c_str());
    Quit(2);
  }
  target.reader = *found;
  fs::create_directories(target.work + "/in");
  target.path = target.work + "/in/" + target.reader.file;
}

// The file of a document without its checksum.
std::string Sealed(const std::string& text) {
  if (!target.reader.seal) return text;
  const json members = json::parse(text, nullptr, false);
  return members.is_object() ? target.reader.seal(members) : text;
}

bool IsJson(const Reader& reader) { return reader.is_json || reader.seal; }

}  // namespace
}  // namespace drape::attack

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  drape::attack::Initialize(*argc, *argv);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace drape;
  using attack::target;
  const std::string text(reinterpret_cast<const char*>(data), size);
  // JudgeMessage refuses the word, which a message that quotes the file would show, also behind an
  // escape that ends in its first letter.
  if (text.find("xception") != std::string::npos) return 0;
  test::WriteQuickly(target.path, attack::Sealed(text));
  const std::vector<std::string> reasons = attack::ReadDamaged(target.reader, target.path);
  for (const std::string& reason : reasons)
    std::fprintf(stderr, "%s: %s\n", target.reader.name.c_str(), attack::Visible(reason).c_str());
  if (!reasons.empty()) std::abort();
  return 0;
}

// Half of the changes of JSON are of values, so that most documents stay well-formed.
extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned int seed) {
  using nlohmann::json;
  std::mt19937 random(seed);
  if (drape::attack::IsJson(drape::attack::target.reader) && random() % 2 == 0) {
    json document = json::parse(data, data + size, nullptr, false, true);
    if (!document.is_discarded()) {
      drape::attack::MutateJson(&document, random);
      const std::string text = document.dump(-1, ' ', false, json::error_handler_t::replace);
      if (text.size() <= max_size) {
        std::copy(text.begin(), text.end(), data);
        return text.size();
      }
    }
  }
  return LLVMFuzzerMutate(data, size, max_size);
}
