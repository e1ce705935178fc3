// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "physics/cloth/cloth_model.h"
#include "physics/material/material.h"
#include "solver/fit/observed/lab_measurement.h"
#include "solver/fit/rollout_residuals.h"

namespace drape {

// Laboratory measurements as residuals: each point is a block, a strip at rest on its scene.
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
class Strips {
 public:
  Strips(std::vector<LabMeasurement> measurements, const Law& law);

  const std::vector<LabMeasurement>& measurements() const { return measurements_; }
  int num_points() const { return static_cast<int>(points_.size()); }

  // A block for each point, measurement by measurement, on backends of their own. The
  // parametrisation of their residuals is one of a single table. Models are shared with this
  // object.
  std::vector<RolloutBlock> MakeBlocks(const std::atomic<bool>* cancel = nullptr) const;

  // The readings that a material gives [°] or [1], shape [N]; nothing where a strip has no stable
  // equilibrium.
  std::optional<Eigen::VectorXd> Compute(const MaterialField& material) const;

 private:
  struct Lattice {
    std::shared_ptr<const ClothModel> model;
    std::shared_ptr<const Readout> readout;
  };
  struct Point {
    LabMeasurementKind kind = LabMeasurementKind::kCantilever;
    double reading = 0.0, sigma = 1.0;
    double tolerance = 0.0;  // of an equilibrium, ‖f‖ / weight
    double load = 0.0;       // of a pulled strip [N]
    bool follows = false;    // another point of its measurement
    std::vector<Lattice> lattices = {};
  };
  static Point MakeCantilever(const LabMeasurement& measurement, const LabPoint& point,
                              const Law& law);
  static Point MakeTensile(const LabMeasurement& measurement, const LabPoint& point,
                           const Law& law);

  std::vector<LabMeasurement> measurements_;
  std::vector<Point> points_;
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
std::vector<StripReport> ReportStrips(const Strips& strips, const MaterialField& material);

nlohmann::ordered_json StripsJson(const std::vector<StripReport>& reports);
// For a person: one line a point.
std::string StripTable(const std::vector<StripReport>& reports);

}  // namespace drape
