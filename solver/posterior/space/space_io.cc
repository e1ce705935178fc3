// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/space/space_io.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <vector>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"
#include "solver/posterior/posterior_io.h"

namespace drape {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr char kSpaceFormat[] = "drapefit-space";
constexpr int kSpaceVersion = 1;
constexpr double kLeastDeviation = 1e-9, kMostDeviation = 1e4;  // of a log factor of a prior

ordered_json Rows(const Eigen::MatrixXd& matrix) {
  ordered_json rows = ordered_json::array();
  for (const auto& row : matrix.rowwise()) rows.push_back(row);
  return rows;
}

std::vector<std::string> Names(const SpaceFrame& frame) {
  std::vector<std::string> names;
  for (int i = 0; i < frame.size(); ++i) names.push_back(NameFor(frame.tying, i));
  return names;
}

// Writes the convention of the tables, so that they read back to the last bit.
ordered_json BaseJson(const MaterialField& base) {
  return {{"convention", "arcsim"},
          {"density", base.density},
          {"stretch", base.stretch[0].c},
          {"bend", base.bend[0].b}};
}

ordered_json DistributionJson(const NormalDistribution& p) {
  return {{"mean", p.mean}, {"covariance", Rows(p.covariance)}};
}

ordered_json FabricsJson(const MaterialSpace& space) {
  ordered_json fabrics = ordered_json::array();
  for (std::size_t i = 0; i < space.beliefs.fabrics.size(); ++i) {
    const FabricBelief& fabric = space.beliefs.fabrics[i];
    fabrics.push_back({{"name", fabric.name},
                       {"folder", fabric.folder},
                       {"density", fabric.density},
                       {"mean", fabric.theta.mean},
                       {"sd", fabric.theta.covariance.diagonal().cwiseSqrt()},
                       {"specimen_sd", fabric.specimen_sd},
                       {"determined", DistributionJson(space.fabrics[i])}});
    if (fabric.sheet) fabrics.back()["laboratory"] = SheetJson(*fabric.sheet);
  }
  return fabrics;
}

ordered_json JudgedJson(const std::vector<JudgedMaterial>& materials) {
  ordered_json list = ordered_json::array();
  for (const JudgedMaterial& each : materials)
    list.push_back({{"name", each.name},
                    {"log_likelihood", each.log_likelihood},
                    {"p_value", each.p_value},
                    {"log_mixture", each.log_mixture},
                    {"probability_of_fabrics", each.by_fabric},
                    {"place", each.place},
                    {"determined", each.determined}});
  return list;
}

ordered_json BendingLengthsJson(const MaterialSpace& space) {
  ordered_json lengths = ordered_json::array();
  const auto add = [&](const std::vector<FabricBelief>& fabrics, bool is_new) {
    for (const FabricBelief& fabric : fabrics) {
      const NormalDistribution log_m = LogBendingLengths(space.beliefs.frame, fabric);
      lengths.push_back({{"name", fabric.name}, {"new", is_new}});
      lengths.back().update(DistributionJson(log_m));
    }
  };
  add(space.beliefs.fabrics, false);
  add(space.added_beliefs, true);
  return lengths;
}

void AddPopulation(const MaterialSpace& space, ordered_json* file) {
  ordered_json components = ordered_json::array();
  for (int k = 0; k < space.population.size(); ++k) {
    components.push_back({{"weight", space.population.weights[k]}});
    components.back().update(DistributionJson(space.population.components[k]));
  }
  (*file)["population"] = {{"directions_of_prior_units", Rows(space.leading.axes.transpose())},
                           {"ratios", space.leading.ratios},
                           {"log_likelihood_by_components", space.choice.log_likelihoods},
                           {"components", components}};
  (*file)["left_out"] = JudgedJson(space.left_out);
  (*file)["non_fabrics"] = JudgedJson(space.non_fabrics);
  (*file)["new"] = JudgedJson(space.added);
  (*file)["prior"] = DistributionJson(space.prior);
}

ordered_json SpaceJson(const MaterialSpace& space, const ordered_json& provenance) {
  const SpaceFrame& frame = space.beliefs.frame;
  ordered_json file = {{"format", kSpaceFormat},
                       {"version", kSpaceVersion},
                       {"by", ToString(frame.by)},
                       {"kind", ToString(frame.kind)},
                       {"names", Names(frame)},
                       {"base", BaseJson(frame.base)},
                       {"prior_of_fits", Rows(frame.prior_root * frame.prior_root.transpose())},
                       {"fabrics", FabricsJson(space)},
                       {"determined", {{"ratios", space.directions.ratios}}},
                       {"wasserstein", Rows(space.wasserstein)},
                       {"hellinger", Rows(space.hellinger)},
                       {"log_bending_lengths", BendingLengthsJson(space)}};
  if (space.has_population()) AddPopulation(space, &file);
  file["provenance"] = provenance;
  return file;
}

void AppendDistances(const Distances& d, std::string* line) {
  for (const double value : {d.divergence, d.reverse_divergence, d.jeffreys, d.bhattacharyya,
                             d.hellinger, d.wasserstein})
    *line += Format(",%.9g", value);
}

// A name as a field of CSV.
std::string Quoted(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? "\"\"" : std::string(1, c);
  return text + "\"";
}

std::string DistancesCsv(const MaterialSpace& space) {
  std::string csv = "first,second,level,determined_directions,share_of_prior";
  for (const char* part : {"", "all_"})
    for (const char* name : {"kl", "kl_reverse", "jeffreys", "bhattacharyya", "hellinger", "w2"})
      csv += std::string(",") + part + name;
  csv += "\n";
  const std::vector<BeliefLevel> levels = space.beliefs.frame.Levels();
  for (const PairDistances& pair : space.pairs)
    for (std::size_t level = 0; level < levels.size(); ++level) {
      csv += Quoted(space.beliefs.fabrics[pair.first].name) + "," +
             Quoted(space.beliefs.fabrics[pair.second].name) + "," +
             std::string(ToString(levels[level])) +
             Format(",%d,%.4g", pair.directions, pair.share_of_prior[level]);
      AppendDistances(pair.determined[level], &csv);
      AppendDistances(pair.all[level], &csv);
      csv += "\n";
    }
  return csv;
}

ParameterTying ReadTying(const JsonInput& names) {
  const int count = names.ExpectArray().Size();
  for (const auto& [tying, unused] : EnumNames(ParameterTying{}))
    if (TyingMatrix(tying).cols() == count) return tying;
  names.Fail("names of 1, 2, 3, 7 or 39 log factors");
}

Eigen::MatrixXd ReadMatrix(const JsonInput& input, int rows, int columns) {
  Eigen::MatrixXd matrix(rows, columns);
  input.ExpectArray(rows);
  for (int i = 0; i < rows; ++i) matrix.row(i) = input.At(i).Vector(columns);
  return matrix;
}

Eigen::MatrixXd ReadDefiniteCovariance(const JsonInput& input, int size) {
  Eigen::MatrixXd covariance = ReadMatrix(input, size, size);
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  if (!covariance.isApprox(covariance.transpose(), 1e-9) || factor.info() != Eigen::Success)
    throw InputError(input.Name(), "is no covariance, expected a positive definite matrix");
  // The deviation of each number given the numbers before it.
  const Eigen::VectorXd deviations = factor.matrixLLT().diagonal();
  if (deviations.minCoeff() < kLeastDeviation || deviations.maxCoeff() > kMostDeviation)
    throw InputError(input.Name(),
                     Format("found a standard deviation of %.3g, expected %g … %g",
                            deviations.minCoeff() < kLeastDeviation ? deviations.minCoeff()
                                                                    : deviations.maxCoeff(),
                            kLeastDeviation, kMostDeviation));
  return covariance;
}

MaterialField ReadBase(const JsonInput& input) {
  MaterialField base{.density = input.At("density").Number(), .stretch = {{}}, .bend = {{}}};
  if (base.density <= 0) input.At("density").Fail("a positive density");
  const Eigen::MatrixXd stretch = ReadMatrix(input.At("stretch"), kStretchRows, kStretchCols);
  const Eigen::MatrixXd bend = ReadMatrix(input.At("bend"), kBendRows, kBendCols);
  for (int i = 0; i < kStretchRows; ++i)
    for (int j = 0; j < kStretchCols; ++j) base.stretch[0].c[i][j] = stretch(i, j);
  for (int i = 0; i < kBendRows; ++i)
    for (int j = 0; j < kBendCols; ++j) base.bend[0].b[i][j] = bend(i, j);
  if (stretch.minCoeff() < 0 || bend.minCoeff() <= 0)
    throw InputError(input.Name(), "a stiffness is negative, expected tables of a fabric");
  return base;
}

std::string HellingerText(const MaterialSpace& space, Eigen::Index i, Eigen::Index j) {
  return std::isnan(space.hellinger(i, j)) ? "none, since they determine no direction"
                                           : Format("%.3f", space.hellinger(i, j));
}

// A p-value of n fabrics is at least 1/(n + 1): shown where it can be small.
std::string PValueText(const JudgedMaterial& material, std::size_t fabrics) {
  constexpr std::size_t kLeastFabrics = 10;
  return fabrics < kLeastFabrics ? "" : Format("   p-value %.3f", material.p_value);
}

std::string JudgedText(const char* title, const std::vector<JudgedMaterial>& materials,
                       const std::vector<FabricBelief>& fabrics) {
  std::string text = title;
  for (const JudgedMaterial& each : materials) {
    const auto likely = std::max_element(each.by_fabric.begin(), each.by_fabric.end());
    text += Format(
        "  %-24s ln p %10.2f%s   most like %s (%.2f)\n", MakePrintableLine(each.name).c_str(),
        each.log_likelihood, PValueText(each, fabrics.size()).c_str(),
        MakePrintableLine(fabrics[likely - each.by_fabric.begin()].name).c_str(), *likely);
  }
  return text;
}

}  // namespace

