// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "losses/image/cloth_mask.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr double kRound = 0.02;         // Unroundness of a disc or a support
constexpr double kLeastChange = 3.5;    // [Lab units] across an edge
constexpr double kChangeOfNoise = 2.5;  // standard deviations of the ground

cv::Vec3f ColorAt(const cv::Mat3f& lab, const cv::Point2d& p) {
  return lab(std::clamp(cvRound(p.y), 0, lab.rows - 1), std::clamp(cvRound(p.x), 0, lab.cols - 1));
}

// An outline that a feature makes, in a small picture.
struct Candidate {
  size_t feature = 0;
  double threshold = 0.0;
  cv::Mat1b mask;  // filled
  double area = 0.0;
  std::vector<cv::Point> outline = {};
  std::vector<float> changes = {};  // EdgeChanges
  bool touches_border = false;
  double share = 0.0;     // of the outline, where it is an edge
  double strength = 0.0;  // what nine tenths of its changes exceed
};

constexpr double kWeakest = 0.1;  // share of the changes that are left aside

double LeastChange(double noise) { return std::max(kLeastChange, kChangeOfNoise * noise); }

std::vector<double> Thresholds(const Feature& feature, double noise) {
  constexpr double kLeast = 2.0, kOfNoise = 3.0, kStep = 1.35, kBeyond = 1.4;
  std::vector<double> thresholds = {feature.threshold};
  if (!feature.is_distance) return thresholds;
  for (double t = std::max(kLeast, kOfNoise * noise); t < kBeyond * feature.threshold; t *= kStep)
    thresholds.push_back(t);
  return thresholds;
}

cv::Point2d Middle(const std::vector<cv::Point>& outline) {
  const cv::Moments m = cv::moments(outline);
  return {m.m10 / m.m00, m.m01 / m.m00};
}

// Where one outline runs along another, within two pixels.
struct Contact {
  double share = 0.0;          // of the outline
  double sided = 0.0;          // 0: all around, to 1: at one place
  std::vector<float> changes;  // elsewhere
};
Contact FindContact(const Candidate& candidate, const Candidate& other) {
  constexpr double kWithin = 2.5;  // [px]
  cv::Mat1b line(other.mask.size(), 1);
  for (const cv::Point& p : other.outline) line(p) = 0;
  cv::Mat1f distance;
  cv::distanceTransform(line, distance, cv::DIST_L2, cv::DIST_MASK_5);
  const cv::Point2d middle = Middle(candidate.outline);
  Contact contact;
  cv::Point2d sum;
  double count = 0;
  for (size_t i = 0; i < candidate.outline.size(); ++i) {
    if (distance(candidate.outline[i]) > kWithin) {
      contact.changes.push_back(candidate.changes[i]);
      continue;
    }
    const cv::Point2d from_middle = cv::Point2d(candidate.outline[i]) - middle;
    sum += from_middle / std::max(cv::norm(from_middle), 1.0);
    ++count;
  }
  contact.share = count / double(candidate.outline.size());
  contact.sided = cv::norm(sum) / std::max(count, 1.0);
  return contact;
}

// Whether what lies between two outlines is a shadow that the inner one casts; a round one may be
// the disc on a translucent cloth.
bool IsShadow(const Candidate& outer, const Candidate& inner, const cv::Mat1f& unshadowed,
              double noise) {
  constexpr double kOnCurve = 4.0;  // [Lab units]
  constexpr double kLeastContact = 0.1, kMostContact = 0.5, kSided = 0.35;
  constexpr double kClear = 1.5;   // times the least change of an edge
  constexpr double kAround = 0.4;  // of the radius, about the middle of both
  const cv::Point2f middle(Middle(outer.outline));
  if (cv::pointPolygonTest(inner.outline, middle, true) < kAround * std::sqrt(outer.area / M_PI))
    return false;
  const cv::Mat1b core = Eroded(outer.mask, 2) & (1 - Dilated(inner.mask, 2));
  std::vector<float> apart;
  for (int row = 0; row < core.rows; ++row)
    for (int col = 0; col < core.cols; ++col)
      if (core(row, col)) apart.push_back(unshadowed(row, col));
  if (apart.empty() || Quantile(apart) > std::max(kOnCurve, 3 * noise)) return false;
  const Contact contact = FindContact(inner, outer);
  return Quantile(contact.changes, kWeakest) >= kClear * LeastChange(noise) &&
         (contact.share > kMostContact ||
          (contact.share > kLeastContact && contact.sided > kSided &&
           Unroundness(inner.outline) > kRound));
}

