// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "losses/camera/camera.h"
#include "physics/material/laws/law_kind.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/forward/random_drapes.h"
#include "solver/prediction/exchange/exchange_record.h"
#include "solver/prediction/exchange/targets/export_material.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

// The options of drape_export.
struct ExportToolOptions {
  FabricInput fabric;
  std::vector<std::string> to;  // names of ExportTarget, "all", "csv"
  LinearPoint point = LinearPoint::kDrape;
  ExportOptions target;
  double thickness = 0.0;  // [m]; 0: not known
  LawKind law = LawKind::kSmooth;
  double edge = 0.01;               // of the target's mesh [m]; 0: rigidities as they are
  std::string mesh = "disc:600";    // of the fabric's own drapes
  DiscsInput discs;                 // of the round trip; not given: those of the fit
  int starts = 3;                   // of the round trip; 0: none
  int seed = 1;                     // of the first start and of the samples of a posterior
  PosteriorTableOptions posterior;  // of "csv"; its seed is `seed`
  int threads = 0;
  std::string out;
};

// The change of drapes when a fabric is replaced by the part of it that another program takes. Both
// are draped here from the same random starts.
struct RoundTrip {
  int starts = 0;  // of each fabric
  int pairs = 0;   // with a stable drape of both
  // Means over the pairs.
  double dc_original = 0.0, dc_exported = 0.0;        // drape coefficient, 0 … 1
  double nodes_original = 0.0, nodes_exported = 0.0;  // number of folds
};

struct ExportedTarget {
  ExportTarget target;
  ExportedMaterial material;
  double bend_factor = 1.0;
  std::optional<RoundTrip> round_trip = {};  // by the hinges of the target where it has some
  std::optional<RoundTrip> unfitted = {};    // the same without bend_factor
};
struct ExportRun {
  std::string out;
  double edge = 0.0;  // ExportToolOptions
  ExchangeRecord record;
  std::vector<ExportedTarget> targets;
  std::vector<std::string> posterior_files;
  bool cancelled = false;  // then no file is written
};

std::vector<Option> LinearOptions(ExportToolOptions& options) {
  return {EnumOption("linear_at", options.point,
                     "where the rigidities hold: drape: they have the bending energy of the "
                     "fabric's own drape; rest: at zero curvature"),
          NumberOption("edge", &options.edge, 0, 0.05,
                       "edge length of the mesh in the target: a target that bends at hinges gets "
                       "the rigidities with which such a mesh drapes like the fabric; 0: the "
                       "fabric's own",
                       "m"),
          EnumOption("faces", options.target.faces, "faces of that mesh (blender)"),
          EnumOption("isotropic", options.target.keep,
                     "what an isotropic membrane (newton) is given: the nearest sheet, or exact "
                     "shear, or exact stretch and c12"),
          Usual(NumberOption("thickness", &options.thickness, 0, 0.1,
                             "of the fabric, which some targets need; 0: not known", "m"),
                5e-5, 0.01),
          EnumOption("law", options.law, "how stiffness follows from strain and curvature")};
}

std::vector<Option> RoundTripOptions(ExportToolOptions& options) {
  std::vector<Option> list = {
      MeshOption("mesh", &options.mesh, "disc on which original and export are draped here"),
      NumberOption("starts", &options.starts, 0, 100,
                   "number of random starts of these drapes; 0: none"),
      NumberOption("seed", &options.seed, 0, 1000000000,
                   "random seed of the first start, and of the samples of a posterior"),
      ThreadsOption(options.threads)};
  return Concatenate(list, FieldOptionList(options.discs));
}

constexpr char kCsv[] = "csv";

