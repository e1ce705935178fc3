// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/inputs/readers/readers.h"

#include <utility>

namespace drape::attack {

std::vector<Reader> MakeReaders(const std::string& valid, const std::string& scratch) {
  std::vector<Reader> all;
  for (std::vector<Reader> some :
       {MakeClothReaders(valid, scratch), MakeSettingReaders(valid, scratch),
        MakeImageReaders(valid), MakeRecordReaders(scratch), MakeResultReaders(scratch),
        MakeSpaceReaders(valid), MakeGarmentReaders(valid), MakeObservationReaders()})
    for (Reader& reader : some) all.push_back(std::move(reader));
  return all;
}

}  // namespace drape::attack