// A bright rectangle on a dark ground.
bool IsFrame(const Candidate& candidate, const cv::Mat3f& lab) {
  // A drape of four folds fills .93 of the rectangle around it; a table that is cut off may have
  // wide corners.
  const double least = candidate.touches_border ? 0.9 : 0.95;
  constexpr double kBrighter = 20.0;   // L*
  constexpr double kStraight = 0.005;  // of the length of the outline
  constexpr size_t kCorners = 8;       // of a table that the picture cuts off on all sides
  const cv::RotatedRect box = cv::minAreaRect(candidate.outline);
  std::vector<cv::Point> polygon;
  cv::approxPolyDP(candidate.outline, polygon, kStraight * double(candidate.outline.size()), true);
  const bool is_cut =
      candidate.touches_border && polygon.size() <= kCorners && cv::isContourConvex(polygon);
  if (candidate.area < least * box.size.area() && !is_cut) return false;
  const cv::Mat1b wider = Dilated(candidate.mask, 6), narrower = Eroded(candidate.mask, 6);
  return cv::mean(lab, candidate.mask & (1 - narrower))[0] >
         cv::mean(lab, wider & (1 - candidate.mask))[0] + kBrighter;
}

// The distances of an outline from its middle.
std::vector<double> ListRadii(const std::vector<cv::Point>& outline) {
  const cv::Point2d middle = Middle(outline);
  std::vector<double> radii;
  for (const cv::Point& p : outline) radii.push_back(cv::norm(cv::Point2d(p) - middle));
  return radii;
}

// The farthest point of an outline from its middle, to the nearest one.
double Elongation(const std::vector<cv::Point>& outline) {
  const auto [least, most] = std::ranges::minmax(ListRadii(outline));
  return most / std::max(least, 1.0);
}

std::vector<Candidate> ListCandidates(const cv::Mat3f& lab, const std::vector<Feature>& features,
                                      const cv::Mat1b& disc, double noise) {
  constexpr double kLeastArea = 0.004;  // of the picture
  constexpr int kReach = 3;             // [px]
  std::vector<Candidate> candidates;
  for (size_t i = 0; i < features.size(); ++i)
    for (const double threshold : Thresholds(features[i], noise)) {
      cv::Mat1b mask = (features[i].value > threshold) / 255;
      cv::morphologyEx(mask, mask, cv::MORPH_OPEN, RoundElement(2));
      cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, RoundElement(2));
      mask |= disc;
      cv::Mat1i labels;
      const std::vector<MaskPart> parts = ListParts(FillHoles(mask), 8, &labels);
      if (parts.empty()) continue;
      const MaskPart& part = NearestPart(labels, parts);
      if (double(part.pixels) < kLeastArea * double(mask.total())) continue;
      Candidate candidate{i, threshold, (labels == part.label) / 255, double(part.pixels)};
      candidate.outline = LongestOutline(candidate.mask);
      candidate.touches_border = !TouchedSides(part.box, mask.size()).empty();
      candidate.changes = EdgeChanges(lab, candidate.outline, kReach);
      candidate.share = ShareOfEdge(candidate.changes, LeastChange(noise));
      candidate.strength = Quantile(candidate.changes, kWeakest);
      candidates.push_back(std::move(candidate));
    }
  return candidates;
}

// Drops what is too long for a drape, unless all is.
void DropLong(std::vector<Candidate>* candidates) {
  constexpr double kMostElongation = 2.1;  // a drape of 36 cm reaches 2 radii of its support
  const auto is_long = [&](const Candidate& c) {
    return !c.touches_border && Elongation(c.outline) > kMostElongation;
  };
  if (!std::all_of(candidates->begin(), candidates->end(), is_long))
    std::erase_if(*candidates, is_long);
}