bool Asks(const std::vector<std::string>& names, const char* name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<ExportTarget> ParseTargets(const std::vector<std::string>& names) {
  std::vector<ExportTarget> targets;
  if (Asks(names, "all")) targets.assign(std::begin(kExportTargets), std::end(kExportTargets));
  for (const std::string& name : names) {
    if (name == "all" || name == kCsv) continue;
    const auto target = ParseName<ExportTarget>(name, "option 'to'");
    if (std::find(targets.begin(), targets.end(), target) == targets.end())
      targets.push_back(target);
  }
  return targets;
}

std::vector<Option> SampleOptions(PosteriorTableOptions& posterior) {
  return {
      NumberOption(
          "draws", &posterior.draws, 0, 1000000,
          "csv: number of new samples, a multiple of chains; 0: the samples whose drapes the "
          "fit has computed, with their log-likelihood"),
      NumberOption("chains", &posterior.chains, 1, 1000,
                   "csv: chains that the samples are divided among, for readers that want several; "
                   "they are independent")};
}

// A disc of triangles with edges of about that length.
std::string DiscOfEdge(const DrapeDiscs& discs, double edge) {
  constexpr int kLeast = 100, kMost = 10000;  // vertices; the most take minutes
  const double area = M_PI * discs.specimen * discs.specimen;
  const auto edge_of = [&](int vertices) { return std::sqrt(area / (std::sqrt(0.75) * vertices)); };
  const auto vertices = static_cast<int>(std::lround(std::pow(edge_of(1) / edge, 2)));
  if (vertices < kLeast || vertices > kMost)
    throw InputError("option 'edge'",
                     Format("found %g m, expected 0 or %.2g to %.2g m on this disc", edge,
                            edge_of(kMost), edge_of(kLeast)));
  return "disc:" + std::to_string(vertices);
}

// Drapes on one model.
class Drapes {
 public:
  // Drapes of the fabric.
  Drapes(const ExportToolOptions& options, const RunControl& control)
      : Drapes(options, options.mesh, options.law, control) {}
  // Drapes as a target that bends at hinges has them: Blender gives all vertices one mass.
  Drapes(const ExportToolOptions& options, ExportTarget target, const RunControl& control)
      : Drapes(options, DiscOfEdge(FindFabricDiscs(options), options.edge), LawKind::kReference,
               control) {
    if (target == ExportTarget::kBlender)
      model_->vertex_area.setConstant(model_->vertex_area.mean());
  }

  std::vector<DrapeSample> Sample(const MaterialField& tables) const {
    return SampleEquilibria(*backend_, tables,
                            {.samples = std::max(1, options_.starts),
                             .first_seed = options_.seed,
                             .threads = backend_->threads(),
                             .discs = discs_},
                            {.cancel = control_.cancel, .progress = {}});
  }
  // Throws InputError when no drape is at rest.
  Eigen::VectorXd Weights(const std::vector<DrapeSample>& drapes) const {
    std::vector<Eigen::VectorXd> shapes;
    for (const DrapeSample& drape : drapes)
      if (drape.at_rest && drape.stable) shapes.push_back(drape.x);
    if (shapes.empty())
      throw InputError("option 'linear_at'",
                       "found drape, but no drape of the fabric comes to rest, expected rest");
    return StiffnessWeights(*model_, shapes);
  }

 private:
  static DrapeDiscs FindFabricDiscs(const ExportToolOptions& options) {
    return FindDiscs(options.discs, {options.fabric.path + "/summary.json"});
  }
  Drapes(const ExportToolOptions& options, const std::string& mesh, LawKind law,
         const RunControl& control)
      : options_(options),
        discs_(FindFabricDiscs(options)),
        model_(std::make_shared<ClothModel>(ParseMeshSpec(mesh, {}, discs_),
                                            CusickScene({}, discs_.support), MakeLaw(law))),
        backend_(MakeLoggedBackend("cpu", model_, CountThreads(options.threads), control)),
        control_(control) {}

  const ExportToolOptions& options_;
  DrapeDiscs discs_;
  std::shared_ptr<ClothModel> model_;
  std::unique_ptr<Backend> backend_;
  RunControl control_;
};

// The drapes of both lists are of SampleEquilibria with the same options.
RoundTrip CompareRoundTrip(const std::vector<DrapeSample>& original,
                           const std::vector<DrapeSample>& exported) {
  CHECK_EQ(original.size(), exported.size());
  RoundTrip trip;
  trip.starts = static_cast<int>(original.size());
  for (size_t i = 0; i < original.size(); ++i) {
    const DrapeSample &a = original[i], &b = exported[i];
    if (!a.at_rest || !a.stable || !b.at_rest || !b.stable) continue;
    ++trip.pairs;
    trip.dc_original += a.signature.drape_coefficient;
    trip.dc_exported += b.signature.drape_coefficient;
    trip.nodes_original += a.signature.folds;
    trip.nodes_exported += b.signature.folds;
  }
  if (trip.pairs == 0) return trip;
  for (double* sum :
       {&trip.dc_original, &trip.dc_exported, &trip.nodes_original, &trip.nodes_exported})
    *sum /= trip.pairs;
  return trip;
}

bool SameTables(const MaterialField& a, const MaterialField& b) {
  return a.density == b.density &&
         std::equal(a.stretch[0].entries(), a.stretch[0].entries() + kStretchEntries,
                    b.stretch[0].entries()) &&
         std::equal(a.bend[0].entries(), a.bend[0].entries() + kBendEntries, b.bend[0].entries());
}

// The factor on rigidities with which the hinges of a target drape like the fabric: by a line
// through the drape coefficients at several factors over their logarithms, since branches scatter
// each. Those near the fabric's count most.
void FitToHinges(const ExportToolOptions& options, const ExchangeRecord& record,
                 const std::vector<DrapeSample>& original, const RunControl& control,
                 ExportedTarget& target) {
  constexpr double kLogFactors[] = {0.0, 0.35, 0.7, 1.05};
  constexpr double kNear = 0.1, kLeastSlope = 0.03;  // of DC, and by ln(factor)
  constexpr double kLeast = -0.35, kMost = 1.8;      // ln(factor)
  const Drapes drapes(options, target.target, control);
  const auto drape = [&](double log_factor, std::optional<RoundTrip>* trip) {
    ExportOptions given = options.target;
    given.bend_factor = std::exp(log_factor);
    ExportedMaterial material = ExportMaterial(target.target, record, given);
    const std::vector<DrapeSample> exported = drapes.Sample(material.tables);
    if (exported.size() == original.size()) *trip = CompareRoundTrip(original, exported);
    return material;
  };
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();  // of DC = line · (1, ln(factor))
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const double log_factor : kLogFactors) {
    std::optional<RoundTrip> trip;
    drape(log_factor, &trip);
    if (!trip) return;  // cancelled
    if (log_factor == 0.0) target.unfitted = trip;
    if (trip->pairs == 0) continue;
    const double off = trip->dc_exported - trip->dc_original;
    const double weight = std::exp(-0.5 * off * off / (kNear * kNear));
    const Eigen::Vector2d row(1.0, log_factor);
    normal += weight * row * row.transpose();
    right += weight * off * row;
  }
  const Eigen::Vector2d line = normal.ldlt().solve(right);
  const double log_factor =
      normal.determinant() > 0.0
          ? std::clamp(-line[0] / std::max(kLeastSlope, line[1]), kLeast, kMost)
          : 0.0;
  target.material = drape(log_factor, &target.round_trip);
  target.bend_factor = std::exp(log_factor);
}

