// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "physics/simulation/rollout.h"
#include "solver/fit/lab/lab_measurement.h"

namespace drape {

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

}  // namespace drape
