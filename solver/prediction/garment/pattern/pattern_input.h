// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "physics/util/json_input.h"
#include "solver/prediction/garment/pattern/pattern.h"

// Internal to this room: what the readers of both formats share. All functions throw InputError.
namespace drape {

// Points [x, y] of a panel's plane, multiplied by `metres` [m].
std::vector<Eigen::Vector2d> ReadPoints(const JsonInput& input, double metres);

// Makes the edge between two points from its entry.
using EdgeReader = std::function<PatternEdge(const JsonInput&, const Eigen::Vector2d& begin,
                                             const Eigen::Vector2d& end)>;
// Edges with "endpoints", two indices of vertices, which must form one closed loop.
PatternLoop ReadLoop(const JsonInput& edges, const std::vector<Eigen::Vector2d>& vertices,
                     const EdgeReader& read_edge);

// "translation" [x, y, z], times `metres`, and "rotation" about the fixed axes x, y, z in this
// order [degrees]; both may be absent.
Eigen::Isometry3d ReadPlacement(const JsonInput& panel, double metres);

// A panel by its name, and one of its edges by its number.
int ReadPanelName(const JsonInput& name, const Pattern& pattern);
PanelEdge ReadPanelEdge(const JsonInput& name, const JsonInput& edge, const Pattern& pattern);

// The pattern of a GarmentCode file, not checked by FindProblem.
Pattern ReadGarmentCode(const JsonInput& input);

}  // namespace drape
