// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/field_io.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "physics/material/material_io.h"
#include "physics/material/material_scaling.h"
#include "physics/util/atomic_file.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

using nlohmann::ordered_json;

// Stiffness of each face, rigidity of each hinge.
Eigen::VectorXd StretchOfFaces(const MaterialField& field) {
  Eigen::VectorXd stiffness(static_cast<Eigen::Index>(field.stretch.size()));
  std::transform(field.stretch.begin(), field.stretch.end(), stiffness.begin(), MeanStretch);
  return stiffness;
}
Eigen::VectorXd BendOfHinges(const MaterialField& field) {
  Eigen::VectorXd rigidity(static_cast<Eigen::Index>(field.bend.size()));
  std::transform(field.bend.begin(), field.bend.end(), rigidity.begin(), MeanBend);
  return rigidity;
}

struct Scatter {
  explicit Scatter(const Eigen::VectorXd& v)
      : mean(v.mean()),
        deviation(std::sqrt((v.array() - v.mean()).square().mean())),
        least(v.minCoeff()),
        most(v.maxCoeff()) {}
  double mean, deviation, least, most;
};

ordered_json ScatterJson(const Eigen::VectorXd& values) {
  const Scatter s(values);
  return {
      {"mean", s.mean}, {"standard_deviation", s.deviation}, {"least", s.least}, {"most", s.most}};
}

ordered_json UncertaintyJson(const Eigen::VectorXd& posterior, const Eigen::VectorXd& prior) {
  const Eigen::ArrayXd ratio = posterior.array() / prior.array();
  return {{"mean_of_posterior_over_prior_sd", ratio.mean()}, {"least", ratio.minCoeff()}};
}

}  // namespace

ordered_json FieldJson(const FieldFit& fit, const FieldOptions& options) {
  ordered_json json = {{"parameters", fit.summary.theta.size()},
                       {"determined_directions", fit.determined},
                       {"termination", ToString(fit.summary.termination)},
                       {"cost", fit.summary.final_cost},
                       {"initial_cost", fit.summary.initial_cost},
                       {"iterations", fit.iterations},
                       {"rollouts", fit.summary.counts.rollouts},
                       {"jacobians", fit.summary.counts.tangents},
                       {"branch_jumps", fit.summary.counts.jumps},
                       {"failed_rollouts", fit.summary.counts.failed},
                       {"seconds", fit.summary.seconds},
                       {"stretch_n_per_m", ScatterJson(StretchOfFaces(fit.material))},
                       {"bend_n_m", ScatterJson(BendOfHinges(fit.material))},
                       {"stretch_uncertainty", UncertaintyJson(fit.posterior_face, fit.prior_face)},
                       {"bend_uncertainty", UncertaintyJson(fit.posterior_hinge, fit.prior_hinge)}};
  // Numbers of single elements would repeat the material file.
  if (options.basis == FieldBasis::kModes) json["theta"] = fit.summary.theta;
  return json;
}

std::string FieldTable(const FieldFit& fit) {
  std::string table;
  const auto add = [&](const char* name, const Eigen::VectorXd& values, const char* unit) {
    const Scatter s(values);
    table += Format("  %-22s %10.4g  +- %.3g over the cloth, %.3g to %.3g %s\n", name, s.mean,
                    s.deviation, s.least, s.most, unit);
  };
  add("stretch, c11 and c22", StretchOfFaces(fit.material), "N/m");
  add("bend", BendOfHinges(fit.material), "N m");
  return table + Format("  %d of the fields' %d directions are determined by the data\n",
                        fit.determined, static_cast<int>(fit.summary.theta.size()));
}

void WriteFields(const std::string& folder, const Mesh& mesh, const FieldFit& fit, bool warp_known,
                 const std::string& source) {
  WriteMaterialField(folder + "/material.json",
                     {.name = "fit",
                      .field = fit.material,
                      .source_convention = "mechanical",
                      .source = source,
                      .warnings = {},
                      .warp_known = warp_known},
                     mesh);
  ordered_json json = {{"stretch_n_per_m", StretchOfFaces(fit.material)},
                       {"bend_n_m", BendOfHinges(fit.material)},
                       {"stretch_uncertainty", fit.posterior_face.cwiseQuotient(fit.prior_face)},
                       {"bend_uncertainty", fit.posterior_hinge.cwiseQuotient(fit.prior_hinge)}};
  for (const auto& uv : mesh.uv.colwise()) json["uv_m"].push_back({uv[0], uv[1]});
  for (const Face& face : mesh.faces) json["faces"].push_back(face.vertex);
  for (const Hinge& hinge : mesh.hinges)
    json["hinges"].push_back({hinge.vertex[0], hinge.vertex[1], hinge.face[0], hinge.face[1]});
  WriteFileAtomically(folder + "/" + kFieldsFile, json.dump() + "\n");
}

}  // namespace drape
