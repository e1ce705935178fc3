// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>

namespace drape {

// Four and eight doubles that the compiler maps to the vector registers of the machine (a GCC and
// Clang extension).
using Vec4 = double __attribute__((vector_size(32)));
using Vec8 = double __attribute__((vector_size(64)));

// The doubles in T = Vec8, Vec4 or double.
template <class T>
inline constexpr int kLanes = 1;
template <>
inline constexpr int kLanes<Vec4> = 4;
template <>
inline constexpr int kLanes<Vec8> = 8;

// Loads T = Vec8, Vec4 or double from an address of any alignment.
template <class T>
inline __attribute__((always_inline)) T LoadAs(const double* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}
template <class T>
inline __attribute__((always_inline)) void Store(const T& value, double* to) {
  std::memcpy(to, &value, sizeof value);
}

// Calls visit.template operator()<V>(first) for chunks of V registers, V ≤ Max, which together
// cover `count` registers: as many chunks of the maximum length as fit, then one shorter chunk.
template <int Max, class Visit>
inline void ForEachChunk(int count, Visit visit) {
  int first = 0;
  for (; first + Max <= count; first += Max) visit.template operator()<Max>(first);
  if constexpr (Max > 1) {
    const int rest = count - first;
    ForEachChunk<Max - 1>(rest, [&]<int V>(int at) { visit.template operator()<V>(first + at); });
  }
}

}  // namespace drape
