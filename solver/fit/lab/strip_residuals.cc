// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/lab/strip_residuals.h"

#include <utility>

namespace drape {

StripResiduals::StripResiduals(std::vector<LabMeasurement> tests, const Law& law)
    : tests_(std::move(tests)) {
  for (const LabMeasurement& test : tests_)
    for (int point = 0; point < static_cast<int>(test.points.size()); ++point) {
      strips_.emplace_back(test, point, law);
      first_of_test_.push_back(point == 0);
    }
}

StripResiduals StripResiduals::Clone() const {
  StripResiduals clone;
  clone.tests_ = tests_;
  clone.first_of_test_ = first_of_test_;
  for (const StripSimulation& strip : strips_) clone.strips_.push_back(strip.Clone());
  return clone;
}

bool StripResiduals::Compute(const MaterialField& material, Eigen::VectorXd* readings,
                             RowMatrix* by_log_entry) {
  readings->resize(num_points());
  if (by_log_entry != nullptr) by_log_entry->resize(num_points(), kMaterialEntries);
  for (int i = 0; i < num_points(); ++i) {
    if (!first_of_test_[i]) strips_[i].StartLike(strips_[i - 1]);
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
  if (jacobian != nullptr) *jacobian = by_log_entry * *parametrisation.log_entries_by_theta();
  int row = 0;
  for (const LabMeasurement& test : tests_)
    for (const LabPoint& point : test.points) {
      (*residual)[row] = ((*residual)[row] - point.reading) / test.sigma;
      if (jacobian != nullptr) jacobian->row(row) /= test.sigma;
      ++row;
    }
  return true;
}

}  // namespace drape