void WriteMaterialSpace(const std::string& folder, const MaterialSpace& space,
                        const ordered_json& provenance) {
  WriteFileAtomically(folder + "/distances.csv", DistancesCsv(space));
  WriteFileAtomically(folder + "/space.json", SpaceJson(space, provenance).dump(1) + "\n");
}

std::string MaterialSpaceText(const MaterialSpace& space) {
  const std::vector<FabricBelief>& fabrics = space.beliefs.fabrics;
  std::string text = Format("%d fabrics by %s; the data determine %d of %d directions\n",
                            static_cast<int>(fabrics.size()),
                            std::string(ToString(space.beliefs.frame.by)).c_str(), space.determined,
                            space.beliefs.frame.size());
  for (Eigen::Index i = 0; i < space.wasserstein.rows(); ++i) {
    Eigen::VectorXd row = space.wasserstein.row(i);
    row[i] = row.maxCoeff() + 1;
    Eigen::Index nearest = 0;
    const double distance = row.minCoeff(&nearest);
    text += Format("  %-24s nearest %s: W2 %.3f, Hellinger %s\n",
                   MakePrintableLine(fabrics[i].name).c_str(),
                   MakePrintableLine(fabrics[nearest].name).c_str(), distance,
                   HellingerText(space, i, nearest).c_str());
    if (fabrics[i].sheet)
      text +=
          "    " + MakePrintableLine(fabrics[i].sheet->of("bending_in_drape_un_m").Text()) + "\n";
  }
  if (!space.has_population()) return text + "no population: no direction is determined\n";
  text += Format("population: %d component(s) in %d directions\n", space.population.size(),
                 static_cast<int>(space.leading.ratios.size()));
  text += JudgedText("each fabric by the others:\n", space.left_out, fabrics);
  if (!space.non_fabrics.empty())
    text += JudgedText("materials that are no fabrics:\n", space.non_fabrics, fabrics);
  if (!space.added.empty()) text += JudgedText("new:\n", space.added, fabrics);
  return text;
}

