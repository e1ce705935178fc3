// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/lab/strip_residuals.h"

#include <utility>

namespace drape {

StripResiduals::StripResiduals(std::vector<LabMeasurement> measurements, const Law& law)
    : measurements_(std::move(measurements)) {
  for (const LabMeasurement& measurement : measurements_)
    for (int point = 0; point < static_cast<int>(measurement.points.size()); ++point) {
      strips_.emplace_back(measurement, point, law);
      first_of_measurement_.push_back(point == 0);
    }
}

StripResiduals StripResiduals::Clone() const {
  StripResiduals clone;
  clone.measurements_ = measurements_;
  clone.first_of_measurement_ = first_of_measurement_;
  for (const StripSimulation& strip : strips_) clone.strips_.push_back(strip.Clone());
  return clone;
}

bool StripResiduals::Compute(const MaterialField& material, Eigen::VectorXd* readings,
                             RowMatrix* by_log_entry) {
  readings->resize(num_points());
  if (by_log_entry != nullptr) by_log_entry->resize(num_points(), kMaterialEntries);
  for (int i = 0; i < num_points(); ++i) {
    if (!first_of_measurement_[i]) strips_[i].StartLike(strips_[i - 1]);
    Eigen::VectorXd gradient;
    if (!strips_[i].Predict(material, &(*readings)[i],
                            by_log_entry == nullptr ? nullptr : &gradient))
      return false;
    if (by_log_entry != nullptr) by_log_entry->row(i) = gradient.transpose();
  }
  return true;
}

bool StripResiduals::Evaluate(const MaterialParametrisation& parametrisation,
                              const Eigen::VectorXd& theta, Eigen::VectorXd* residual,
                              RowMatrix* jacobian) {
  RowMatrix by_log_entry;
  if (!Compute(parametrisation.Material(theta), residual,
               jacobian == nullptr ? nullptr : &by_log_entry)) {
    return false;
  }
  if (jacobian != nullptr) *jacobian = by_log_entry * parametrisation.LogEntriesByTheta(theta);
  int row = 0;
  for (const LabMeasurement& measurement : measurements_)
    for (const LabPoint& point : measurement.points) {
      (*residual)[row] = ((*residual)[row] - point.reading) / measurement.sigma;
      if (jacobian != nullptr) jacobian->row(row) /= measurement.sigma;
      ++row;
    }
  return true;
}

}  // namespace drape
