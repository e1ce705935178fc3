// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/assembly/assembly.h"

#include <glog/logging.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "physics/cloth/assembly/element_blocks.h"
#include "physics/cloth/contact/surface_contact.h"
#include "physics/mesh/self_intersection.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

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

using Columns = DeformationGradient<double>;

void AddOuterForces(const ClothModel& model, double density, const Eigen::VectorXd& x,
                    Eigen::VectorXd& force) {
  if (model.scene.gravity)
    for (int i = 0; i < model.mesh.num_vertices(); ++i)
      force.segment<3>(3 * i) += density * model.vertex_area[i] * *model.scene.gravity;
  for (int i : model.held)
    force.segment<3>(3 * i) -= model.scene.handles->stiffness *
                               (x.segment<3>(3 * i) - model.mesh.rest_x.segment<3>(3 * i));
  for (const VertexLoad& load : model.loads) force.segment<3>(3 * load.vertex) += load.force;
  if (model.scene.contact)
    for (int i = 0; i < model.mesh.num_vertices(); ++i)
      force.segment<3>(3 * i) +=
          ContactForce(*model.scene.contact, model.vertex_area[i], x.segment<3>(3 * i));
}

// Calls add(k, corners) for the elements of a part, or for `count` ones as a whole where it is
// null. Both loops call one copy of it: in two copies the compiler could contract products and sums
// differently, and the sums would have other bits.
template <class Add>
void ForEachElement(const AssemblyPart* part,
                    std::vector<AssemblyPart::Element> AssemblyPart::*list, int count,
                    const Add& add) {
  const auto add_once = [&add](int k, unsigned corners) __attribute__((noinline)) {
    asm("" : "+r"(corners));  // hides their value: no copy is made for whole elements
    add(k, corners);
  };
  if (part == nullptr) {
    for (int k = 0; k < count; ++k) add_once(k, ~0U);
  } else {
    for (const auto& [k, corners] : part->*list) add_once(k, corners);
  }
}

// Calls add(part) for all parts at the same time, or for the whole: null.
template <class Add>
void ForEachPart(const AssemblyParts& parts, const Add& add) {
  if (parts.empty()) return add(nullptr);
  const int count = static_cast<int>(parts.size());
#pragma omp parallel for num_threads(count) if (count > 1)
  for (int k = 0; k < count; ++k) add(&parts[k]);
}

// Adds stretch and bend of a step: f and h2·H. A may be null (forces only).
template <class Law>
void AddStretchStep(const Law& law, const ClothModel& model, const MaterialField& material,
                    const double* x, double h2, double* force, BlockMatrix* A,
                    const AssemblyPart* part) {
  const auto add = [&](int f, unsigned corners) {
    const Face& face = model.mesh.faces[f];
    const Columns F = GatherColumns(face, x);
    const StretchCoefficients<double> k = EvaluateStretch(law, Green(F), material.stretch_of(f));
    ScatterColumns(face, StretchForce(k, F), force, corners);
    if (A != nullptr)
      AddFaceBlocks(face, F, HeldStiffness(k), RampStress(k), h2 * face.area,
                    &model.pattern.face_block[9 * f], *A, corners);
  };
  ForEachElement(part, &AssemblyPart::faces, model.mesh.num_faces(), add);
}

template <class Law>
void AddBendStep(const Law& law, const ClothModel& model, const MaterialField& material,
                 const double* x, double h2, double* force, BlockMatrix* A,
                 const AssemblyPart* part) {
  const auto add = [&](int e, unsigned corners) {
    const Hinge& hinge = model.mesh.hinges[e];
    const HingeCorners places = GatherCorners(hinge, x);
    const double theta = DihedralAngle(places);
    const HingeGradient d = AngleGradient(EvaluateWings(places));
    const double kappa = HingeStiffness(law, hinge, material.bend_of(e), theta);
    const HingeMeasure mu = law.Measure(theta);
    for (int a = 0; a < 4; ++a)
      if ((corners >> a & 1U) != 0) AddTo(force, hinge.vertex[a], (-kappa * mu.value) * d.d[a]);
    if (A != nullptr)
      AddHingeBlocks(d, h2 * kappa * mu.slope, &model.pattern.hinge_block[16 * e], *A, corners);
  };
  ForEachElement(part, &AssemblyPart::hinges, model.mesh.num_hinges(), add);
}

void AddElements(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x,
                 double h2, Eigen::VectorXd& force, BlockMatrix* A, const AssemblyParts& parts) {
  ForEachPart(parts, [&](const AssemblyPart* part) {
    VisitLaws(
        model,
        [&](const auto& law) {
          AddStretchStep(law, model, material, x.data(), h2, force.data(), A, part);
        },
        [&](const auto& law) {
          AddBendStep(law, model, material, x.data(), h2, force.data(), A, part);
        });
  });
}

