// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

namespace drape {

// The mean of repeated measurements, or a difference of two means, in the unit of the values.
struct SampleMean {
  double mean = 0.0;
  int count = 0;                // of values
  double freedom = 0.0;         // degrees of freedom of the spread; 0: the spread is unknown
  double deviation = 0.0;       // standard deviation of a value
  double standard_error = 0.0;  // of the mean, by that spread
  double shared = 0.0;  // standard deviation of an error that all values share, such as the scale's

  bool spread_is_known() const { return freedom > 0.0; }
  // Half the width of the interval of 90 %: the hypotenuse of that of Student's t and that of the
  // shared error. None where the spread is unknown.
  std::optional<double> HalfWidth() const;
};

// The mean of the strata's means, such as the two faces of a specimen. The values of all strata
// have one standard deviation, which is pooled. Each stratum has at least one value.
SampleMean MeanOfStrata(const std::vector<std::vector<double>>& strata, double shared);

// a − b of independent means of other standard deviations [Welch 1947].
SampleMean WelchDifference(const SampleMean& a, const SampleMean& b);

}  // namespace drape
