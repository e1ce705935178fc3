// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "physics/material/material.h"
#include "physics/simulation/rollout.h"
#include "physics/util/options/field.h"
#include "solver/fit/parametrisation.h"

namespace drape {

// What a textile laboratory measures on a strip, as data of a fit.

enum class LabMeasurementKind {
  kCantilever,  // overhang length [m] → chord angle below the horizontal [°] [ASTM D1388]
  kTensile      // force [N] → stretch, length by rest length (strip method)
};
constexpr auto EnumNames(LabMeasurementKind) {
  return MakeNames<LabMeasurementKind>(
      {{LabMeasurementKind::kCantilever, "cantilever"}, {LabMeasurementKind::kTensile, "tensile"}});
}

// What was set and what was read: overhang and angle, or force and stretch.
struct LabPoint {
  double set = 0.0;
  double reading = 0.0;
};

// One strip, cut at `direction` to the weft.
struct LabMeasurement {
  std::string name = {};  // file name without folder and extension
  std::string file = {};
  LabMeasurementKind kind = LabMeasurementKind::kCantilever;
  double direction = 0.0;             // [°]: 0 weft, 90 warp, 45 bias
  double length = 0.0;                // at rest between the grips [m]; tensile only
  double width = 0.0;                 // [m]; tensile only: of a cantilever it cancels
  double sigma = 1.0;                 // standard deviation of a reading [°] or [1]
  std::vector<LabPoint> points = {};  // by rising overhang or force
  double density = 0.0;               // of the fabric, as the file states [kg/m²]; 0: it does not
};

// The measurements of one file that a user names, in one of two forms. Throws InputError (file,
// key, value, what was expected) for a key that is unknown or missing, a value out of range or in
// another unit (CheckUsual), and strips without a loading or without a stretch.
//
// One measurement, whose points may be in any order; `width` of a cantilever may be left out:
//   {"test": "cantilever", "direction": 0, "sigma": 1.0, "width": 0.025,
//    "points": [{"length": 0.06, "angle": 41.5}, …]}
//   {"test": "tensile", "direction": 90, "length": 0.2, "width": 0.05, "sigma": 0.002,
//    "points": [{"force": 5.0, "stretch": 1.02}, …]}
//
// The tensile tests of a U3M 1.1 material: raw data of a FAB device, or a .u3m that names their
// file in material.physics.devices.fab, relative to itself. Strips of width 5 cm are stretched at a
// gauge of 8 cm (S2) along the length (L: warp), the width (W: weft) and the bias (B); their names
// are the file's with "_warp", "_weft" or "_bias". Their samples alternate distance [cm] and force
// [gf], cycle by cycle; the file is JSON with
//   "raw_data": {"B" | "L" | "W": {"S2": {"width" [cm], "samplesTree": [[d, f, d, f, …], …]}}}.
// The loading of each strip with the largest force counts. It begins where the strip is taut: its
// first sample is the rest length, its mean force over the first samples zero. The points are means
// of ten equal parts of the force. The readings' standard deviation is one hundredth of the largest
// strain, at least 1e-3: the file states none. The density is raw_data.M, or, before it,
// material.physics.weight of a .u3m, both in g/m². Other members (bending loops, thickness) are not
// read.
std::vector<LabMeasurement> ReadLabMeasurements(const std::string& path);

// One reading of a laboratory measurement, computed: a strip at rest on its scene.
//
// Cantilever: a beam. The chord runs from the clamp's edge to the tip. A strip that is free to curl
// across has D·(1 − ν²) by the Poisson ratio −1/3 of the hinge formula, which is no property of a
// cloth; the strip's load is lowered by as much, so that a plate rigidity D bends like a beam of
// EI = D and a fit's D is the flexural rigidity G of the standard. The width cancels. The hinges of
// a triangular lattice lie in three directions only; two lattices, one with rows along the strip
// and one with rows across, average a bend table over directions as an unstructured disc does.
//
// Tensile: held at one end, a dead load [N/m] at the other, which is free to narrow. It is kept
// flat: wrinkles of a pulled strip carry no load that a load cell measures.
class StripSimulation {
 public:
  // Point `point` of a measurement.
  StripSimulation(const LabMeasurement& measurement, int point, const Law& law);
  // Starts from the present shape.
  StripSimulation Clone() const;
  // Starts the first time from the shape of another point of its measurement, to scale.
  void StartLike(const StripSimulation& neighbour);

