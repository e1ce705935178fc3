// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/inputs/files/file_readers.h"

namespace drape::attack {
namespace {

constexpr char kSquare[] = "v -.15 -.15 0\nv .15 -.15 0\nv .15 .15 0\nv -.15 .15 0\n";

std::string WithFaces(const std::string& faces) { return kSquare + faces; }

// A flat grid of n × n vertices in metres, as a cloth; `scale` of its coordinates.
std::string Grid(int n, const std::string& unit) {
  std::string text;
  for (int i = 0; i < n * n; ++i)
    text += "v " + std::to_string(i % n - n / 2) + unit + " " + std::to_string(i / n - n / 2) +
            unit + " 0\n";
  for (int i = 0; i + n < n * n; ++i) {
    if ((i + 1) % n == 0) continue;
    const auto corner = [&](int k) { return " " + std::to_string(k + 1); };
    text += "f" + corner(i) + corner(i + 1) + corner(i + n) + "\n";
    text += "f" + corner(i + 1) + corner(i + n + 1) + corner(i + n) + "\n";
  }
  return text;
}

// Corner `fan` is in very many faces.
std::string Fan(int faces) {
  std::string text = "v 0 0 0\n";
  for (int i = 0; i <= faces; ++i)
    text += "v ." + std::to_string(1000000 + i) + " ." + std::to_string(2000000 - i) + " 0\n";
  for (int i = 0; i < faces; ++i)
    text += "f 1 " + std::to_string(i + 2) + " " + std::to_string(i + 3) + "\n";
  return text;
}

}  // namespace

std::vector<BadFile> MakeBadMeshes() {
  const std::string good = WithFaces("f 1 2 3\nf 1 3 4\n");
  return {
      {"empty", ""},
      {"blanks", "\n\n  \n"},
      {"no faces", kSquare},
      {"no vertices", "f 1 2 3\n"},
      {"face 0", WithFaces("f 0 1 2\n")},
      {"face of 5", WithFaces("f 1 2 5\n")},
      {"face of -5", WithFaces("f -5 1 2\n")},
      {"face of 2^31", WithFaces("f 1 2 2147483648\n")},
      {"face of 2^63", WithFaces("f 1 2 9223372036854775808\n")},
      {"face of -2^31", WithFaces("f 1 2 -2147483648\n")},
      {"face of 1.5", WithFaces("f 1 2 1.5\n")},
      {"face of two", WithFaces("f 1 2\n")},
      {"crossed quadrangle", WithFaces("f 1 3 2 4\n")},
      {"a corner twice", WithFaces("f 1 2 2\n")},
      {"a face twice", WithFaces("f 1 2 3\nf 1 2 3\n")},
      {"a face turned over", WithFaces("f 1 2 3\nf 3 2 1\n")},
      {"three faces at an edge", kSquare + std::string("v 0 .3 0\nf 1 2 3\nf 2 1 4\nf 1 2 5\n")},
      {"two pieces", kSquare + std::string("v 1 1 0\nv 2 1 0\nv 2 2 0\nf 1 2 3\nf 5 6 7\n"), false},
      {"a lone vertex", good + "v 9 9 0\n", false},
      {"zero area", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"},
      {"all at one place", "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n"},
      {"nan", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
      {"inf", "v inf 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
      {"1e999", "v 1e999 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
      {"1e308", "v 1e308 0 0\nv -1e308 0 0\nv 0 1e308 0\nf 1 2 3\n", false},
      {"1e154", Grid(4, "e154"), false},
      {"1e-300", Grid(4, "e-300"), false},
      {"1e-160", Grid(4, "e-160"), false},
      {"a kilometre", Grid(4, "e3"), false},
      {"micrometres", Grid(4, "e-6"), false},
      {"decimal comma", "v 0,5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
      {"vertex of two", "v 0 0\n" + good},
      {"vertex of four", "v 0 0 0 1\n" + good},
      {"vertex without numbers", "v\n" + good},
      {"unknown line", "curv 1 2 3\n" + good, false},
      {"escape codes", "\x1b[31mred\n" + good, false},
      {"escape codes in a number", "v \x1b]0;x\x07 0 0\n" + good},
      {"no UTF-8", "v \xff\xfe 0 0\n" + good},
      {"a long word", "v " + std::string(5000, '9') + "x 0 0\n" + good},
      {"a long line", std::string(1 << 20, 'v') + "\n" + good, false},
      {"NUL", "v 0 0 0" + std::string(1, '\0') + "\n" + good},
      {"CR only", "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r"},
      {"vt of nan", "vt nan 0\n" + good},
      {"vt out of range", WithFaces("vt 0 0\nf 1/1 2/2 3/3\n")},
      {"vt of 2^31", WithFaces("vt 0 0\nf 1/2147483648 2/1 3/1\n")},
      {"vt all at one place", WithFaces("vt 0 0\nf 1/1 2/1 3/1\nf 1/1 3/1 4/1\n"), false},
      {"vt in millimetres",
       WithFaces(
           "vt -150 -150\nvt 150 -150\nvt 150 150\nvt -150 150\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"),
       false},
      {"vn out of range", WithFaces("f 1//1 2//1 3//1\n")},
      {"corner with four parts", WithFaces("f 1/1/1/1 2 3\n")},
      {"corner of slashes", WithFaces("f // // //\n")},
      {"some faces turned", WithFaces("f 1 2 3\nf 1 4 3\n")},
      {"standing cloth", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n"},
      {"binary", std::string("\x7f"
                             "ELF\0\0\0\1",
                             8)},
      {"JSON", "{\"v\": []}"},
      {"fan", Fan(3000), false},
      {"half a line", good.substr(0, good.size() - 4)}};
}

}  // namespace drape::attack
