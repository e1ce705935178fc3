// SPDX-License-Identifier: Apache-2.0
// Internal to losses: which pixels show the cloth (cloth_mask.cc), which outline is the cloth's
// (cloth_outline.cc), and where it ends, to a part of a pixel (refined_cloth.cc).
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "losses/image/disc.h"
#include "losses/image/photo_planes.h"

namespace drape {

// A connected part of a mask.
struct MaskPart {
  int label = 0;
  int64_t pixels = 0;
  cv::Rect box;
  cv::Point2d middle;
};
// The parts of the pixels that are 1, connected through 4 or 8 neighbours, and the label of each
// pixel; 0: the others.
std::vector<MaskPart> ListParts(const cv::Mat1b& mask, int neighbours, cv::Mat1i* labels);

// The part nearest to the picture's centre among those that are not small beside the largest.
const MaskPart& NearestPart(const cv::Mat1i& labels, const std::vector<MaskPart>& parts);

// The sides of the picture that a box touches: "top, left"; empty: none.
std::string TouchedSides(const cv::Rect& box, cv::Size size);

cv::Mat1b FillHoles(const cv::Mat1b& mask);

// How far an outline is from a circle about its centroid: root mean square, of the radius.
double Unroundness(const std::vector<cv::Point>& outline);

// Whether a hole is round and in the middle of the cloth, as a support is.
bool IsRoundHole(const cv::Mat1b& hole, const cv::Mat1b& filled_cloth);

// How much more the colour changes across the outline of a mask, within `reach` pixels on either
// side, than it does beside it, at each point of the outline [Lab units]: nothing in a slope. The
// border of the picture passes for an edge.
std::vector<float> EdgeChanges(const cv::Mat3f& lab, const std::vector<cv::Point>& outline,
                               int reach);
// The share of the changes that are as large as an edge has to be.
double ShareOfEdge(const std::vector<float>& changes, double least);

// Hints of a user about the place of the cloth.
struct ClothHints {
  double threshold = 0.0;         // 0 … 1 between ground and cloth; 0: found
  std::string mask;               // picture of the cloth made by hand; empty: none
  std::vector<int> cloth_points;  // columns and rows of points on the cloth [px]
  std::vector<int> ground_points;

  bool has_points() const { return !cloth_points.empty() || !ground_points.empty(); }
};

// A measure of being cloth, and where it separates.
struct Feature {
  cv::Mat1f value;
  double threshold = 0.0;    // by Otsu
  double separation = 0.0;   // of the variance, between the two classes
  bool is_distance = false;  // from the ground [Lab units], so that lower thresholds make sense

  cv::Mat1b Mask() const { return (value > threshold) / 255; }
};

// Chooses among the outlines that the features and their thresholds make: that which is an edge of
// the picture along its whole length, the outermost of several. The disc on a translucent cloth
// lies inside; an edge outside the cloth that begins at it on one side, and whose colours are those
// of the ground in less light, is a shadow (`unshadowed`: the distance from such colours). `disc`:
// a disc that was found, which belongs to the cloth, whatever its colour.
struct ChosenOutline {
  Feature feature;
  double share = 0.0;     // of the outline that is an edge
  bool is_frame = false;  // a rectangle around all else: the edge of a light table
  bool has_shadow = false;
  bool may_lack_shade = false;  // a part of the cloth in shade may pass for a shadow
};
ChosenOutline ChooseOutline(const cv::Mat3f& lab, const std::vector<Feature>& features,
                            const cv::Mat1f& unshadowed, const cv::Mat1b& disc, double noise);

// The cloth without holes, 1 = cloth. The ground's colour is a quadratic function of the place,
// fitted to the border of the picture, so that a shadow or an uneven light at its edges does not
// count. A dark frame around a light table is painted over (`planes`). The cloth is what differs
// from the ground, in CIE Lab, in what light and shadow leave of it, or in Fisher's linear
// discriminant (ChooseOutline); with points of the user, or where no outline is an edge, OpenCV's
// GrabCut continues from there. Of several parts, the one nearest to the picture's centre counts
// among those that are not small beside the largest. Throws PhotoFailure.
struct RoughCloth {
  cv::Mat1b mask;
  cv::Mat1b pieces;           // all that may be cloth; a disc that hides the rest lies between them
  double ground_noise = 0.0;  // robust standard deviation of the border [Lab units]
  bool has_frame = false;     // the ground is a light table
  std::vector<std::string> notes;  // on what was left out

  // Returns whether the ground is ruled, say: its lines, which are thin, may look like cloth.
  bool has_lines() const { return ground_noise > 5.0; }
};
RoughCloth FindCloth(const ClothHints& hints, PhotoPlanes* planes);

// The cloth with its outline between the colours on either side of it: each pixel near the outline
// is compared with the mean colours of cloth and ground in its neighbourhood, and the outline
// moves until that changes nothing. `disc_coverage`: the coverage by the disc, which lies inside
// the outline and is no cloth. Throws PhotoFailure where cloth and ground are too alike.
struct RefinedCloth {
  cv::Mat1b mask;
  cv::Mat1f coverage;     // 0 … 1
  double contrast = 0.0;  // median along the outline [Lab units]
  double weak = 0.0;      // share of the outline with little contrast
  double mixed_sd = 0.0;  // of the outline [px], by a pattern and colours mixed with the disc's
  double blur = 0.0;      // standard deviation of the edge [px]
};
RefinedCloth RefineCloth(const PhotoPlanes& planes, const RoughCloth& rough,
                         const cv::Mat1f& disc_coverage);

// The cloth of a picture, step by step: what was found by then is there after a PhotoFailure.
struct FoundCloth {
  std::vector<cv::Point> outline;  // in the working picture
  std::optional<DiscRim> rim;      // of the disc on it
  RefinedCloth cloth;
  double ground_level = 0.0, cloth_level = 0.0;  // mean luma, 0 … 1
  std::vector<std::string> seen, doubts;         // Segmentation
};
void FindSilhouette(const RgbImage& photo, PhotoPlanes planes, const ClothHints& hints,
                    FoundCloth* found);

}  // namespace drape
