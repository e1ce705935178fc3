// SPDX-License-Identifier: Apache-2.0
// Each reader in process, with files damaged at random and by rule.
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>

#include "physics/util/errors.h"
#include "tests/attack/classes/classes.h"
#include "tests/attack/inputs/readers/judged_reading.h"
#include "tests/attack/run/forked.h"
#include "tests/physics/util/stored/tampering.h"

namespace drape::attack {
namespace {

using nlohmann::json;

constexpr int kFewMutants = 25, kMany = 2500;  // random mutants of a reader
constexpr std::size_t kFewRules = 25;
constexpr double kMutantsSeconds = 60.0;

// The damaged files of a reader, by their number.
class Damage {
 public:
  Damage(const Reader& reader, const CampaignOptions& options)
      : reader_(reader), seed_(options.seed), random_(options.thorough ? kMany : kFewMutants) {
    if (!reader.is_json) return;
    const json document = json::parse(reader.content, nullptr, true, true);
    const std::size_t all = test::Tampering(document).size();
    const std::size_t step = options.thorough ? 1 : all / kFewRules + 1;
    const auto keep = [&](const std::string&, const json& tampered) {
      tampered_.push_back(Seal(tampered));
    };
    const test::Tampering kept(document, keep, seed_ % step, step);
  }

  int size() const { return random_ + static_cast<int>(tampered_.size()); }
  std::string Make(int i) const {
    if (i >= random_) return tampered_[static_cast<std::size_t>(i - random_)];
    std::seed_seq seeds{seed_, static_cast<uint64_t>(i)};
    std::mt19937_64 random(seeds);
    const std::string mutant = test::Mutant(reader_.content, random);
    if (!reader_.seal) return mutant;
    const json members = json::parse(mutant, nullptr, false);
    return members.is_object() ? reader_.seal(members) : mutant;
  }

 private:
  std::string Seal(const json& members) const {
    return reader_.seal && members.is_object() ? reader_.seal(members) : members.dump();
  }

  const Reader& reader_;
  uint64_t seed_;
  int random_;
  std::vector<std::string> tampered_;
};

void AttackReader(const Reader& reader, Campaign* campaign) {
  const CampaignOptions& options = campaign->options();
  const Damage damage(reader, options);
  std::string folder = options.work + "/mutants/" + reader.name;
  for (char& c : folder)
    if (c == ' ') c = '_';
  const std::string path = folder + "/" + reader.file;
  std::filesystem::create_directories(folder);
  const auto try_one = [&](int i) {
    test::WriteQuickly(path, damage.Make(i));
    return ReadDamaged(reader, path);
  };
  const auto failures = TryForked(damage.size(), kMutantsSeconds, try_one);
  campaign->CountTried("mutants", damage.size());
  for (const ForkedFailure& failure : failures) {
    const std::string kept = folder + "/" + std::to_string(failure.index) + "_" + reader.file;
    test::WriteQuickly(kept, damage.Make(failure.index));
    campaign->ReportFailure("mutants", reader.name + " " + std::to_string(failure.index),
                            failure.reasons, "attack --read='" + reader.name + "' --file=" + kept);
  }
  std::filesystem::remove(path);
}

}  // namespace

std::vector<Reader> MakeAllReaders(const CampaignOptions& options) {
  const std::string scratch = options.work + "/scratch/";
  std::filesystem::remove_all(scratch);
  std::filesystem::create_directories(scratch);
  return MakeReaders(options.work + "/valid/", scratch);
}

void AttackMutants(Campaign* campaign) {
  for (const Reader& reader : MakeAllReaders(campaign->options())) {
    std::vector<std::string> reasons;
    const std::string path = campaign->options().work + "/scratch/" + reader.file;
    test::WriteQuickly(path,
                       reader.seal ? reader.seal(json::parse(reader.content)) : reader.content);
    try {
      const std::string wrong = reader.read(path);
      if (!wrong.empty()) reasons.push_back(wrong);
    } catch (const std::exception& error) {
      reasons.push_back(std::string("the good file is refused: ") + error.what());
    }
    if (!reasons.empty()) campaign->ReportFailure("mutants", reader.name, reasons, path);
    AttackReader(reader, campaign);
  }
}

std::vector<std::string> ReadOnce(const CampaignOptions& options, const std::string& name,
                                  const std::string& path) {
  for (const Reader& reader : MakeAllReaders(options))
    if (reader.name == name) return ReadDamaged(reader, path);
  throw InputError("option 'read'", "no reader '" + name + "'");
}

}  // namespace drape::attack
