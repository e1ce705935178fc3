// SPDX-License-Identifier: Apache-2.0
#include "solver/job/field_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "physics/material/material_field_io.h"
#include "physics/material/material_scaling.h"
#include "physics/util/text_format.h"
#include "solver/job/plot/chart.h"
#include "solver/job/plot/field_map.h"

namespace drape {
namespace {

using nlohmann::ordered_json;

// Of each face, of each hinge.
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
  const bool modes = options.basis == FieldBasis::kModes;
  ordered_json json = {{"basis", ToString(options.basis)},
                       {"groups", ToString(options.groups)},
                       {"prior_sigma", options.sigma}};
  if (modes) json.update({{"modes", options.modes}, {"length_m", options.length}});
  json.update({{"parameters", fit.summary.theta.size()},
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
               {"bend_uncertainty", UncertaintyJson(fit.posterior_hinge, fit.prior_hinge)}});
  // Of elements, theta would repeat the material file.
  if (modes)
    json["theta"] = std::vector<double>(fit.summary.theta.begin(), fit.summary.theta.end());
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

std::string WriteFields(const std::string& folder, const Mesh& mesh, const FieldFit& fit,
                        const std::string& source) {
  WriteMaterialField(folder + "/material.json",
                     {.name = "fit",
                      .field = fit.material,
                      .source_convention = "mechanical",
                      .source = source,
                      .warnings = {}},
                     mesh);
  const Eigen::VectorXd face = fit.posterior_face.cwiseQuotient(fit.prior_face);
  const Eigen::VectorXd hinge = fit.posterior_hinge.cwiseQuotient(fit.prior_hinge);
  const char* const ratio = "posterior / prior standard deviation of the log factor";
  const auto picture = [&](int i) { return folder + "/" + kFieldPictures[i]; };
  return TryPictures([&] {
    RenderFaceMap(picture(0), mesh, StretchOfFaces(fit.material),
                  {"Stretching stiffness", "membrane stiffness, mean of c11 and c22 [N/m]"});
    RenderHingeMap(picture(1), mesh, 1e6 * BendOfHinges(fit.material),
                   {"Bending stiffness", "plate rigidity D [µN m]"});
    RenderFaceMap(picture(2), mesh, face, {"Uncertainty of the stretching stiffness", ratio});
    RenderHingeMap(picture(3), mesh, hinge, {"Uncertainty of the bending stiffness", ratio});
  });
}

}  // namespace drape
