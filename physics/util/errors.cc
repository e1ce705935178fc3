// SPDX-License-Identifier: Apache-2.0
#include "physics/util/errors.h"

#include <cstdio>
#include <mutex>
#include <set>
#include <string_view>

#include "physics/util/text_format.h"

namespace drape {
namespace {

struct Unit {
  std::string_view name, dimension;
  double size;  // in the first unit of its dimension
};
constexpr Unit kUnits[] = {{"m", "length", 1.0},
                           {"cm", "length", 1e-2},
                           {"mm", "length", 1e-3},
                           {"inch", "length", 0.0254},
                           {"kg/m2", "mass by area", 1.0},
                           {"g/m2", "mass by area", 1e-3},
                           {"deg", "angle", 1.0},
                           {"rad", "angle", 57.29577951308232},
                           {"px/m", "scale", 1.0},
                           {"px/cm", "scale", 1e2},
                           {"px/mm", "scale", 1e3},
                           {"px/inch", "scale", 1.0 / 0.0254},
                           {"N", "force", 1.0},
                           {"gf", "force", 9.80665e-3},
                           {"mN", "force", 1e-3},
                           {"N/m", "tension", 1.0},
                           {"gf/cm", "tension", 0.980665},
                           {"kN/m", "tension", 1e3},
                           {"N*m", "rigidity", 1.0},
                           {"uN*m", "rigidity", 1e-6}};

}  // namespace

std::string UnitHint(double value, const std::string& unit, double least, double most) {
  std::string hint;
  for (const Unit& own : kUnits) {
    if (own.name != unit) continue;
    for (const Unit& other : kUnits) {
      const double meant = value * other.size / own.size;
      if (&other == &own || other.dimension != own.dimension || meant < least || meant > most)
        continue;
      hint += Format("%s %s it would be %.4g", hint.empty() ? "; in" : ", in", other.name.data(),
                     meant);
    }
  }
  return hint.empty() ? hint : hint + " " + unit;
}

void CheckUsual(const std::string& where, double value, const std::string& unit, double least,
                double most) {
  if (value >= least && value <= most) return;
  const std::string found = Format("found %.6g ", value) + unit;
  const std::string usual = Format("%g … %g ", least, most) + unit;
  const std::string hint = UnitHint(value, unit, least, most);
  if (!hint.empty()) throw InputError(where, found + ", expected about " + usual + hint);
  NoteInput(where, found + ", which is unusual: most have " + usual);
}

void NoteInput(const std::string& where, const std::string& note) {
  static std::mutex mutex;
  static std::set<std::string> said;
  const std::scoped_lock lock(mutex);
  if (said.insert(note).second)
    std::fprintf(stderr, "note: %s\n", MakePrintableLine(where + ": " + note).c_str());
}

}  // namespace drape
