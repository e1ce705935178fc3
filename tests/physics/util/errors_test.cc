// SPDX-License-Identifier: Apache-2.0
#include "physics/util/errors.h"

#include <cmath>

#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using ::testing::internal::CaptureStderr;
using ::testing::internal::GetCapturedStderr;

TEST(UnitHint, NamesTheUnitsThatFit) {
  EXPECT_EQ(UnitHint(0.27, "g/m2", 10, 1500), "; in kg/m2 it would be 270 g/m2");
  EXPECT_EQ(UnitHint(150, "kg/m2", 0.01, 1.5), "; in g/m2 it would be 0.15 kg/m2");
  EXPECT_EQ(UnitHint(30, "m", 0.1, 0.6), "; in cm it would be 0.3 m");
  EXPECT_EQ(UnitHint(72, "px/m", 100, 5000), "; in px/inch it would be 2835 px/m");
  EXPECT_EQ(UnitHint(M_PI / 4, "deg", 2, 90), "; in rad it would be 45 deg");
  EXPECT_EQ(UnitHint(6, "m", 0.03, 0.2), "; in cm it would be 0.06, in inch it would be 0.1524 m");
  EXPECT_EQ(UnitHint(500, "N", 0.1, 10), "; in gf it would be 4.903, in mN it would be 0.5 N");
  EXPECT_EQ(UnitHint(8, "N*m", 1e-9, 0.1), "; in uN*m it would be 8e-06 N*m");
  EXPECT_EQ(UnitHint(3e5, "m", 0.1, 0.6), "");
  EXPECT_EQ(UnitHint(3, "furlong", 0, 1), "");
}

TEST(CheckUsual, RefusesWhatAnotherUnitExplainsAndNotesTheRest) {
  CaptureStderr();
  CheckUsual("a", 0.3, "m", 0.1, 0.6);
  EXPECT_EQ(GetCapturedStderr(), "");
  EXPECT_INPUT_ERROR(CheckUsual("a.json: key 'b'", 30, "m", 0.1, 0.6),
                     "a.json: key 'b': found 30 m, expected about 0.1 … 0.6 m; in cm it would be "
                     "0.3 m");
  CaptureStderr();
  CheckUsual("a", 0.7, "m", 0.1, 0.6);
  CheckUsual("another", 0.7, "m", 0.1, 0.6);
  EXPECT_EQ(GetCapturedStderr(), "note: a: found 0.7 m, which is unusual: most have 0.1 … 0.6 m\n");
}

}  // namespace
}  // namespace drape
