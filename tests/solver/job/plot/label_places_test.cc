// SPDX-License-Identifier: Apache-2.0
#include "solver/job/plot/label_places.h"

#include <gtest/gtest.h>

#include <cmath>

namespace drape {
namespace {

// Where a text of some 55 × 12 px begins and how high it is [px].
Eigen::Vector2d Place(const ChartLabel& label, double pixels) {
  const double before = label.align == ChartLabel::Align::kLeft    ? 0.0
                        : label.align == ChartLabel::Align::kRight ? 55.0
                                                                   : 27.0;
  return {pixels * label.at.x() + 8.5 * label.offset.x() - before,
          pixels * label.at.y() + 17.0 * label.offset.y()};
}

TEST(PlaceAround, KeepsTheUsualPlaceWhereThereIsRoom) {
  std::vector<ChartLabel> labels = {{.text = "fabric_1", .at = {0, 0}},
                                    {.text = "fabric_2", .at = {3, 1}}};
  PlaceAround({100, 100}, &labels);
  for (const ChartLabel& label : labels) {
    EXPECT_EQ(label.align, ChartLabel::Align::kLeft);
    EXPECT_EQ(label.offset, Eigen::Vector2d(0.8, 0.5));
  }
}

TEST(PlaceAround, NamesOfNearPointsDoNotOverlap) {
  std::vector<ChartLabel> labels;
  for (const Eigen::Vector2d& at :
       {Eigen::Vector2d(1.89, 1.38), Eigen::Vector2d(1.90, 1.385), Eigen::Vector2d(1.91, 1.40),
        Eigen::Vector2d(1.84, 1.38), Eigen::Vector2d(1.95, 1.37)})
    labels.push_back({.text = "fabric_1", .at = at});
  constexpr double kPixels = 260.0;
  PlaceAround({kPixels, kPixels}, &labels);
  for (std::size_t i = 0; i < labels.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const Eigen::Vector2d apart = Place(labels[i], kPixels) - Place(labels[j], kPixels);
      EXPECT_TRUE(std::abs(apart.x()) > 50 || std::abs(apart.y()) > 11) << i << " " << j;
    }
}

}  // namespace
}  // namespace drape
