// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/targets/export_material.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "physics/cloth/assembly/assembly.h"
#include "physics/material/material_io.h"
#include "physics/mesh/disc.h"
#include "physics/util/json_input.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"
#include "tests/solver/prediction/exchange/twill.h"

namespace drape {
namespace {

using test::kTwill;

class ExportMaterialTest : public FileFixture {
 protected:
  static ExchangeRecord Record(std::optional<double> thickness = {}) {
    FabricSource source;
    source.material.name = "twill \"7\"";
    source.material.field = test::TestMaterial();
    RecordOptions options;
    options.thickness = thickness;
    return MakeRecord(source, MakeLaw("smooth"), options);
  }
  static nlohmann::json Parsed(ExportTarget target, const ExchangeRecord& record) {
    return ParseJson(ExportMaterial(target, record).text, "file");
  }
};

TEST_F(ExportMaterialTest, ArcsimReadsBackBitForBit) {
  const ExchangeRecord record = Record();
  const ExportedMaterial exported = ExportMaterial(ExportTarget::kArcsim, record);
  const Material back = ReadMaterial(Write("arcsim.json", exported.text));
  EXPECT_EQ(back.source_convention, "arcsim");
  EXPECT_TRUE(back.warnings.empty());
  EXPECT_EQ(back.field.density, record.source.material.field.density);
  for (int i = 0; i < kStretchEntries; ++i)
    EXPECT_EQ(back.field.stretch[0].entries()[i],
              record.source.material.field.stretch[0].entries()[i]);
  for (int i = 0; i < kBendEntries; ++i)
    EXPECT_EQ(back.field.bend[0].entries()[i], record.source.material.field.bend[0].entries()[i]);
  EXPECT_TRUE(exported.lost.empty());
}

TEST_F(ExportMaterialTest, CloHasItsUnits) {
  const ExchangeRecord record = Record(0.4e-3);
  const nlohmann::json fabric = Parsed(ExportTarget::kClo, record).at("mapPhysical");
  const LinearFabric& m = record.material;
  EXPECT_DOUBLE_EQ(fabric.at("fSuK").get<double>(), 1e3 * m.c11);
  EXPECT_DOUBLE_EQ(fabric.at("fSvK").get<double>(), 1e3 * m.c22);
  EXPECT_DOUBLE_EQ(fabric.at("fHK").get<double>(), 1e3 * m.shear);
  EXPECT_DOUBLE_EQ(fabric.at("fBuK").get<double>(), 1e9 * m.bend_weft);
  EXPECT_DOUBLE_EQ(fabric.at("fBvK").get<double>(), 1e9 * m.bend_warp);
  EXPECT_DOUBLE_EQ(fabric.at("fBhK").get<double>(), 1e9 * m.bend_bias);
  EXPECT_DOUBLE_EQ(fabric.at("fDensity").get<double>(), 1e-3 * m.density);
  EXPECT_DOUBLE_EQ(fabric.at("fThickness").get<double>(), 0.4);
  const auto without = ExportMaterial(ExportTarget::kClo, Record());
  EXPECT_THAT(without.lost, testing::Contains(testing::HasSubstr("--thickness")));
}

TEST_F(ExportMaterialTest, EveryTargetSaysWhatIsLostAndHowFarItIsVerified) {
  for (const ExportTarget target : kExportTargets) {
    const ExportedMaterial exported = ExportMaterial(target, Record());
    EXPECT_FALSE(exported.text.empty());
    EXPECT_EQ(exported.text.back(), '\n');
    EXPECT_FALSE(exported.evidence.empty());
    EXPECT_FALSE(exported.use.empty());
    EXPECT_EQ(exported.lost.empty(), target == ExportTarget::kArcsim);
    EXPECT_EQ(exported.tables.density, test::TestMaterial().density);
    EXPECT_EQ(exported.text.find('\t'), std::string::npos);
  }
}

TEST_F(ExportMaterialTest, TargetsThatBendAtHingesTakeTheFactor) {
  for (const ExportTarget target : kExportTargets) {
    const ExportedMaterial own = ExportMaterial(target, Record()),
                           given = ExportMaterial(target, Record(), {.bend_factor = 2.0});
    EXPECT_EQ(own.text != given.text, BendsAtHinges(target)) << ToString(target);
    const double factor = BendsAtHinges(target) ? 2.0 : 1.0;
    EXPECT_EQ(given.tables.bend[0].b[1][2], factor * own.tables.bend[0].b[1][2]);
    EXPECT_EQ(given.tables.stretch[0].c[0][0], own.tables.stretch[0].c[0][0]);
  }
  EXPECT_FALSE(BendsAtHinges(ExportTarget::kClo));
}

// What the exported numbers mean in other simulators: their energies, written again from their
// sources, against those of drapefit on the same triangles.

ExportedMaterial Export(ExportTarget target, const ExportOptions& options = {}) {
  FabricSource source;
  source.material.name = "twill";
  source.material.field = TablesFrom(kTwill);
  return ExportMaterial(target, MakeRecord(source, MakeLaw("smooth"), {}), options);
}

// The number after `key` and one of " = ", ": " in a file of any form.
double NumberAfter(const std::string& text, const std::string& key) {
  size_t at = text.find(key + " = ");
  if (at == std::string::npos) at = text.find("\"" + key + "\": ");
  EXPECT_NE(at, std::string::npos) << key << " in\n" << text;
  return std::stod(text.substr(text.find_first_of("=:", at) + 1));
}

// Energy of our hinges by angle: ½·κ·θ² with the exported meaning.
double OurHinge(const MaterialField& tables, const Hinge& hinge, double theta) {
  return BendEnergy(SmoothBend{}, hinge, tables.bend[0], theta);
}

constexpr double kSmallAngle = 1e-4;  // [rad]

double Heights(const Hinge& hinge) { return 2.0 * hinge.rest_area / hinge.rest_length; }

class Energies : public testing::Test {
 protected:
  void ForEachHinge(const std::function<void(const Hinge&)>& check) const {
    for (int i = 0; i < mesh_.num_hinges(); i += 7) check(mesh_.hinges[i]);
  }
  // Angle of the edge to the weft [rad], 0 … π/2.
  static double Direction(const Hinge& hinge) { return hinge.direction * M_PI / 4.0; }

