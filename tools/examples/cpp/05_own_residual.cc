// SPDX-License-Identifier: Apache-2.0
// Fits a fabric to what a readout of our own reads of a cloth over the edge of a shelf, and makes a
// page of it. usage: 05_own_residual <fabric.json> <existing folder of results>
#include <cstdio>
#include <cstdlib>

#include "solver/drapefit.h"
using namespace drape;

// The lengths of tapes between corners of the cloth [m], and their derivatives by the positions.
struct Tapes final : Readout {
  int size() const override { return 4; }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override {
    constexpr int kEnds[][2] = {{0, 12}, {162, 174}, {0, 174}, {162, 12}};  // vertices
    r->resize(size());
    RowMatrix slopes = RowMatrix::Zero(size(), x.size());
    for (int i = 0; const auto [a, b] : kEnds) {
      const Eigen::Vector3d tape = x.segment<3>(3 * b) - x.segment<3>(3 * a);
      slopes.block<1, 3>(i, 3 * a) = -tape.transpose() / tape.norm();
      slopes.block<1, 3>(i, 3 * b) = tape.transpose() / tape.norm();
      (*r)[i++] = tape.norm();
    }
    if (dr_dx != nullptr) *dr_dx = slopes.sparseView();
    return true;
  }
};
int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const std::string out = argv[2], page = "drape_report " + out + " --out=" + out + "/report.html";
  const auto make = [](const ClothModel&) { return std::make_shared<Tapes>(); };
  const Measurement tapes{"tapes", make, Eigen::Vector4d(.093, .0925, .1365, .136), 5e-4};
  const Experiment cloth{"cloth", MakeStrip(.12, .1, 12, 12), CantileverScene(.05, 9.8), {tapes}};
  FitSpec spec;
  spec.model = FitModel::kBayes;
  spec.stages.parameters = ParameterTying::kBendScale;
  const DrapeFit fit = FitDrapes(spec, {.material = argv[1], .experiments = {cloth}}, {}, out);
  const LaboratoryRow& bend = fit.sheet.of("bending_in_drape_un_m");
  std::printf("%s: %s\n", ToString(fit.verdict.grade), bend.Text().c_str());
  return bend.measured() ? std::system(page.c_str()) : 1;
}
