// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/pool_start.h"

#include <optional>
#include <set>

#include "losses/outline/outline.h"

namespace drape {

std::vector<MaterialField> ListPooledTables(const OutlinePool& pool,
                                            const std::vector<Observation>& observations, int count,
                                            double density) {
  std::vector<std::vector<PooledMatch>> nearest;
  for (const Observation& each : observations)
    if (const std::optional<Eigen::VectorXd> radius = each.MeasureRadius(kPoolAngles))
      nearest.push_back(
          FindNearest(pool, VerticalProfile(*radius, each.outline_camera(), each.discs), count));
  std::vector<MaterialField> tables;
  std::set<int> taken;
  for (int rank = 0; rank < count; ++rank)
    for (const std::vector<PooledMatch>& of_image : nearest)
      if (rank < int(of_image.size()) && int(tables.size()) < count &&
          taken.insert(of_image[rank].drape).second)
        tables.push_back(SpecimenMaterial(of_image[rank].numbers, density));
  return tables;
}

}  // namespace drape