template <class Law>
void AddStretchDerivative(const Law& law, const ClothModel& model, const MaterialField& material,
                          const double* x, const double* w, double h, BlockMatrix& out,
                          const AssemblyPart* part) {
  const auto add = [&](int f, unsigned corners) {
    const Face& face = model.mesh.faces[f];
    Matrix6 Q;
    StretchStepDerivative(law, GatherColumns(face, x), material.stretch_of(f),
                          GatherColumns(face, w), h, Q);
    AddFaceBlocks(face, Q, face.area, &model.pattern.face_block[9 * f], out, corners);
  };
  ForEachElement(part, &AssemblyPart::faces, model.mesh.num_faces(), add);
}

template <class Law>
void AddBendDerivative(const Law& law, const ClothModel& model, const MaterialField& material,
                       const double* x, const double* w, double h, BlockMatrix& out,
                       const AssemblyPart* part) {
  const auto add = [&](int e, unsigned corners) {
    const Hinge& hinge = model.mesh.hinges[e];
    AddHingeBlocks(EvaluateBendStepRates(law, hinge, material.bend_of(e), GatherCorners(hinge, x),
                                         GatherCorners(hinge, w), h),
                   1.0, &model.pattern.hinge_block[16 * e], out, corners);
  };
  ForEachElement(part, &AssemblyPart::hinges, model.mesh.num_hinges(), add);
}

// Evaluates the faces, or the hinges, of a part and adds their forces. The part that has the first
// corner of an element keeps its state.
template <class Law>
void EvaluateFaces(const Law& law, const ClothModel& model, const MaterialField& material,
                   const double* x, double* force, const AssemblyPart* part,
                   std::vector<ElementStates::OfFace>& states) {
  const auto add = [&](int f, unsigned corners) {
    const Face& face = model.mesh.faces[f];
    const Columns F = GatherColumns(face, x);
    const GreenStrain<double> G = Green(F);
    const StretchStress<Dual<3>> by_strain = StressByStrain(law, G, material.stretch_of(f));
    const StretchStress<double> S = Values(by_strain);
    ScatterColumns(face, F * StretchStress<double>{-S.uu, -S.vv, -S.uv}, force, corners);
    if ((corners & 1U) != 0) states[f] = {by_strain, face.area * StretchEnergy(S, G)};
  };
  ForEachElement(part, &AssemblyPart::faces, model.mesh.num_faces(), add);
}
template <class Law>
void EvaluateHinges(const Law& law, const ClothModel& model, const MaterialField& material,
                    const double* x, double* force, const AssemblyPart* part,
                    std::vector<ElementStates::OfHinge>& states) {
  const auto add = [&](int e, unsigned corners) {
    const Hinge& hinge = model.mesh.hinges[e];
    const BendTable& table = material.bend_of(e);
    const HingeCorners places = GatherCorners(hinge, x);
    const double theta = DihedralAngle(places);
    const HingeGradient d = AngleGradient(EvaluateWings(places));
    const Dual<1> kappa = HingeStiffness(law, hinge, table, Dual<1>(theta, 0));
    const HingeMeasure mu = law.Measure(theta);
    const double moment = StepMoment(kappa.a, mu, 0.0, 1.0);
    for (int a = 0; a < 4; ++a)
      if ((corners >> a & 1U) != 0) AddTo(force, hinge.vertex[a], -moment * d.d[a]);
    if ((corners & 1U) != 0)
      states[e] = {moment, StepMomentByTheta(kappa, mu, 0.0, 1.0),
                   BendEnergy(law, hinge, table, theta)};
  };
  ForEachElement(part, &AssemblyPart::hinges, model.mesh.num_hinges(), add);
}

void AddFaceStiffness(const ClothModel& model, const ElementStates& states,
                      const StressField& stress, const double* x, BlockMatrix& K,
                      const AssemblyPart* part) {
  const auto add = [&](int f, unsigned corners) {
    const Face& face = model.mesh.faces[f];
    AddFaceBlocks(face, GatherColumns(face, x), SymmetricPart(states.faces[f].stress), stress[f],
                  face.area, &model.pattern.face_block[9 * f], K, corners);
  };
  ForEachElement(part, &AssemblyPart::faces, model.mesh.num_faces(), add);
}
void AddHingeStiffness(const ClothModel& model, const ElementStates& states, const double* x,
                       BlockMatrix& K, const AssemblyPart* part) {
  const auto add = [&](int e, unsigned corners) {
    const HingeWings wings = EvaluateWings(GatherCorners(model.mesh.hinges[e], x));
    BendStepRates rates{AngleGradient(wings), {}, states.hinges[e].moment, ComputeRates(wings)};
    for (int a = 0; a < 4; ++a) rates.grad_s.d[a] = states.hinges[e].slope * rates.grad.d[a];
    AddHingeBlocks(rates, -1.0, &model.pattern.hinge_block[16 * e], K, corners);
  };
  ForEachElement(part, &AssemblyPart::hinges, model.mesh.num_hinges(), add);
}