// Drapes a fabric once for all targets that keep the same tables.
void DrapeTargets(const ExportToolOptions& options, const Drapes& drapes,
                  const MaterialField& tables, const std::vector<DrapeSample>& original,
                  const RunControl& control, ExportRun* run) {
  std::vector<std::pair<MaterialField, RoundTrip>> known = {
      {tables, CompareRoundTrip(original, original)}};
  for (size_t i = 0; i < run->targets.size() && !control.cancelled(); ++i) {
    ExportedTarget& target = run->targets[i];
    control.Report(static_cast<double>(i) / static_cast<double>(run->targets.size()),
                   std::string(ToString(target.target)));
    if (options.edge > 0.0 && BendsAtHinges(target.target)) {
      FitToHinges(options, run->record, original, control, target);
      continue;
    }
    const auto same = std::find_if(known.begin(), known.end(), [&](const auto& entry) {
      return SameTables(entry.first, target.material.tables);
    });
    if (same != known.end()) {
      target.round_trip = same->second;
      continue;
    }
    const std::vector<DrapeSample> exported = drapes.Sample(target.material.tables);
    if (exported.size() < original.size()) break;  // cancelled
    known.emplace_back(target.material.tables, CompareRoundTrip(original, exported));
    target.round_trip = known.back().second;
  }
}