  // ∂²ψ/∂ε² of a membrane energy by area at rest, along (a, b, γ), against c11, c22, c12 and G.
  static void ExpectMembrane(const std::function<double(const Eigen::Matrix2d&)>& energy,
                             const LinearFabric& expected) {
    constexpr double h = 1e-4;
    const auto second = [&](const Eigen::Matrix2d& d, const Eigen::Matrix2d& e) {
      const Eigen::Matrix2d I = Eigen::Matrix2d::Identity();
      return (energy(I + h * d + h * e) - energy(I + h * d - h * e) - energy(I - h * d + h * e) +
              energy(I - h * d - h * e)) /
             (4.0 * h * h);
    };
    Eigen::Matrix2d u, v, shear;
    u << 1, 0, 0, 0;
    v << 0, 0, 0, 1;
    shear << 0, 0.5, 0.5, 0;
    const double tolerance = 1e-4 * expected.c11;
    EXPECT_NEAR(second(u, u), expected.c11, tolerance);
    EXPECT_NEAR(second(v, v), expected.c22, tolerance);
    EXPECT_NEAR(second(u, v), expected.c12, tolerance);
    EXPECT_NEAR(second(shear, shear), expected.shear, tolerance);
  }
  static LinearFabric Meaning(const ExportedMaterial& exported) {
    return LineariseAtRest(exported.tables, MakeLaw("smooth"));
  }

