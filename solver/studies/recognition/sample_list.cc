// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/recognition/sample_list.h"

#include <algorithm>
#include <map>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {

SampleList ListSamples(const std::vector<FitCell>& cells, const std::vector<std::string>& names,
                       const std::vector<ObservedCapture>& images) {
  std::map<int, std::vector<const FitCell*>> by_fabric;
  for (const FitCell& cell : cells)
    if (std::find(names.begin(), names.end(), cell.name) != names.end())
      by_fabric[cell.captures[0].fabric].push_back(&cell);
  std::erase_if(by_fabric, [](const auto& each) { return each.second.size() < 2; });
  if (by_fabric.size() < 2)
    throw InputError("option 'data'", Format("found %d fabric(s) with two samples or more to "
                                             "recognise, expected at least two",
                                             static_cast<int>(by_fabric.size())));
  SampleList list;
  for (const auto& [fabric, of_fabric] : by_fabric) {
    for (const FitCell* cell : of_fabric) {
      list.samples.push_back({cell->name, list.num_fabrics()});
      for (const ObservedCapture& image : images)
        if (image.capture.fabric == fabric && image.capture.sample == cell->captures[0].sample)
          list.samples.back().images.push_back(&image);
    }
    list.fabrics.push_back(fabric);
  }
  return list;
}

}  // namespace drape