// Calls visit(pairs) with the active pairs at x in a scene that has self-contact. They are found by
// `self`, or by a search for this x alone. A shape that is not finite touches nothing.
template <class Visit>
void VisitActivePairs(const ClothModel& model, const Eigen::VectorXd& x, SurfaceContact* self,
                      const Visit& visit) {
  if (!HasSelfContact(model.scene) || !x.allFinite()) return;
  std::optional<SurfaceContact> local;
  if (self == nullptr) self = &local.emplace(MakeSelfContact(model));
  visit(self->FindActivePairs(x));
}

void AddSelfStiffness(const ClothModel& model, const Eigen::VectorXd& x, StiffnessPart part,
                      double scale, SurfaceContact* self, BlockMatrix& A) {
  VisitActivePairs(model, x, self, [&](const ActivePairs& pairs) {
    ForEachPairStiffness(pairs, part, [&](int i, int j, const Eigen::Matrix3d& block) {
      CHECK(AddSymmetricBlock(model.pattern, i, j, scale * block, A));
    });
  });
}

}  // namespace

DampedVelocity::DampedVelocity(const MaterialField& material, const Eigen::VectorXd& w, double h)
    : factor_(1.0 + material.dynamics.stiffness_damping / h), data_(w.data()) {
  if (material.dynamics.stiffness_damping == 0.0) return;
  scaled_ = factor_ * w;
  data_ = scaled_.data();
}

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

void AssembleForce(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x,
                   Eigen::VectorXd& force, SurfaceContact* self, const AssemblyParts& parts) {
  force.setZero(x.size());
  AddOuterForces(model, material.density, x, force);
  AddElements(model, material, x, 0.0, force, nullptr, parts);
  VisitActivePairs(model, x, self, [&](const ActivePairs& pairs) { AddPairForces(pairs, force); });
}

void AssembleStep(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x,
                  double h, Eigen::VectorXd& force, BlockMatrix& A, SurfaceContact* self,
                  const AssemblyParts& parts) {
  force.setZero(x.size());
  A.SetZero();
  AddOuterForces(model, material.density, x, force);
  const Dynamics& moving = material.dynamics;
  AddElements(model, material, x, h * (h + moving.stiffness_damping), force, &A, parts);
  for (int i = 0; i < model.mesh.num_vertices(); ++i)
    A.AddScaledIdentity(model.pattern.diagonal[i], material.density * model.vertex_area[i]);
  if (moving.mass_damping != 0.0)
    for (int i = 0; i < model.mesh.num_vertices(); ++i)
      A.AddScaledIdentity(model.pattern.diagonal[i],
                          h * moving.mass_damping * material.density * model.vertex_area[i]);
  for (int i : model.held)
    A.AddScaledIdentity(model.pattern.diagonal[i], h * h * model.scene.handles->stiffness);
  if (model.scene.contact)
    for (int i = 0; i < model.mesh.num_vertices(); ++i)
      A.Add(model.pattern.diagonal[i],
            h * h *
                ContactStepStiffness(*model.scene.contact, model.vertex_area[i],
                                     x.segment<3>(3 * i)));
  VisitActivePairs(model, x, self, [&](const ActivePairs& pairs) { AddPairForces(pairs, force); });
  AddSelfStiffness(model, x, StiffnessPart::kPositive, h * h, self, A);
}