  // The reading [°] or [1] for a material, and, if not null, its gradient by the logarithms of the
  // 39 table entries. Starts from the shape of the last success. False when no stable equilibrium
  // or derivative is found.
  [[nodiscard]] bool Predict(const MaterialField& material, double* reading,
                             Eigen::VectorXd* by_log_entry);

 private:
  explicit StripSimulation(LabMeasurementKind kind) : kind_(kind) {}
  struct Lattice {
    StepSolver solver;
    double clamp;          // where the strip begins to bend or stretch, x [m]
    std::vector<int> end;  // vertices whose mean is the tip
    Eigen::VectorXd x;     // last equilibrium [m], shape [3V]
  };
  void AddLattice(Mesh mesh, Scene scene, const Law& law, double clamp);
  static double RestEnd(const Lattice& lattice);  // x of its end at rest [m]
  bool Settle(Lattice& lattice, const MaterialField& strip) const;
  double Reading(const Lattice& lattice, Eigen::Vector3d* by_tip) const;
  MaterialField OnStrip(const MaterialField& material) const;
  bool Differentiate(Lattice& lattice, const MaterialField& strip, const Eigen::Vector3d& by_tip,
                     Eigen::VectorXd* by_log_entry) const;

  LabMeasurementKind kind_;
  double tolerance_ = 0.0;  // of an equilibrium, ‖f‖ / weight
  double load_ = 0.0;       // of a pulled strip [N]
  std::vector<Lattice> lattices_;
};

// All points of the laboratory measurement of a fit, measurement by measurement: the strips that
// compute them.
class StripResiduals {
 public:
  StripResiduals(std::vector<LabMeasurement> measurements, const Law& law);
  // Shares meshes; starts from the present shapes of the strips.
  StripResiduals Clone() const;

  const std::vector<LabMeasurement>& measurements() const { return measurements_; }
  int num_points() const { return static_cast<int>(strips_.size()); }

  // (computed − read)/σ of each point, shape [N], and, if not null, its derivative by θ, shape
  // [N, P]. The parametrisation is one of a single table. False where a strip has no stable
  // equilibrium.
  [[nodiscard]] bool Evaluate(const MaterialParametrisation& parametrisation,
                              const Eigen::VectorXd& theta, Eigen::VectorXd* residual,
                              RowMatrix* jacobian);
  // The readings that a material gives [°] or [1], shape [N]. False as above.
  [[nodiscard]] bool Compute(const MaterialField& material, Eigen::VectorXd* readings,
                             RowMatrix* by_log_entry = nullptr);

 private:
  StripResiduals() = default;

  std::vector<LabMeasurement> measurements_;
  std::vector<StripSimulation> strips_;
  std::vector<bool> first_of_measurement_;  // of each strip
};

// A measurement beside what the fitted material makes of it.
struct StripReport {
  LabMeasurement measurement;
  std::vector<double> computed;  // of each point, as LabPoint::reading
  double density = 0.0;          // [kg/m²]
};

// What a laboratory derives from a cantilever by hand [ASTM D1388].
struct BendingEstimate {
  double length = 0.0;    // bending length c = L/Γ(angle)^⅓, half the overhang L at 41.5° [m]
  double rigidity = 0.0;  // flexural rigidity G = ρ·g·c³ [N·m]
};
// NaN for an angle [°] that is not between 0 and 90.
BendingEstimate EstimateBending(double overhang, double angle, double density);

// Returns no report when a strip cannot be computed.
std::vector<StripReport> ReportStrips(const StripResiduals& strips, const MaterialField& material);

nlohmann::ordered_json StripsJson(const std::vector<StripReport>& reports);
// For a person: one line a point.
std::string StripTable(const std::vector<StripReport>& reports);

}  // namespace drape
