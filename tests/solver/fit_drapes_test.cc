// SPDX-License-Identifier: Apache-2.0
// Fits and posteriors in memory.
#include "solver/fit_drapes.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "physics/material/material_scaling.h"
#include "physics/util/errors.h"
#include "tests/solver/solver_fixture.h"

namespace drape::test {
namespace {

class FitDrapesTest : public testing::Test {
 protected:
  FitDrapesTest() {
    spec_.mesh = "disc:150";
    spec_.coarse_mesh = "disc:100";
    spec_.simpler_models = false;
    spec_.stages.parameters = ParameterTying::kScales;
    spec_.stages.grid.stretch = {1.0};
    spec_.stages.grid.bend = {4.0};
    spec_.stages.grid.lifts = {1.0};
    spec_.stages.candidates_per_round = {1};
    spec_.stages.iterations = {8};
    spec_.observation.angles = 72;
    spec_.posterior.draws = 4;
    spec_.posterior.iterations = 4;
    spec_.posterior.elbo_samples = 25;
  }
  // A drape of four times the bending stiffness of the start tables.
  static ObservedFabric Fabric() {
    const auto backend = SmoothDisc(150);
    const State drape =
        Settled(*backend, Scaled(TestMaterial(), 1.0, 4.0), RandomStart(backend->model(), 1));
    return {.drapes = {MakeObservation(backend->model().mesh, drape, 72, "drape")},
            .start = TestMaterial()};
  }
  FitSpec spec_;
};

TEST_F(FitDrapesTest, SamplesSayWhatTheDrapeHasMeasured) {
  spec_.model = FitModel::kBayes;
  ObservedFabric fabric = Fabric();
  fabric.density = 1.1 * TestMaterial().density;
  const DrapeFit fit = FitDrapes(spec_, fabric);
  ASSERT_TRUE(fit.fitted());
  EXPECT_EQ(fit.material.density, fabric.density);
  EXPECT_EQ(fit.drapes.at(0).size(), fit.cloth->num_dofs());
  const Posterior posterior = SamplePosterior(fit, 60, 7);
  EXPECT_EQ(posterior.fabrics.size(), 60u);
  ASSERT_EQ(posterior.quantities.size(), fit.sheet.rows.size());
  const PosteriorQuantity& bend = posterior.of("bending_in_drape_un_m");
  EXPECT_TRUE(bend.measured());
  EXPECT_EQ(bend.samples.size(), 60u);
  EXPECT_EQ(bend.Quantile(0.0), *std::min_element(bend.samples.begin(), bend.samples.end()));
  EXPECT_LT(bend.Quantile(0.05), bend.value);
  EXPECT_GT(bend.Quantile(0.95), bend.value);
  EXPECT_LE(bend.interval->low, 1.05 * bend.Quantile(0.05));
  EXPECT_FALSE(posterior.of("shear_n_per_m").measured());
  EXPECT_EQ(posterior.of("mass_g_per_m2").Quantile(0.5), 1e3 * fabric.density);
  EXPECT_THROW(posterior.of("weight"), InputError);
  EXPECT_EQ(SamplePosterior(fit, 3, 7).of("shear_n_per_m").samples[2],
            SamplePosterior(fit, 3, 7).of("shear_n_per_m").samples[2]);
  EXPECT_THROW(SamplePosterior(fit, 0, 7), InputError);
}

TEST_F(FitDrapesTest, SaysWhichDensityItAssumes) {
  const DrapeFit fit = FitDrapes(spec_, Fabric());
  EXPECT_THAT(fit.notes, testing::Contains(testing::HasSubstr("density")));
  EXPECT_THROW(SamplePosterior(fit, 10, 1), InputError);
}

TEST_F(FitDrapesTest, RefusesWhatContradictsTheDrapes) {
  EXPECT_THROW(FitDrapes(spec_, {.drapes = {}, .start = TestMaterial()}), InputError);
  ObservedFabric fabric = Fabric();
  fabric.start.bend.clear();
  EXPECT_THROW(FitDrapes(spec_, fabric), InputError);
  fabric = Fabric();
  fabric.specimens = {1};  // model homogeneous tells none apart
  EXPECT_THROW(FitDrapes(spec_, fabric), InputError);
  spec_.observation.angles = 90;
  EXPECT_THROW(FitDrapes(spec_, Fabric()), InputError);
}

}  // namespace
}  // namespace drape::test