OptionTable ExportTable(ExportToolOptions& options) {
  Option to = {.key = "to",
               .value = &options.to,
               .doc =
                   "programs and formats, separated by commas: arcsim, clo, newton, style3d, "
                   "ppf, blender, json; or all; of a posterior also csv",
               .required = true};
  return {.tool = "drape_export",
          .summary =
              "takes a fabric to other simulators: files, what they lose, and how the "
              "fabric drapes with what is left",
          .example = "drape_export --fabric=out/fit --to=clo,blender,newton --out=out/export",
          .notes =
              "Of a posterior the median is exported, with the intervals and origins that its fit "
              "states.\n"
              "files: one for each target and summary.json: the neutral linear record, and of each "
              "target what is lost, whether it is verified, and the round trip\n"
              "bend_weft is the rigidity for bending along the weft: table row \"edges along "
              "warp\". shear is c33/2.\n",
          .options = Concatenate(Grouped("fabric", FieldOptionList(options.fabric)),
                                 Grouped("targets", {to, OutOption(options.out)}),
                                 Grouped("linear record", LinearOptions(options)),
                                 Grouped("posterior", SampleOptions(options.posterior)),
                                 Grouped("round trip", RoundTripOptions(options)))};
}

void CheckOptions(const ExportToolOptions& options) {
  if (!options.mesh.starts_with("disc:"))
    throw InputError("option 'mesh'", "found " + options.mesh + ", expected disc:N");
  if (options.posterior.draws % options.posterior.chains != 0)
    throw InputError("option 'draws'", "found " + std::to_string(options.posterior.draws) +
                                           ", expected a multiple of the " +
                                           std::to_string(options.posterior.chains) + " chains");
}

// The samples of the source where they are asked for.
std::string SamplesText(const ExportToolOptions& options, const FabricSource& source,
                        const Law& law) {
  if (!Asks(options.to, kCsv)) return "";
  PosteriorTableOptions posterior = options.posterior;
  posterior.seed = static_cast<uint64_t>(options.seed);
  return PosteriorCsv(source, law, posterior);
}

RecordOptions MakeRecordOptions(const ExportToolOptions& options) {
  RecordOptions record;
  record.point = options.point;
  if (options.thickness > 0.0) record.thickness = options.thickness;
  return record;
}

std::string RoundTripText(const RoundTrip& trip) {
  if (trip.pairs == 0) return Format("none of %d starts comes to rest with both", trip.starts);
  return Format("DC %+.1f points (%.1f -> %.1f %%), nodes %.1f -> %.1f",
                100.0 * (trip.dc_exported - trip.dc_original), 100.0 * trip.dc_original,
                100.0 * trip.dc_exported, trip.nodes_original, trip.nodes_exported);
}

std::string TargetText(const ExportedTarget& exported, const std::string& folder, double edge) {
  const ExportedMaterial& material = exported.material;
  std::string text = Format("%-8s %s/%s\n", std::string(ToString(exported.target)).c_str(),
                            folder.c_str(), material.file.c_str());
  text += (material.verified ? "  verified: " : "  not verified: ") + material.evidence + "\n";
  if (exported.unfitted)
    text += Format(
        "  here:  by hinges of %g mm, with %.2f times the rigidities (the bending length of a "
        "strip "
        "x %.2f)\n"
        "         with the fabric's own rigidities: %s\n",
        1e3 * edge, exported.bend_factor, std::cbrt(exported.bend_factor),
        RoundTripText(*exported.unfitted).c_str());
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
  return {{"target", ToString(exported.target)},
          {"file", material.file},
          {"use", material.use},
          {"lost", material.lost},
          {"status", material.verified ? "verified" : "unverified"},
          {"evidence", material.evidence},
          {"bend_factor", exported.bend_factor},
          {"strip_bending_length_factor", std::cbrt(exported.bend_factor)},
          {"round_trip", exported.round_trip ? RoundTripJson(*exported.round_trip) : Json(nullptr)},
          {"round_trip_unfitted",
           exported.unfitted ? RoundTripJson(*exported.unfitted) : Json(nullptr)}};
}

