// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/assembly/assembly_part.h"

#include <glog/logging.h>

#include <algorithm>
#include <numeric>

namespace drape {
namespace {

using Vertices = std::vector<int>::iterator;

// Halves the vertices where they extend furthest, and so on.
void Split(const Eigen::VectorXd& x, Vertices begin, Vertices end, int first, int parts,
           std::vector<int>& part_of) {
  if (parts == 1 || begin == end) {
    for (auto it = begin; it != end; ++it) part_of[*it] = first;
    return;
  }
  Eigen::Array3d low = x.segment<3>(3 * *begin), high = low;
  for (auto it = begin; it != end; ++it) {
    low = low.min(x.segment<3>(3 * *it).array());
    high = high.max(x.segment<3>(3 * *it).array());
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const int left = parts / 2;
  const auto middle = begin + (end - begin) * left / parts;
  std::nth_element(begin, middle, end, [&](int a, int b) {
    const double of_a = x[3 * a + axis], of_b = x[3 * b + axis];
    return of_a < of_b || (of_a == of_b && a < b);
  });
  Split(x, begin, middle, first, left, part_of);
  Split(x, middle, end, first + left, parts - left, part_of);
}

template <class Element>
void ListElements(const std::vector<Element>& elements, const std::vector<int>& part_of,
                  std::vector<AssemblyPart>& parts,
                  std::vector<AssemblyPart::Element> AssemblyPart::*list) {
  constexpr int kCorners = std::extent_v<decltype(Element::vertex)>;
  for (int k = 0; k < static_cast<int>(elements.size()); ++k)
    for (int a = 0; a < kCorners; ++a) {
      std::vector<AssemblyPart::Element>& own = parts[part_of[elements[k].vertex[a]]].*list;
      if (own.empty() || own.back().index != k) own.push_back({k, 0});
      own.back().corners |= 1U << a;
    }
}

}  // namespace

std::vector<AssemblyPart> SplitAssembly(const Mesh& mesh, int parts) {
  CHECK_GE(parts, 1);
  std::vector<int> vertices(mesh.num_vertices()), part_of(mesh.num_vertices());
  std::iota(vertices.begin(), vertices.end(), 0);
  Split(mesh.rest_x, vertices.begin(), vertices.end(), 0, parts, part_of);
  std::vector<AssemblyPart> all(parts);
  ListElements(mesh.faces, part_of, all, &AssemblyPart::faces);
  ListElements(mesh.hinges, part_of, all, &AssemblyPart::hinges);
  return all;
}

}  // namespace drape