SpacePrior ReadSpacePrior(const std::string& path) {
  const json file = ReadJsonFile(path);
  const JsonInput input(file, path);
  if (!input.Has("format") || input.At("format").value() != kSpaceFormat)
    input.Fail(std::string("a space of materials, with \"format\": \"") + kSpaceFormat + '"');
  if (input.At("version").Integer() != kSpaceVersion)
    input.At("version").Fail(std::to_string(kSpaceVersion));
  input.ExpectKeys({"format", "version", "settings", "by", "kind", "names", "base", "prior_of_fits",
                    "fabrics", "determined", "wasserstein", "hellinger", "log_bending_lengths",
                    "population", "left_out", "non_fabrics", "new", "prior", "provenance"});
  SpacePrior prior;
  if (input.At("kind").String() != ToString(prior.frame.kind))
    input.At("kind").Fail(std::string(ToString(prior.frame.kind)) + ", which has a population");
  prior.frame.by = ParseName<SpaceBy>(input.At("by").String(), input.At("by").Name());
  prior.frame.tying = ReadTying(input.At("names"));
  prior.frame.base = ReadBase(input.At("base"));
  const int size = static_cast<int>(TyingMatrix(prior.frame.tying).cols());
  prior.frame.prior_root = ReadDefiniteCovariance(input.At("prior_of_fits"), size).llt().matrixL();
  const JsonInput theta = input.At("prior");
  prior.theta = {ReadLogFactors(theta.At("mean"), size),
                 ReadDefiniteCovariance(theta.At("covariance"), size)};
  return prior;
}

}  // namespace drape