// The outermost of the candidates, by falling area, that is no cloth with its shadow; of those with
// its area the one that is an edge in the largest part. has_shadow: whether a shadow is left out.
const Candidate* FindBest(const std::vector<Candidate>& candidates, const cv::Mat1f& unshadowed,
                          double noise, bool* has_shadow) {
  constexpr double kSameArea = 0.04;
  constexpr double kNotedShadow = 0.12;  // of the area
  // A shade of the cloth has an outline at one threshold alone.
  const auto is_stable = [&](const Candidate& c) {
    return std::count_if(candidates.begin(), candidates.end(), [&](const Candidate& other) {
             return std::abs(other.area - c.area) < kSameArea * c.area;
           }) > 1;
  };
  size_t outermost = 0;
  for (size_t i = 0; i + 1 < candidates.size(); ++i)
    for (size_t k = i + 1; k < candidates.size() && outermost == i; ++k)
      if (candidates[k].area < (1 - kSameArea) * candidates[i].area && is_stable(candidates[k]) &&
          IsShadow(candidates[i], candidates[k], unshadowed, noise)) {
        *has_shadow |= candidates[k].area < (1 - kNotedShadow) * candidates[i].area;
        outermost = i + 1;
      }
  const Candidate* best = &candidates[outermost];
  for (const Candidate& candidate : candidates)
    if (candidate.area <= candidates[outermost].area &&
        candidate.area > (1 - kSameArea) * candidates[outermost].area &&
        candidate.share + 0.01 * candidate.strength > best->share + 0.01 * best->strength)
      best = &candidate;
  return best;
}

}  // namespace

double ShareOfEdge(const std::vector<float>& changes, double least) {
  const auto strong =
      std::count_if(changes.begin(), changes.end(), [&](float change) { return change >= least; });
  return double(strong) / double(std::max<size_t>(changes.size(), 1));
}

double Unroundness(const std::vector<cv::Point>& outline) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(ListRadii(outline), mean, deviation);
  return deviation[0] / mean[0];
}

bool IsRoundHole(const cv::Mat1b& hole, const cv::Mat1b& filled_cloth) {
  // Shares of the radius of a disc of the cloth's area: where the hole fills more, no cloth hangs.
  constexpr double kOff = 0.15, kLeast = 0.3, kMost = 0.96;
  const cv::Moments h = cv::moments(hole, true), c = cv::moments(filled_cloth, true);
  const double radius = std::sqrt(c.m00 / M_PI), of_hole = std::sqrt(h.m00 / M_PI);
  return Unroundness(LongestOutline(hole)) < kRound && of_hole > kLeast * radius &&
         of_hole < kMost * radius &&
         std::hypot(h.m10 / h.m00 - c.m10 / c.m00, h.m01 / h.m00 - c.m01 / c.m00) < kOff * radius;
}

std::vector<float> EdgeChanges(const cv::Mat3f& lab, const std::vector<cv::Point>& outline,
                               int reach) {
  constexpr int kTangent = 5;  // points of the outline on either side
  constexpr int kSlack = 2;    // [px] by which the outline may be beside the edge
  constexpr int kBorder = 3;   // [px] from the border of the picture
  constexpr float kUnknown = 1e3f;
  const auto n = static_cast<int>(outline.size());
  std::vector<float> changes;
  for (int i = 0; i < n && n >= 4 * kTangent; ++i) {
    const bool at_border = std::min({outline[i].x, outline[i].y, lab.cols - 1 - outline[i].x,
                                     lab.rows - 1 - outline[i].y}) < kBorder;
    if (at_border) {
      changes.push_back(kUnknown);
      continue;
    }
    const cv::Point2d along = outline[(i + kTangent) % n] - outline[(i + n - kTangent) % n];
    const double length = std::max(cv::norm(along), 1e-9);
    const cv::Point2d across(along.y / length, -along.x / length), middle = outline[i];
    double most = 0;
    for (int s = -kSlack; s <= kSlack; ++s) {
      const auto at = [&](int t) { return ColorAt(lab, middle + (s + t) * across); };
      const cv::Vec3f out = at(reach), in = at(-reach);
      const double slope = std::min(cv::norm(at(3 * reach) - out), cv::norm(in - at(-3 * reach)));
      most = std::max(most, cv::norm(out - in) - slope);
    }
    changes.push_back(static_cast<float>(most));
  }
  return changes;
}