  const Mesh mesh_ = MakeDisc({.target_vertices = 200});
};

TEST_F(Energies, OurMembraneIsTheLinearOne) {
  const StretchTable table = TablesFrom(kTwill).stretch[0];
  ExpectMembrane(
      [&](const Eigen::Matrix2d& F) {
        const GreenStrain<double> G =
            Green<double>({{F(0, 0), F(1, 0), 0.0}, {F(0, 1), F(1, 1), 0.0}});
        return StretchEnergy(Stress(EvaluateStretch(SmoothStretch{}, G, table), G), G);
      },
      kTwill);
}

// Stable neo-Hookean sheets: ½μ(|F|² − 2) − μ(J − 1) + ½k(J − 1)². SolverVBD adds μ to tri_ka,
// SolverSemiImplicit does not.
TEST_F(Energies, NewtonsMembranes) {
  for (const IsotropicChoice keep :
       {IsotropicChoice::kNearest, IsotropicChoice::kShear, IsotropicChoice::kStretch}) {
    const ExportedMaterial exported = Export(ExportTarget::kNewton, {.keep = keep});
    const double mu = NumberAfter(exported.text, "mu"),
                 lambda = NumberAfter(exported.text, "lambda");
    const auto sheet = [&](double k) {
      return [mu, k](const Eigen::Matrix2d& F) {
        const double J = F.determinant();
        return 0.5 * mu * (F.squaredNorm() - 2.0) - mu * (J - 1.0) +
               0.5 * k * (J - 1.0) * (J - 1.0);
      };
    };
    const double vbd_ka = lambda, semi_implicit_ka = lambda + mu;  // cloth_arguments()
    ExpectMembrane(sheet(vbd_ka + mu), Meaning(exported));
    ExpectMembrane(sheet(semi_implicit_ka), Meaning(exported));
  }
}

// ½·edge_ke·l·θ², edge_ke = 2·D/(h0 + h1) by the script (export_test runs it).
TEST_F(Energies, NewtonsHinges) {
  const ExportedMaterial exported = Export(ExportTarget::kNewton);
  const double rows[] = {NumberAfter(exported.text, "bend_warp"),
                         NumberAfter(exported.text, "bend_bias"),
                         NumberAfter(exported.text, "bend_weft")};
  ForEachHinge([&](const Hinge& hinge) {
    const int first = hinge.direction < 1.0 ? 0 : 1;
    const double D = rows[first] + (hinge.direction - first) * (rows[first + 1] - rows[first]);
    const double edge_ke = 2.0 * D / Heights(hinge);
    const double energy = 0.5 * edge_ke * hinge.rest_length * kSmallAngle * kSmallAngle;
    EXPECT_NEAR(energy / OurHinge(exported.tables, hinge, kSmallAngle), 1.0, 1e-6);
  });
}

// ½(ku(|Fu| − 1)² + kv(|Fv| − 1)² + ks(Fu·Fv)²).
TEST_F(Energies, Style3dsMembrane) {
  const ExportedMaterial exported = Export(ExportTarget::kStyle3d);
  const double ku = NumberAfter(exported.text, "c11"), kv = NumberAfter(exported.text, "c22"),
               ks = NumberAfter(exported.text, "shear");
  ExpectMembrane(
      [&](const Eigen::Matrix2d& F) {
        return 0.5 *
               (ku * std::pow(F.col(0).norm() - 1.0, 2) + kv * std::pow(F.col(1).norm() - 1.0, 2) +
                ks * std::pow(F.col(0).dot(F.col(1)), 2));
      },
      Meaning(exported));
}

// ½·k·3/(A0 + A1)·|Σ wᵢxᵢ|² with the cotangent weights w, of a hinge that is bent by a small angle.
// Along the three directions that have a number of their own.
TEST_F(Energies, Style3dsHinges) {
  const ExportedMaterial exported = Export(ExportTarget::kStyle3d);
  ForEachHinge([&](const Hinge& hinge) {
    std::array<Eigen::Vector3d, 4> x;
    for (int i = 0; i < 4; ++i) x[i] = mesh_.rest_x.segment<3>(3 * hinge.vertex[i]);
    const Eigen::Vector3d axis = (x[1] - x[0]).normalized();
    const auto cotangent = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
      return a.dot(b) / a.cross(b).norm();
    };
    const double c01 = cotangent(x[1] - x[0], x[2] - x[0]),
                 c02 = cotangent(x[1] - x[0], x[3] - x[0]),
                 c03 = cotangent(x[0] - x[1], x[2] - x[1]),
                 c04 = cotangent(x[0] - x[1], x[3] - x[1]);
    const double weight[] = {c03 + c04, c01 + c02, -c01 - c03, -c02 - c04};
    x[3] = x[0] + Eigen::AngleAxisd(kSmallAngle, axis) * (x[3] - x[0]);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int i = 0; i < 4; ++i) sum += weight[i] * x[i];
    const double energy_of_unit = 0.5 * 3.0 / hinge.rest_area * sum.squaredNorm();
    for (const auto& [direction, key] :
         {std::pair{0.0, "bend_warp"}, std::pair{1.0, "bend_bias"}, std::pair{2.0, "bend_weft"}}) {
      Hinge turned = hinge;
      turned.direction = direction;
      const double k = NumberAfter(exported.text, key) / 3.0;  // edge_aniso_ke()
      EXPECT_NEAR(k * energy_of_unit / OurHinge(exported.tables, turned, kSmallAngle), 1.0, 1e-5);
    }
  });
}

