// SPDX-License-Identifier: Apache-2.0
// What drape_space reads: posteriors of several fabrics, the space as a prior, and what it stores
// beside fits of a data set.
#include <filesystem>

#include "physics/util/atomic_file.h"
#include "solver/posterior/space/space_io.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/readers/readers.h"

namespace drape::attack {
namespace {

namespace fs = std::filesystem;

bool IsFinite(const NormalDistribution& distribution) {
  return distribution.mean.allFinite() && distribution.covariance.allFinite();
}

// The space of a folder and three good ones.
std::string BuildSpace(const std::string& valid, const std::string& folder) {
  FabricBeliefs beliefs = ReadFabricBeliefs(
      {folder, valid + "posterior", valid + "posterior_2", valid + "posterior_3"}, SpaceBy::kDrape);
  const MaterialSpace space = BuildMaterialSpace(std::move(beliefs), {});
  // A pair without a determined direction has no Hellinger metric.
  if (!space.wasserstein.allFinite() || space.hellinger.array().isInf().any())
    return "made distances that are not finite";
  return space.has_population() && !IsFinite(space.prior) ? "made a prior that is not finite" : "";
}

// posterior.json or base.json in the folder of the mutant; the other one is put beside it.
Reader MakeBeliefReader(const std::string& valid, const std::string& file,
                        const std::string& beside) {
  return {.name = "space of " + file,
          .file = file,
          .content = ReadText(valid + "posterior_4/" + file),
          .read = [=](const std::string& path) {
            const std::string folder = fs::path(path).parent_path();
            if (!fs::exists(folder + "/" + beside))
              WriteFileAtomically(folder + "/" + beside, ReadText(valid + "posterior_4/" + beside));
            return BuildSpace(valid, folder);
          }};
}

Reader MakePriorReader(const std::string& valid) {
  return {.name = "space as a prior",
          .file = "space.json",
          .content = ReadText(valid + "space.json"),
          .read =
              [](const std::string& path) {
                const SpacePrior prior = ReadSpacePrior(path);
                const Eigen::VectorXd z = prior.frame.ToPriorUnits(prior.theta).mean;
                return IsFinite(prior.theta) && z.allFinite() ? ""
                                                              : "read a prior that is not finite";
              },
          .impossible = {{"/prior/covariance/0/0", "-1"},
                         {"/prior/covariance/0/0", "1e12"},
                         {"/prior/covariance/0/1", "5"},
                         {"/prior/mean/0", "1e9"},
                         {"/prior_of_fits/0/0", "0"},
                         {"/base/density", "-1"}}};
}

}  // namespace

std::vector<Reader> MakeSpaceReaders(const std::string& valid) {
  return {MakeBeliefReader(valid, "posterior.json", "base.json"),
          MakeBeliefReader(valid, "base.json", "posterior.json"), MakePriorReader(valid)};
}

}  // namespace drape::attack
