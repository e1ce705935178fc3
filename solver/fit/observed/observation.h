// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/dataset/dataset.h"
#include "losses/image/image.h"
#include "losses/outline/measured_image.h"
#include "losses/outline/outline.h"
#include "physics/cloth/state.h"
#include "physics/material/material.h"
#include "physics/util/options/field.h"
#include "solver/fit/observed/experiment.h"

namespace drape {

// How the cloth of a fit, whose frame has the weft along x and the warp along y, lies in a picture:
// mirrored (y → −y) if so and then turned counter-clockwise. Woven cloth is alike in its mirror
// images, a mesh of it is not.
struct ClothPose {
  int degrees = 0;
  bool mirrored = false;

  bool operator==(const ClothPose&) const = default;
};

// One silhouette of a drape, as it was photographed, or measurements of any cloth.
struct Observation {
  std::string name;  // file name without folder and extension
  std::string file;
  GrayImage image;
  Camera camera;           // its centre is the support's centre in this image
  Eigen::VectorXd radius;  // outline r(θ) of the image in the cloth's frame [px of
                           // outline_camera()], shape [K]
  DrapeDiscs discs;        // of the drape
  ImageQuality quality;    // how far the silhouette can be trusted, and what was done to it
  std::optional<PhotographNotes> photograph;  // from which the silhouette is, by the camera's file
  std::optional<int> warp = {};               // its angle in the image [degrees]; none: not known
  ClothPose pose = {};
  // Measurements in place of a silhouette; all but the name then has no meaning.
  std::shared_ptr<const Experiment> experiment = {};

  // What is fitted. An image is an experiment without a mesh of its own: one measurement, its
  // outline, with a standard deviation [px], on any cloth over a support; by default its misfit is
  // a root mean square in px.
  std::shared_ptr<const Experiment> Measured(double sigma_px = 1.0) const;

  // Positions of the cloth's frame as the image has them, shape [3V].
  Eigen::VectorXd InImage(const Eigen::VectorXd& x) const {
    return TurnedAboutZ(x, pose.degrees * M_PI / 180, pose.mirrored);
  }
  // The same image on the mirror image of the cloth.
  Observation Mirrored() const;
  // The camera over the cloth's frame at the scale of the published images, in whose pixels
  // (1.39 mm) a fit compares outlines: σ and the errors of a fit are lengths, whatever the
  // resolution of the image.
  Camera outline_camera() const;
  // The image's outline at `angles` angles of the cloth's frame, in those pixels; nothing when it
  // is not closed.
  std::optional<Eigen::VectorXd> MeasureRadius(int angles) const;
};

// Shapes [m], each of shape [3V], as states without velocity.
inline std::vector<State> AtRest(const std::vector<Eigen::VectorXd>& shapes) {
  std::vector<State> states;
  for (const Eigen::VectorXd& x : shapes) states.push_back({x, Eigen::VectorXd::Zero(x.size())});
  return states;
}

// What of a capture of the public data set is fitted.
enum class ObservationSource {
  kSilhouettes,
  kMeshes  // the outline of its published mesh, whose z has no further information [METHODS, P11]
};
constexpr auto EnumNames(ObservationSource) {
  return MakeNames<ObservationSource>(
      {{ObservationSource::kSilhouettes, "silhouettes"}, {ObservationSource::kMeshes, "meshes"}});
}

struct ObservationOptions {
  CameraInput camera = {};  // of images; captures of the public data set have the published one
  DiscsInput discs = {};
  CentreMode centre = CentreMode::kOutline;
  int angles = 90;                  // K of r(θ)
  std::string warp = kUnknownWarp;  // ParseWarp; unknown: as the camera file says
};

template <MutableOrConst<ObservationOptions> Options, class Visitor>
void VisitFields(Options& options, Visitor&& visit) {
  auto& [camera, discs, centre, angles, warp] = options;
  VisitFields(discs, visit);
  VisitFields(camera, visit);
  visit(centre, Field{.key = "centre",
                      .doc = "where the support's centre is: nominal: at camera_cx, camera_cy; "
                             "outline: found from the outline, from there on"});
  visit(warp, Field{.key = "warp", .doc = kWarpDoc});
  visit(angles, Field{.key = "angles", .range = {.least = 31, .most = 3600}, .is_option = false});
}

// An image of a drape, or what the camera sees of a published mesh, which has been turned onto its
// image (KeepUsable); its name is the file's, or "sample_2_capture_1_up". Of the mirror images of
// the cloth it takes the one that suits the outline, so that pictures which are mirror images or
// turns of each other have the same radius. The warp of a published capture is up. Throws
// InputError for a file that cannot be read, shows no drape (SegmentSilhouette, MeasureImage) or is
// of other discs than the options say (FindDiscs).
Observation ReadImageObservation(const std::string& file, const ObservationOptions& options);
Observation ReadCaptureObservation(const Capture& capture, ObservationSource source,
                                   ObservationOptions options);

// What cameras have seen of one fabric, and what is known of it.
struct ObservedFabric {
  std::vector<Observation> drapes;  // at least one, of specimens of one size
  MaterialField start;              // tables from which a fit starts
  double density = 0.0;             // as weighed [kg/m²]; 0: not known, that of `start` is assumed
  // Models bayes and bdp: the specimen of each drape, from 1 without gaps; empty: each shows its
  // own.
  std::vector<int> specimens = {};
};

}  // namespace drape