// ½·ρ·μ((|Fu| − 1)² + (|Fv| − 1)²) + ½·ρ·λ(Fu·Fv)² with the Lamé numbers of E and ν.
TEST_F(Energies, PpfsMembrane) {
  const ExportedMaterial exported = Export(ExportTarget::kPpf);
  const double E = NumberAfter(exported.text, "shell_young_modulus"),
               nu = NumberAfter(exported.text, "shell_poisson_ratio"),
               rho = NumberAfter(exported.text, "shell_density");
  EXPECT_LT(nu, 0.5);
  EXPECT_GT(nu, 0.0);
  const double mu = E / (2.0 * (1.0 + nu)), lambda = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  ExpectMembrane(
      [&](const Eigen::Matrix2d& F) {
        return 0.5 * rho * mu *
                   (std::pow(F.col(0).norm() - 1.0, 2) + std::pow(F.col(1).norm() - 1.0, 2)) +
               0.5 * rho * lambda * std::pow(F.col(0).dot(F.col(1)), 2);
      },
      Meaning(exported));
}

// ½·1.28e-5·(bend + bend_warp·sin²ψ + bend_weft·cos²ψ)·l²/(A0 + A1)·ρ·θ² with ψ the angle of the
// edge to the warp; ours is linear in between the rows, so it is compared at the rows.
TEST_F(Energies, PpfsHinges) {
  const ExportedMaterial exported = Export(ExportTarget::kPpf);
  const double bend = NumberAfter(exported.text, "\nbend"),
               warp = NumberAfter(exported.text, "bend_warp"),
               weft = NumberAfter(exported.text, "bend_weft"),
               rho = NumberAfter(exported.text, "shell_density");
  ForEachHinge([&](const Hinge& hinge) {
    for (const double direction : {0.0, 1.0, 2.0}) {
      Hinge turned = hinge;
      turned.direction = direction;
      const double psi = M_PI / 2.0 - Direction(turned);
      const double stiffness =
          bend + warp * std::pow(std::sin(psi), 2) + weft * std::pow(std::cos(psi), 2);
      const double energy = 0.5 * 1.28e-5 * stiffness * hinge.rest_length * hinge.rest_length /
                            hinge.rest_area * rho * kSmallAngle * kSmallAngle;
      EXPECT_NEAR(energy / OurHinge(exported.tables, turned, kSmallAngle), 1.0, 1e-6);
    }
  });
}

}  // namespace
}  // namespace drape
