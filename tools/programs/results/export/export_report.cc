// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/export/export_report.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "physics/util/text_format.h"
#include "tools/cli/provenance.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

std::string NumberLine(const RecordedNumber& number, bool has_posterior) {
  std::string line =
      Format("  %-10s %11.4g %-4s", number.key.c_str(), number.value, number.unit.c_str());
  if (!has_posterior || !number.sd) return line + "\n";
  line += Format(" +- %-9.3g ", *number.sd);
  line += number.measured() ? "measured" : "from the prior";
  return line + "\n";
}

std::string RoundTripText(const RoundTrip& trip) {
  if (trip.pairs == 0) return Format("none of %d starts comes to rest with both", trip.starts);
  return Format("DC %.1f -> %.1f %% (%+.1f), nodes %.1f -> %.1f", 100.0 * trip.dc_original,
                100.0 * trip.dc_exported, 100.0 * (trip.dc_exported - trip.dc_original),
                trip.nodes_original, trip.nodes_exported);
}

std::string TargetText(const ExportedTarget& exported, const std::string& folder) {
  const ExportedMaterial& material = exported.material;
  std::string text =
      Format("%-8s %s/%s, %s\n", std::string(ToString(exported.target)).c_str(), folder.c_str(),
             material.file.c_str(), material.verified ? "verified" : "unverified");
  if (exported.round_trip) text += "  here:  " + RoundTripText(*exported.round_trip) + "\n";
  for (const std::string& lost : material.lost) text += "  lost:  " + lost + "\n";
  return text + "  use:   " + material.use + "\n";
}

Json RoundTripJson(const RoundTrip& trip) {
  Json json = {{"starts", trip.starts}, {"stable_pairs", trip.pairs}};
  if (trip.pairs == 0) return json;
  json["dc_original"] = trip.dc_original;
  json["dc_exported"] = trip.dc_exported;
  json["dc_change"] = trip.dc_exported - trip.dc_original;
  json["nodes_original"] = trip.nodes_original;
  json["nodes_exported"] = trip.nodes_exported;
  json["nodes_change"] = trip.nodes_exported - trip.nodes_original;
  return json;
}

Json TargetJson(const ExportedTarget& exported) {
  const ExportedMaterial& material = exported.material;
  return {
      {"target", ToString(exported.target)},
      {"file", material.file},
      {"use", material.use},
      {"lost", material.lost},
      {"status", material.verified ? "verified" : "unverified"},
      {"evidence", material.evidence},
      {"round_trip", exported.round_trip ? RoundTripJson(*exported.round_trip) : Json(nullptr)}};
}

}  // namespace

std::string ExportText(const ExportRun& run) {
  if (run.cancelled) return "cancelled: nothing was written\n";
  const bool has_posterior = run.record.source.posterior.has_value();
  std::string text = MakePrintableLine(run.record.source.material.name) + ", linear at " +
                     (run.record.point == LinearPoint::kRest ? "zero strain and curvature\n"
                                                             : "the curvatures of its drape\n");
  for (const RecordedNumber& number : run.record.numbers) text += NumberLine(number, has_posterior);
  text += Format("  %-10s %11.4g kg/m2\n", "density", run.record.material.density);
  for (const ExportedTarget& target : run.targets) text += TargetText(target, run.out);
  for (const std::string& file : run.posterior_files)
    text += "posterior " + run.out + "/" + file + "\n";
  return text;
}

void WriteExportSummary(const std::string& path, const ExportToolOptions& options,
                        const ExportRun& run) {
  Json json = {{"tool", "drape_export"},
               {"source", run.record.source.path},
               {"record", RecordJson(run.record)},
               {"isotropic", ToString(options.target.keep)},
               {"law", ToString(options.law)},
               {"min_relative_stiffness", options.fabric.min_relative_stiffness},
               {"round_trip", {{"mesh", options.mesh}, {"starts", options.starts}}},
               {"seed", options.seed},
               {"targets", Json::array()}};
  for (const ExportedTarget& target : run.targets) json["targets"].push_back(TargetJson(target));
  json["posterior_files"] = run.posterior_files;
  if (!run.posterior_files.empty())
    json["posterior_draws"] = {{"draws", options.posterior.draws},
                               {"chains", options.posterior.chains}};
  WriteWithProvenance(path, std::move(json));
}

}  // namespace drape