ChosenOutline ChooseOutline(const cv::Mat3f& lab, const std::vector<Feature>& features,
                            const cv::Mat1f& unshadowed, const cv::Mat1b& disc, double noise) {
  constexpr double kSide = 700;        // [px] of the small picture
  constexpr double kAlike = 0.03;      // of the outline that is an edge
  constexpr double kLeastField = 0.2;  // of the picture, of a light table that is cut off
  constexpr double kOneHue = 6.0;      // [Lab units]
  const double shrink = std::min(1.0, kSide / std::max(lab.rows, lab.cols));
  const auto reduced = [&](const auto& picture) {
    auto small = picture.clone();
    cv::resize(picture, small, {}, shrink, shrink, cv::INTER_AREA);
    return small;
  };
  std::vector<Feature> small = features;
  for (Feature& feature : small) feature.value = reduced(feature.value);
  const cv::Mat3f small_lab = reduced(lab);
  const cv::Mat1f small_unshadowed = reduced(unshadowed);
  cv::Mat1b small_disc;
  cv::resize(disc, small_disc, small_lab.size(), 0, 0, cv::INTER_NEAREST);
  std::vector<Candidate> candidates = ListCandidates(small_lab, small, small_disc, noise);
  ChosenOutline chosen;
  chosen.feature = *std::max_element(
      features.begin(), features.end(),
      [](const Feature& a, const Feature& b) { return a.separation < b.separation; });
  for (const Candidate& candidate : candidates)
    if (candidate.touches_border && candidate.area > kLeastField * double(small_lab.total()) &&
        IsFrame(candidate, small_lab)) {
      chosen.feature = features[candidate.feature];
      chosen.feature.threshold = candidate.threshold;
      chosen.is_frame = true;
      return chosen;
    }
  DropLong(&candidates);
  if (candidates.empty()) return chosen;
  double most = 0;
  for (const Candidate& candidate : candidates) most = std::max(most, candidate.share);
  std::erase_if(candidates, [&](const Candidate& c) { return c.share < most - kAlike; });
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.area > b.area; });
  const Candidate* best = FindBest(candidates, small_unshadowed, noise, &chosen.has_shadow);
  chosen.feature = features[best->feature];
  chosen.feature.threshold = best->threshold;
  chosen.share = best->share;
  const cv::Scalar apart =
      cv::mean(small_lab, best->mask & (1 - small_disc)) - cv::mean(small_lab, 1 - best->mask);
  chosen.may_lack_shade =
      chosen.feature.value.data == unshadowed.data && std::hypot(apart[1], apart[2]) < kOneHue;
  chosen.is_frame = IsFrame(*best, small_lab);
  return chosen;
}

void FindSilhouette(const RgbImage& photo, PhotoPlanes planes, const ClothHints& hints,
                    FoundCloth* found) {
  constexpr double kUnclear = 0.05;  // of the outline
  CheckExposure(planes);
  const RoughCloth rough = FindCloth(hints, &planes);
  found->seen = rough.notes;
  found->outline = LongestOutline(rough.mask);
  cv::Mat1f disc = cv::Mat1f::zeros(rough.mask.size());
  found->rim = FindDisc(planes, FilledHull(rough.mask));
  if (found->rim) {
    LocateFinely(photo, planes, rough.mask, &*found->rim);
    disc = RenderEllipse(disc.size(), found->rim->ellipse, found->rim->blur);
  }
  if (!rough.has_frame) CheckGlare(planes, rough.mask);
  found->cloth = RefineCloth(planes, rough, disc);
  found->outline = LongestOutline(found->cloth.mask);
  found->ground_level = cv::mean(planes.luma, 1 - found->cloth.mask)[0];
  found->cloth_level = cv::mean(planes.luma, found->cloth.mask)[0];
  const double unclear =
      1 - ShareOfEdge(EdgeChanges(planes.lab, found->outline, 4), LeastChange(rough.ground_noise));
  if (unclear > kUnclear)
    found->doubts.push_back(
        Format("%.0f %% of the outline is no clear edge of the picture", 100 * unclear));
  if (found->cloth.weak > 0.03)
    found->doubts.push_back(
        Format("%.0f %% of the outline has little contrast", 100 * found->cloth.weak));
}

}  // namespace drape
