// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "physics/cloth/scene_io.h"
#include "physics/material/laws/law_kind.h"
#include "physics/material/material_scaling.h"
#include "physics/util/options/field.h"
#include "solver/fit/observed/observation.h"
#include "solver/fit/protocol/field_fit.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/posterior/posterior_fit.h"

namespace drape {

// Three structs describe a fit: how it is done (FitSpec), what is fitted (FitData), and the files
// that it writes (FitFiles).

enum class FitModel {
  kHomogeneous,    // one table for the whole cloth
  kHeterogeneous,  // then one for each element (FitFields)
  kBayes,          // then the uncertainty of the one table (FitDrapePosterior)
  kBdp             // then the scatter of elements (FitDrapePosterior)
};
constexpr auto EnumNames(FitModel) {
  return MakeNames<FitModel>({{FitModel::kHomogeneous, "homogeneous"},
                              {FitModel::kHeterogeneous, "heterogeneous"},
                              {FitModel::kBayes, "bayes"},
                              {FitModel::kBdp, "bdp"}});
}
inline bool HasPosterior(FitModel model) {
  return model == FitModel::kBayes || model == FitModel::kBdp;
}

// How a fit is done.
struct FitSpec {
  FitModel model = FitModel::kHomogeneous;
  std::string mesh = "disc:1200";        // ParseMeshSpec
  std::string search_mesh = "disc:600";  // on which a fit on a finer mesh begins (SearchMeshes)
  std::string coarse_mesh = "disc:300";  // of the initial guesses
  LawKind law = LawKind::kSmooth;
  CusickContact contact;
  ObservationOptions observation;
  StagedFitOptions stages;
  // Start entries below this share of their column's largest are raised to it: a log scale cannot
  // change an entry that is not positive. 0: tables as they are, negative entries as the law
  // allows.
  double min_relative_stiffness = 0.0;
  // The form of the raised start tables. 2 parameters keep a simpler form, and 7 a linear one.
  TableForm table_form = TableForm::kGiven;
  // Images: the models that the fitted one contains are fitted first (RunNestedFit).
  bool simpler_models = true;
  // Images: start from the drapes of a pool that are like them, where there is one for these discs
  // and all entries are fitted (P76); else from the start tables, by a grid (P18).
  bool start_pool = true;
  // space.json (ReadSpacePrior): the prior of a fabric in place of one about the initial guess; of
  // kBayes. Empty: none.
  std::string prior;
  std::string backend = "auto";  // MakeBackend
  int threads = 1;
  FieldOptions fields;         // of FitModel::kHeterogeneous
  PosteriorOptions posterior;  // of kBayes and kBdp, which set its kind
};

// The defaults on so many threads.
inline FitSpec FitSpecWithThreads(int threads) {
  FitSpec spec;
  spec.threads = threads;
  return spec;
}

// Visits its own fields; the structs in it have visitors of their own.
template <MutableOrConst<FitSpec> Options, class Visitor>
void VisitFields(Options& options, Visitor&& visit) {
  auto& [model, mesh, search_mesh, coarse_mesh, law, contact, observation, stages,
         min_relative_stiffness, table_form, simpler_models, start_pool, prior, backend, threads,
         fields, posterior] = options;
  visit(model,
        Field{.key = "model",
              .doc = "homogeneous: one table for the whole cloth; heterogeneous: then tables "
                     "that vary over it; bayes: then the uncertainty of the table; bdp: then "
                     "the scatter of faces and hinges about it, as in Gong et al. 2024",
              .in_key = false});
  visit(mesh, Field{.key = "mesh",
                    .doc = "cloth: an OBJ file, or disc:N for a built-in disc of N vertices",
                    .is_path = true,
                    .words = {"disc:"}});
  visit(search_mesh,
        Field{.key = "search_mesh",
              .doc = "cloth on which the branch and the first numbers are found, when it has "
                     "fewer vertices than `mesh`; the fit then goes on on finer ones up to "
                     "`mesh`, and the result has an estimate of its mesh error",
              .is_path = true,
              .words = {"disc:"}});
  visit(coarse_mesh, Field{.key = "coarse_mesh",
                           .doc = "cloth on which the initial guesses are ranked",
                           .is_path = true,
                           .words = {"disc:"}});
  visit(law, Field{.key = "law", .doc = "how stiffness follows from strain and curvature"});
  VisitFields(contact, visit);
  visit(min_relative_stiffness,
        Field{.key = "min_relative_stiffness",
              .doc = "start entries below this share of their column's largest are raised to it: "
                     "else a negative one is rejected (smooth law) and a zero stays zero",
              .range = {.least = 0, .most = 1}});
  visit(table_form, Field{.key = "table_form",
                          .doc = "form of the start tables: linear: their means over strain and "
                                 "curvature, isotropic: and over directions; kept by 2 free "
                                 "parameters, linear by 7 too"});
  visit(simpler_models,
        Field{.key = "simpler_models",
              .doc = "fit images by the models that this one contains first (isotropic 2 numbers, "
                     "linear 7, nonlinear 7, 39) and start also from the best of them, so that "
                     "more numbers never fit worse"});
  visit(start_pool,
        Field{.key = "start_pool",
              .doc = "images of 24, 30 or 36 cm on 18 cm, all entries: start from those of 16,000 "
                     "random drapes that are like them; false: from the start tables by a grid"});
  visit(backend, Field{.key = "backend", .is_option = false, .in_key = false});
  visit(threads,
        Field{.key = "threads", .range = {.least = 1}, .is_option = false, .in_key = false});
}

// Where a fit writes.
struct FitFiles {
  std::string out;               // existing folder of the results
  std::string target = {};       // where they are moved to afterwards; empty: they stay
  std::string checkpoint;        // of the fit of one table; removed at the end
  bool keep_checkpoint = false;  // unless it stays, for another model of the same data
  bool resume = false;           // continue from the checkpoint
  std::string outlines = {};     // WriteOutlines of the best so far; removed at the end
  std::string log;               // text file, one line for each candidate
  // Where the results are from, for the summary ("provenance"); empty: it does not say.
  std::function<nlohmann::ordered_json()> provenance = {};
};

}  // namespace drape
