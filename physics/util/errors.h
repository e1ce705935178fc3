// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

namespace drape {

// Bad input from outside the program: a file, a key, a value. The message is one line that says
// where the error is, what was found and what was expected. The tools print what() and exit with
// status 2. Programmer errors are CHECKs (glog); numerical failures are returned as a status.
class InputError : public std::runtime_error {
 public:
  // where: "cloth.obj:17" or "configs/a.json: key 'h'"; problem: "face has 4 corners, expected 3".
  InputError(const std::string& where, const std::string& problem)
      : std::runtime_error(where + ": " + problem) {}
};

// Tells the user on stderr what a reader made of an input that could mean something else, in one
// line. The same note about a second input is left out.
void NoteInput(const std::string& where, const std::string& note);

// The units in which a value would be within [least, most], for the end of an error about a value
// that is not: "; in cm it would be 0.06 m". Empty where none fits. `unit`: m, cm, mm, inch; kg/m2,
// g/m2; deg, rad; px/m, px/cm, px/mm, px/inch; N, gf, mN; N/m, gf/cm, kN/m; N*m, uN*m. No other
// unit has a hint.
std::string UnitHint(double value, const std::string& unit, double least, double most);

// Throws InputError for a value out of its usual range [least, most] that another unit would bring
// there, and tells it. Notes any other value out of that range.
void CheckUsual(const std::string& where, double value, const std::string& unit, double least,
                double most);

}  // namespace drape