void AssembleStepDerivative(const ClothModel& model, const MaterialField& material,
                            const Eigen::VectorXd& x, const Eigen::VectorXd& w, double h,
                            BlockMatrix& derivative, SurfaceContact* self,
                            const AssemblyParts& parts) {
  derivative.SetZero();
  const DampedVelocity damped(material, w, h);
  ForEachPart(parts, [&](const AssemblyPart* part) {
    VisitLaws(
        model,
        [&](const auto& law) {
          AddStretchDerivative(law, model, material, x.data(), damped.data(), h, derivative, part);
        },
        [&](const auto& law) {
          AddBendDerivative(law, model, material, x.data(), damped.data(), h, derivative, part);
        });
  });
  for (int i : model.held)
    derivative.AddScaledIdentity(model.pattern.diagonal[i], -h * model.scene.handles->stiffness);
  if (model.scene.contact)
    for (int i = 0; i < model.mesh.num_vertices(); ++i)
      derivative.Add(model.pattern.diagonal[i],
                     ContactStepDerivative(*model.scene.contact, model.vertex_area[i],
                                           x.segment<3>(3 * i), w.segment<3>(3 * i), h));
  AddSelfStiffness(model, x, StiffnessPart::kWhole, -h, self, derivative);
}

ElementStates EvaluateElements(const ClothModel& model, const MaterialField& material,
                               const Eigen::VectorXd& x, Eigen::VectorXd& force,
                               SurfaceContact* self, const AssemblyParts& parts) {
  ElementStates states;
  if (model.scene.stretch) states.faces.resize(model.mesh.num_faces());
  if (model.scene.bend) states.hinges.resize(model.mesh.num_hinges());
  force.setZero(x.size());
  AddOuterForces(model, material.density, x, force);
  ForEachPart(parts, [&](const AssemblyPart* part) {
    VisitLaws(
        model,
        [&](const auto& law) {
          EvaluateFaces(law, model, material, x.data(), force.data(), part, states.faces);
        },
        [&](const auto& law) {
          EvaluateHinges(law, model, material, x.data(), force.data(), part, states.hinges);
        });
  });
  VisitActivePairs(model, x, self, [&](const ActivePairs& pairs) { AddPairForces(pairs, force); });
  return states;
}

StressField MembraneStress(const ElementStates& states) {
  StressField stress;
  for (const ElementStates::OfFace& face : states.faces) stress.push_back(Values(face.stress));
  return stress;
}

StressField ExtrapolatedMembraneStress(const ClothModel& model, const ElementStates& states,
                                       const Eigen::VectorXd& x, const Eigen::VectorXd& dx) {
  StressField stress(states.faces.size());
  for (std::size_t f = 0; f < stress.size(); ++f) {
    const Face& face = model.mesh.faces[f];
    stress[f] = ExtrapolatedStress(
        states.faces[f].stress,
        StrainRate(GatherColumns(face, x.data()), GatherColumns(face, dx.data())));
  }
  return stress;
}

void AddGeometricStiffness(const ClothModel& model, const StressField& stress, BlockMatrix& K) {
  for (std::size_t f = 0; f < stress.size(); ++f) {
    const Face& face = model.mesh.faces[f];
    const ShapeGradient s = GradientOf(face);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        K.AddScaledIdentity(model.pattern.face_block[9 * f + 3 * a + b],
                            face.area * GeometricWeight(stress[f], s.u[a], s.v[a], s.u[b], s.v[b]));
  }
}

void AssembleStiffness(const ClothModel& model, const ElementStates& states,
                       const StressField& stress, const Eigen::VectorXd& x, StiffnessPart part,
                       BlockMatrix& K, SurfaceContact* self, const AssemblyParts& parts) {
  K.SetZero();
  ForEachPart(parts, [&](const AssemblyPart* each) {
    if (!states.faces.empty()) AddFaceStiffness(model, states, stress, x.data(), K, each);
    if (!states.hinges.empty()) AddHingeStiffness(model, states, x.data(), K, each);
  });
  for (int i : model.held)
    K.AddScaledIdentity(model.pattern.diagonal[i], model.scene.handles->stiffness);
  if (model.scene.contact)
    for (int i = 0; i < model.mesh.num_vertices(); ++i) {
      const Eigen::Matrix3d by_x =
          ContactStepDerivative(*model.scene.contact, model.vertex_area[i], x.segment<3>(3 * i),
                                Eigen::Vector3d::Zero(), 1.0);
      K.Add(model.pattern.diagonal[i], -0.5 * (by_x + by_x.transpose()));
    }
  AddSelfStiffness(model, x, part, 1.0, self, K);
}