// How the fabric drapes in each target, then the record, and of each target its file and losses.
std::string ExportText(const ExportRun& run) {
  if (run.cancelled) return "cancelled: nothing was written\n";
  std::string text;
  for (const ExportedTarget& target : run.targets)
    if (target.round_trip)
      text += Format("%-8s ", std::string(ToString(target.target)).c_str()) +
              RoundTripText(*target.round_trip) + "\n";
  text += MakePrintableLine(run.record.source.material.name) + ", linear at " +
          (run.record.point == LinearPoint::kRest ? "zero strain and curvature\n"
                                                  : "the curvatures of its drape\n");
  for (const LaboratoryRow& number : run.record.numbers) text += "  " + number.Text() + "\n";
  text += Format("  %-10s %11.4g kg/m2\n", "density", run.record.material.density);
  for (const ExportedTarget& target : run.targets) text += TargetText(target, run.out, run.edge);
  for (const std::string& file : run.posterior_files)
    text += "posterior " + run.out + "/" + file + "\n";
  return text;
}

void WriteExportSummary(const std::string& path, const ExportRun& run) {
  Json json = {{"tool", "drape_export"},
               {"source", run.record.source.path},
               {"record", RecordJson(run.record)},
               {"edge_m", run.edge},
               {"targets", Json::array()}};
  for (const ExportedTarget& target : run.targets) json["targets"].push_back(TargetJson(target));
  json["posterior_files"] = run.posterior_files;
  WriteWithProvenance(path, std::move(json));
}

// Writes a file for each target and summary.json.
ExportRun RunExport(const ExportToolOptions& options, const RunControl& control) {
  CheckOptions(options);
  const std::vector<ExportTarget> targets = ParseTargets(options.to);
  const Law law = MakeLaw(options.law);
  const FabricSource source =
      ReadFabric(options.fabric.path, ReadingPolicy(law, options.fabric.min_relative_stiffness));
  for (const std::string& warning : source.material.warnings)
    NoteInput(options.fabric.path, warning);
  const std::string samples = SamplesText(options, source, law);
  const Drapes drapes(options, control);
  const OutputFolder out(options.out, {"summary.json"});
  ExportRun run;
  run.out = options.out;
  run.edge = options.edge;
  RecordOptions record = MakeRecordOptions(options);
  std::vector<DrapeSample> original;
  const bool at_drape = options.point == LinearPoint::kDrape;
  if (at_drape || (options.starts > 0 && !targets.empty())) {
    original = drapes.Sample(source.material.field);
    run.cancelled = control.cancelled();
    if (run.cancelled) return run;
  }
  if (at_drape) record.weights = drapes.Weights(original);
  run.record = MakeRecord(source, law, record);
  for (const ExportTarget target : targets)
    run.targets.push_back(
        {.target = target, .material = ExportMaterial(target, run.record, options.target)});
  for (ExportedTarget& target : run.targets)
    if (options.starts == 0 && options.edge > 0.0 && BendsAtHinges(target.target))
      target.material.lost.emplace_back(
          "the stiffness of a smooth sheet: hinges drape more softly, and --starts=0 leaves the "
          "rigidities as they are");
  if (options.starts > 0)
    DrapeTargets(options, drapes, source.material.field, original, control, &run);
  run.cancelled = control.cancelled();
  if (run.cancelled) return run;
  for (const ExportedTarget& target : run.targets)
    WriteFileAtomically(out.Staged(target.material.file), target.material.text);
  if (!samples.empty()) {
    run.posterior_files = {"draws.csv"};
    WriteFileAtomically(out.Staged("draws.csv"), samples);
  }
  WriteExportSummary(out.Staged("summary.json"), run);
  out.Publish();
  return run;
}

ToolOutcome Run(const ExportToolOptions& options, const RunControl& control) {
  const ExportRun run = RunExport(options, control);
  return {.text = ExportText(run), .cancelled = run.cancelled};
}

}  // namespace

int ExportMain(int argc, char** argv) { return ToolMain(argc, argv, ExportTable, Run); }

}  // namespace drape
