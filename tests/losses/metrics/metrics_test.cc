// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <list>
#include <numeric>
#include <random>

#include "losses/dataset/dataset.h"
#include "losses/outline/outline.h"
#include "losses/silhouette/silhouette.h"
#include "physics/util/errors.h"
#include "physics/util/math/random.h"
#include "tests/losses/disc.h"

namespace drape {
namespace {

Eigen::VectorXd Profile(int num_angles, double mean, double amplitude, int order,
                        double phase = 0) {
  return Eigen::VectorXd::NullaryExpr(num_angles, [&](Eigen::Index k) {
    return mean + amplitude * std::cos(order * (2 * M_PI * k / num_angles - phase));
  });
}

TEST(DrapeCoefficient, IsZeroForTheSupportAndOneForTheFlatCloth) {
  EXPECT_NEAR(DrapeCoefficient(M_PI * 0.09 * 0.09, {}), 0, 1e-14);
  EXPECT_NEAR(DrapeCoefficient(M_PI * 0.15 * 0.15, {}), 1, 1e-14);
}

TEST(ProfileArea, OfCircleAndFoldedCircle) {
  EXPECT_NEAR(ProfileArea(Profile(72, 0.12, 0, 0)), M_PI * 0.12 * 0.12, 1e-15);
  // ½∫(m + a cos)² = π(m² + a²/2)
  EXPECT_NEAR(ProfileArea(Profile(72, 0.12, 0.02, 7)), M_PI * (0.12 * 0.12 + 0.0002), 1e-15);
}

class FoldCount : public testing::TestWithParam<int> {};
TEST_P(FoldCount, OfACosine) {
  const int folds = GetParam();
  for (double phase : {0.0, 0.1, 1.7}) {
    for (int num_angles : {180, 360, 719}) {
      const Eigen::VectorXd r = Profile(num_angles, 0.12, 0.008, folds, phase);
      EXPECT_EQ(CountFolds(r), folds) << num_angles << " angles, phase " << phase;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(From0To12, FoldCount, testing::Range(0, 13));

TEST(CountFolds, NeedsTheProminence) {
  // The prominence of a cosine is 2·amplitude; the smoothing reduces it by 2 % at order 6.
  EXPECT_EQ(CountFolds(Profile(360, 0.12, 1.32e-3, 6)), 6);
  EXPECT_EQ(CountFolds(Profile(360, 0.12, 1.20e-3, 6)), 0);
}

TEST(CountFolds, IgnoresNoiseButNotANotchedPeak) {
  const Eigen::VectorXd noise = 3e-4 * RandomVector(360, 3);
  EXPECT_EQ(CountFolds(Profile(360, 0.12, 0.01, 7) + noise), 7);
  // There are two unequal peaks in each period of 3; the small one of prominence 2a(…) counts as
  // well.
  EXPECT_EQ(CountFolds(Profile(360, 0.12, 0.006, 3) + Profile(360, 0, 0.006, 6)), 6);
  EXPECT_EQ(CountFolds(Profile(360, 0.12, 0.006, 3) + Profile(360, 0, 0.001, 6)), 3);
}

TEST(BandEnergies, AreTheSharesOfTheVariance) {
  const Eigen::VectorXd r = Profile(180, 0.12, 0.01, 2, 0.3) + Profile(180, 0, 0.004, 4) +
                            Profile(180, 0, 0.003, 5) + Profile(180, 0, 0.006, 9) +
                            Profile(180, 0, 0.002, 10) + Profile(180, 0, 0.02, 16);
  const auto energy = BandEnergies(r);
  EXPECT_NEAR(energy[0], 0.5e-4, 1e-16);
  EXPECT_NEAR(energy[1], 0.5 * (16e-6 + 9e-6), 1e-16);
  EXPECT_NEAR(energy[2], 0.5 * 36e-6, 1e-16);
  EXPECT_NEAR(energy[3], 0.5 * 4e-6, 1e-16);
}

TEST(IsoperimetricRatio, IsOneForACircleOnly) {
  // A regular N-gon has (π/N)/tan(π/N).
  EXPECT_NEAR(IsoperimetricRatio(Profile(360, 0.12, 0, 0)), M_PI / 360 / std::tan(M_PI / 360),
              1e-12);
  // A closed form: a square in polar coordinates, r = 1/max(|cos|, |sin|), has π/4.
  const Eigen::VectorXd square = Eigen::VectorXd::NullaryExpr(720, [](Eigen::Index k) {
    const double angle = 2 * M_PI * k / 720;
    return 1 / std::max(std::abs(std::cos(angle)), std::abs(std::sin(angle)));
  });
  EXPECT_NEAR(IsoperimetricRatio(square), M_PI / 4, 1e-12);
}

TEST(ImageMetrics, OfHalfOverlappingBars) {
  GrayImage a(20, 20), b(20, 20);
  for (int i = 0; i < 20; ++i) {
    for (int col = 2; col < 6; ++col) a.at(col, i) = 1;
    for (int col = 4; col < 8; ++col) b.at(col, i) = 0.75f;
  }
  EXPECT_NEAR(IntersectionOverUnion(a, b), 2.0 / 6, 1e-15);
  EXPECT_NEAR(IntersectionOverUnion(a, b, 0.8f), 0, 1e-15);
  EXPECT_NEAR(MeanSquaredError(a, b), (2 * 1 + 2 * 0.0625 + 2 * 0.5625) / 20, 1e-15);
  EXPECT_EQ(IntersectionOverUnion(GrayImage(20, 20), GrayImage(20, 20)), 1);
}

TEST(ProfileRms, OfAConstantOffset) {
  EXPECT_NEAR(ProfileRms(Profile(72, 100, 5, 3), Profile(72, 98, 5, 3)), 2, 1e-12);
}

TEST(CompareSilhouettes, TwoCirclesInClosedForm) {
  const Camera camera;
  const double small = 0.11, large = 0.13;
  const auto image_of = [&](double radius) {
    const Mesh disc = MakeDisc(3, 360, radius);
    return Rasterize(disc, disc.rest_x, camera, 8);
  };
  const GrayImage image = image_of(large), fit = image_of(small);
  Outline outline;
  ASSERT_TRUE(OutlineFromImage(image, camera, 360, &outline));
  const SilhouetteMetrics m = CompareSilhouettes(
      image, outline.radius, fit, Eigen::VectorXd::Constant(360, small * camera.scale), camera, {});
  const double ring = M_PI * (large * large - small * small);
  // A border pixel of coverage c contributes c² where the area of the ring contributes c: ∫(c − c²)
  // = 1/6 px per border px.
  const double border = 2 * M_PI * (large + small) * camera.scale;
  const double mse = (ring * camera.scale * camera.scale - border / 6) / (256 * 256);
  EXPECT_NEAR(m.mse, mse, 3e-4);
  EXPECT_NEAR(m.iou, small * small / (large * large), 5e-3);
  EXPECT_NEAR(m.profile_rms, 0.02 * camera.scale, 0.05);
  EXPECT_NEAR(m.hausdorff, 0.02, 2e-4);
  EXPECT_NEAR(m.image_area_dc, DrapeCoefficient(M_PI * large * large, {}), 1e-3);
  EXPECT_NEAR(m.fitted_area_dc, DrapeCoefficient(M_PI * small * small, {}), 1e-3);
  EXPECT_NEAR(m.image.drape_coefficient, m.image_area_dc, 2e-3);
  EXPECT_NEAR(m.fitted.drape_coefficient, DrapeCoefficient(M_PI * small * small, {}), 1e-12);
  EXPECT_EQ(m.image.folds, 0);
  EXPECT_NEAR(m.image.radius_min, large, 2e-4);
  EXPECT_NEAR(m.image.radius_max, large, 2e-4);
  EXPECT_GT(m.image.isoperimetric_ratio, 0.99);
}

constexpr double kDegree = M_PI / 180;

// A drape without a mirror symmetry.
ObjSurface Surface() {
  const Mesh disc = MakeDisc(6, 240, 0.15);
  ObjSurface surface{Deform(disc, {.folds = 6, .amplitude = 0.1}), ListTriangles(disc)};
  for (Eigen::Index i = 0; i < surface.x.size(); i += 3) {
    const double angle = std::atan2(surface.x[i + 1], surface.x[i]);
    const double factor = 1 + 0.05 * std::cos(2 * angle) + 0.03 * std::sin(3 * angle - 0.5);
    surface.x.segment<2>(i) *= factor;
  }
  return surface;
}

ObjSurface Moved(double rotation, bool mirrored) {
  ObjSurface surface = Surface();
  surface.x = TurnedAboutZ(surface.x, rotation, mirrored);
  return surface;
}

TEST(ObserveSurface, IsObserveImageOfItsRaster) {
  const ObservedDrape seen = ObserveSurface(Surface(), Camera(), {}, "s");
  EXPECT_EQ(seen.image.coverage, Rasterize(Surface(), Camera(), 4).coverage);
  EXPECT_EQ(seen.radius, ObserveImage(seen.image, Camera(), {}, "i").radius);
  EXPECT_EQ(seen.shape.folds, 6);
}

TEST(ObserveDisc, HasTheAreaOfTheCircle) {
  const ObservedDrape disc = ObserveDisc(0.12, Camera(), {});
  EXPECT_NEAR(CoverageArea(disc.image, Camera()), M_PI * 0.12 * 0.12, 1e-5);
  EXPECT_NEAR((disc.radius.array() - 0.12).abs().maxCoeff(), 0, 3e-4);
}

TEST(ObserveImage, RejectsAnotherSizeAndGaps) {
  EXPECT_THROW(ObserveImage(GrayImage(128, 256), Camera(), {}, "i"), InputError);
  EXPECT_THROW(ObserveImage(GrayImage(256, 256), Camera(), {}, "i"), InputError);
  ObjSurface flown = Surface();
  flown.x[0] = 1e9;
  EXPECT_THROW(ObserveSurface(flown, Camera(), {}, "s"), InputError);
}

TEST(TurnedImage, IsTheImageOfTheTurnedSurface) {
  for (const bool mirrored : {false, true}) {
    const double turn = 37.3 * kDegree;
    const GrayImage turned =
        TurnedImage(ObserveSurface(Surface(), Camera(), {}, "s").image, Camera(), turn, mirrored);
    const GrayImage expected = ObserveSurface(Moved(turn, mirrored), Camera(), {}, "s").image;
    EXPECT_LT(MeanSquaredError(turned, expected), 3e-4);
    EXPECT_GT(IntersectionOverUnion(turned, expected), 0.995);
  }
}

TEST(CompareDrapes, FindsRotationAndFlip) {
  const Camera camera;
  const ObservedDrape here = ObserveSurface(Surface(), camera, {}, "a");
  for (const bool mirrored : {false, true}) {
    for (const double degrees : {0.0, 37.3, 200.6}) {
      const ObservedDrape there =
          ObserveSurface(Moved(degrees * kDegree, mirrored), camera, {}, "b");
      const DrapeComparison c = CompareDrapes(here, there, camera);
      // The rotation is undone by −φ; that of a mirrored drape by φ, since the mirror reverses it.
      const double expected = (mirrored ? degrees : -degrees) * kDegree;
      EXPECT_EQ(c.alignment.mirrored, mirrored);
      EXPECT_NEAR(std::remainder(c.alignment.rotation - expected, 2 * M_PI), 0, 0.05 * kDegree);
      EXPECT_LT(c.aligned.mse, 4e-4);
      EXPECT_LT(c.aligned.outline_hausdorff, 8e-4);
      if (degrees == 0 && !mirrored) continue;
      EXPECT_GT(c.raw.mse, 0.01);
      EXPECT_LT(c.raw.iou, 0.97);
      EXPECT_GT(c.raw.outline_hausdorff, 5e-3);
      EXPECT_GT(c.raw.profile_rms, 5 * c.aligned.profile_rms);
    }
  }
}

TEST(CompareSurfaces, RawAndAligned) {
  const ObjSurface turned = Moved(40 * kDegree, true);
  const SurfaceDistance d =
      CompareSurfaces(Surface(), turned, {40 * kDegree, true}, "meshes", 2e-4);
  EXPECT_GT(d.raw, 5e-3);
  EXPECT_LT(d.aligned, 3e-4);
}

// Flat discs, whose features are known: DC from the radius, no folds, no bands.
class Discs {
 public:
  DistributionScorer::Drapes Of(const std::vector<double>& radii) {
    DistributionScorer::Drapes drapes;
    for (const double radius : radii) {
      kept_.push_back(ObserveDisc(radius, Camera(), {}));
      drapes.push_back(&kept_.back());
    }
    return drapes;
  }

 private:
  std::list<ObservedDrape> kept_;
};

double Coefficient(double radius) { return DrapeCoefficient(M_PI * radius * radius, {}); }

TEST(DistributionScorer, DiscsInClosedForm) {
  Discs discs;
  DistributionScorer scorer;
  scorer.Add(discs.Of({0.10, 0.12}), discs.Of({0.11, 0.13}));
  const DistributionScore score = scorer.Score();
  EXPECT_EQ(score.observed, 2);
  // The mean image has a ring of ½ between 10 and 12 cm; outside 12 cm it misses the second disc.
  const double px = 719.5 * 719.5 * M_PI / (256 * 256);
  const double first = 0.25 * (0.12 * 0.12 - 0.10 * 0.10);
  const double second = first + 0.13 * 0.13 - 0.12 * 0.12;
  EXPECT_NEAR(score.mean_image_mse, 0.5 * (first + second) * px, 2e-3);
  const FeatureScore& dc = score.features[0];
  const double low = Coefficient(0.10), high = Coefficient(0.12);
  EXPECT_NEAR(dc.predicted_mean, 0.5 * (low + high), 2e-3);
  EXPECT_NEAR(dc.predicted_sd, (high - low) / std::sqrt(2), 2e-3);
  EXPECT_NEAR(dc.observed_mean, 0.5 * (Coefficient(0.11) + Coefficient(0.13)), 2e-3);
  EXPECT_NEAR(dc.crps, 0.5 * (0 + Coefficient(0.13) - high), 3e-3);
  for (const IntervalSkill& skill : {dc.half, dc.ninety}) {
    EXPECT_NEAR(skill.nominal, 1.0 / 3, 1e-12);
    EXPECT_EQ(skill.coverage, 0.5);
    EXPECT_NEAR(skill.width, high - low, 3e-3);
  }
  EXPECT_EQ(score.features[1].crps, 0);
  EXPECT_NEAR(score.outline_energy, 0.5 * (0 + 0.01), 1e-4);
  EXPECT_NEAR(score.feature_energy, dc.crps / kFeatureScales[0], 0.02);
}

TEST(DistributionScorer, IsTheMeanOverAllPredictions) {
  Discs discs;
  const auto draws = discs.Of({0.10, 0.11, 0.125}), observed = discs.Of({0.11, 0.12, 0.14});
  DistributionScorer at_once, one_by_one;
  at_once.Add(draws, observed);
  for (const ObservedDrape* drape : observed) one_by_one.Add(draws, {drape});
  const DistributionScore a = at_once.Score(), b = one_by_one.Score();
  EXPECT_NEAR(a.mean_image_mse, b.mean_image_mse, 1e-12);
  EXPECT_NEAR(a.feature_energy, b.feature_energy, 1e-9);
  EXPECT_NEAR(a.outline_energy, b.outline_energy, 1e-12);
  EXPECT_NEAR(a.features[0].crps, b.features[0].crps, 1e-12);
  EXPECT_NEAR(a.features[0].half.coverage, b.features[0].half.coverage, 1e-12);
}

TEST(DistributionScorer, ScalesWeightTheFeatures) {
  Discs discs;
  const auto draws = discs.Of({0.10, 0.12}), observed = discs.Of({0.14});
  DistributionScorer twice(2 * kFeatureScales), once;
  twice.Add(draws, observed);
  once.Add(draws, observed);
  EXPECT_NEAR(2 * twice.Score().feature_energy, once.Score().feature_energy, 1e-9);
}

TEST(ComputeFeatures, AreInTheOrderOfTheirNames) {
  const FeatureVector f =
      ComputeFeatures({.drape_coefficient = 0.5, .folds = 7, .band_energy = {1, 2, 3, 4}});
  EXPECT_EQ(f, (FeatureVector() << 0.5, 7, 1, 2, 3, 4).finished());
  EXPECT_STREQ(kFeatureNames[5], "band_10_15");
}

std::vector<double> Normals(int count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<double> draws(count);
  for (double& draw : draws) draw = SampleNormal(random);
  return draws;
}

// The score of a standard normal distribution [Gneiting 2007, eq. 21].
double NormalCrps(double z) {
  const double density = std::exp(-0.5 * z * z) / std::sqrt(2 * M_PI);
  const double below = 0.5 * std::erfc(-z / std::sqrt(2.0));
  return z * (2 * below - 1) + 2 * density - 1 / std::sqrt(M_PI);
}

TEST(EnsembleCrps, OfTwoSamplesByHand) {
  EXPECT_NEAR(EnsembleCrps({4, 1}, 2), (1 + 2) / 2.0 - 3 / 2.0, 1e-15);
  EXPECT_NEAR(EnsembleCrps({1, 1, 1}, 3), 2, 1e-15);
}

TEST(EnsembleCrps, ApproachesThatOfANormal) {
  const std::vector<double> draws = Normals(40000, 1);
  for (const double z : {-2.0, 0.0, 0.7}) EXPECT_NEAR(EnsembleCrps(draws, z), NormalCrps(z), 0.01);
}

// The mean over ensembles of three is that of the distribution; with m² instead of m(m−1) it would
// be larger by 1/(3·√π) = 0.19.
TEST(EnsembleCrps, IsFairToSmallEnsembles) {
  const std::vector<double> draws = Normals(60000, 2);
  double mean = 0;
  for (size_t i = 0; i < draws.size(); i += 3)
    mean += EnsembleCrps({draws[i], draws[i + 1], draws[i + 2]}, 0.5) / (draws.size() / 3);
  EXPECT_NEAR(mean, NormalCrps(0.5), 0.01);
}

TEST(EnergyScores, OfNumbersAreTheCrps) {
  const std::vector<double> draws = Normals(50, 3);
  const Eigen::MatrixXd row = Eigen::Map<const Eigen::RowVectorXd>(draws.data(), 50);
  const Eigen::VectorXd scores = EnergyScores(row, Eigen::RowVector2d(0.3, -1));
  EXPECT_NEAR(scores[0], EnsembleCrps(draws, 0.3), 1e-13);
  EXPECT_NEAR(scores[1], EnsembleCrps(draws, -1), 1e-13);
}

// In the plane, at the mean of a standard normal: E|X| − ½E|X − X'| = √(π/2)·(1 − 1/√2).
TEST(EnergyScores, AtTheMeanOfANormalInThePlane) {
  const std::vector<double> draws = Normals(12000, 4);
  const Eigen::MatrixXd plane = Eigen::Map<const Eigen::MatrixXd>(draws.data(), 2, 6000);
  EXPECT_NEAR(EnergyScores(plane, Eigen::Vector2d::Zero())[0],
              std::sqrt(M_PI / 2) * (1 - 1 / std::sqrt(2.0)), 0.01);
}

TEST(ComputeInterval, ExactQuantiles) {
  std::vector<double> draws(19);
  std::iota(draws.rbegin(), draws.rend(), 1.0);
  const CentralInterval ninety = ComputeInterval(draws, 0.9), half = ComputeInterval(draws, 0.5);
  EXPECT_NEAR(ninety.low, 1, 1e-12);
  EXPECT_NEAR(ninety.high, 19, 1e-12);
  EXPECT_NEAR(ninety.nominal, 0.9, 1e-12);
  EXPECT_NEAR(half.low, 5, 1e-12);
  EXPECT_NEAR(half.high, 15, 1e-12);
  EXPECT_TRUE(half.Contains(5.1));
  EXPECT_FALSE(half.Contains(15.1));
}

TEST(ComputeInterval, ReportsWhatFewSamplesCanReach) {
  const CentralInterval interval = ComputeInterval({1, 2, 3}, 0.9);
  EXPECT_EQ(interval.low, 1);
  EXPECT_EQ(interval.high, 3);
  EXPECT_NEAR(interval.nominal, 0.5, 1e-12);
}

// Another sample lies in the interval with the stated probability, for any number of samples.
TEST(ComputeInterval, CoversAnotherSampleAsOftenAsStated) {
  for (const int m : {4, 12, 40}) {
    const std::vector<double> all = Normals(3000 * (m + 1), 5);
    int inside = 0;
    double nominal = 0;
    for (int i = 0; i < 3000; ++i) {
      const auto begin = all.begin() + i * (m + 1);
      const CentralInterval interval = ComputeInterval({begin, begin + m}, 0.5);
      inside += interval.Contains(begin[m]);
      nominal = interval.nominal;
    }
    EXPECT_NEAR(inside / 3000.0, nominal, 0.03) << m;
  }
}

}  // namespace
}  // namespace drape