double Energy(const ClothModel& model, double density, const ElementStates& states,
              const Eigen::VectorXd& x, SurfaceContact* self) {
  double energy = 0.0;
  if (model.scene.gravity)
    for (int i = 0; i < model.mesh.num_vertices(); ++i)
      energy -= density * model.vertex_area[i] * model.scene.gravity->dot(x.segment<3>(3 * i));
  for (int i : model.held)
    energy += 0.5 * model.scene.handles->stiffness *
              (x.segment<3>(3 * i) - model.mesh.rest_x.segment<3>(3 * i)).squaredNorm();
  for (const VertexLoad& load : model.loads)
    energy -= load.force.dot(x.segment<3>(3 * load.vertex));
  if (model.scene.contact)
    for (int i = 0; i < model.mesh.num_vertices(); ++i)
      energy += ContactEnergy(*model.scene.contact, model.vertex_area[i], x.segment<3>(3 * i));
  VisitActivePairs(model, x, self, [&](const ActivePairs& pairs) {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size());
    energy += AddPairForces(pairs, force);
  });
  for (const ElementStates::OfFace& face : states.faces) energy += face.energy;
  for (const ElementStates::OfHinge& hinge : states.hinges) energy += hinge.energy;
  return energy;
}

double Energy(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x,
              SurfaceContact* self) {
  Eigen::VectorXd force;
  const ElementStates states = EvaluateElements(model, material, x, force, self);
  return Energy(model, material.density, states, x, self);
}

Eigen::VectorXd EnergyByEntry(const ClothModel& model, const Eigen::VectorXd& x) {
  Eigen::VectorXd energy = Eigen::VectorXd::Zero(kMaterialEntries);
  const auto add_stretch = [&](const auto& law) {
    for (const Face& face : model.mesh.faces) {
      const GreenStrain<double> G = Green(GatherColumns(face, x.data()));
      for (int i = 0; i < kStretchEntries; ++i) {
        StretchTable unit;
        unit.entries()[i] = 1.0;
        energy[i] += face.area * StretchEnergy(Stress(EvaluateStretch(law, G, unit), G), G);
      }
    }
  };
  const auto add_bend = [&](const auto& law) {
    for (const Hinge& hinge : model.mesh.hinges) {
      const double theta = DihedralAngle(GatherCorners(hinge, x.data()));
      for (int i = 0; i < kBendEntries; ++i) {
        BendTable unit;
        unit.entries()[i] = 1.0;
        energy[kStretchEntries + i] += BendEnergy(law, hinge, unit, theta);
      }
    }
  };
  VisitLaws(model, add_stretch, add_bend);
  return energy;
}

bool HasSelfContact(const Scene& scene) { return scene.contact && scene.contact->self; }

SurfaceContact MakeSelfContact(const ClothModel& model) {
  CHECK(HasSelfContact(model.scene));
  return SurfaceContact(model.mesh, model.vertex_area, *model.scene.contact);
}

void RequireThinCloth(const ClothModel& model) {
  if (!HasSelfContact(model.scene)) return;
  const Contact& contact = *model.scene.contact;
  double length = 0.0;
  const std::vector<RestEdge> edges = ListEdges(model.mesh);
  for (const RestEdge& edge : edges) length += edge.rest_length / static_cast<double>(edges.size());
  if (contact.thickness + contact.range <= length) return;
  throw InputError("contact",
                   Format("found cloth of %g mm and a range of %g mm on edges of %.3g mm "
                          "in the mean, expected both together to be less: neighbours "
                          "would touch",
                          1e3 * contact.thickness, 1e3 * contact.range, 1e3 * length));
}

std::optional<SelfOverlap> FindSelfOverlap(const ClothModel& model, const Eigen::VectorXd& x) {
  if (!HasSelfContact(model.scene)) return std::nullopt;
  const std::vector<std::pair<int, int>> meeting =
      FindSelfIntersections(ListTriangles(model.mesh), x);
  if (!meeting.empty()) {
    const auto& [first, second] = meeting.front();
    return SelfOverlap{{model.mesh.faces[first].vertex[0], model.mesh.faces[second].vertex[0]}};
  }
  SurfaceContact contact = MakeSelfContact(model);
  for (const ActivePair& active : contact.FindActivePairs(x))
    if (active.distance.value <= model.scene.contact->thickness)
      return SelfOverlap{{active.pair.vertex[0], active.pair.vertex[3]}, active.distance.value};
  return std::nullopt;
}

double SmallestSelfGap(const ClothModel& model, const Eigen::VectorXd& x) {
  if (!HasSelfContact(model.scene)) return Contact().range;
  SurfaceContact contact = MakeSelfContact(model);
  return contact.SmallestGap(x);
}

Eigen::VectorXd ReachSafely(const ClothModel& model, const Eigen::VectorXd& from,
                            const Eigen::VectorXd& to) {
  if (!HasSelfContact(model.scene) || !to.allFinite()) return to;
  Eigen::VectorXd moves = to - from;
  SurfaceContact contact = MakeSelfContact(model);
  return LimitStep(contact, from, moves) ? from + moves : to;
}

}  // namespace drape
