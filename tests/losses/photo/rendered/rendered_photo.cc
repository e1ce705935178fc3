// SPDX-License-Identifier: Apache-2.0
#include "tests/losses/photo/rendered/rendered_photo.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

#include "losses/image/photo_planes.h"

namespace drape {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kFine = 2;  // samples of a pixel in each direction

// What each sample sees.
struct Canvas {
  int width, height;
  std::vector<float> depth;  // height of what is seen [m]
  std::vector<Eigen::Vector3f> light;
};

class Lens {
 public:
  explicit Lens(const PhotoScene& scene)
      : eye_(scene.eye),
        distortion_(scene.distortion),
        focal_(kFine * scene.focal_35mm * std::hypot(scene.width, scene.height) / 43.2666),
        column_(0.5 * (kFine * scene.width - 1)),
        row_(0.5 * (kFine * scene.height - 1)) {
    const double angle = scene.tilt.norm();
    turn_ = angle > 0
                ? Eigen::AngleAxisd(angle, Vector3d(scene.tilt.x(), scene.tilt.y(), 0) / angle)
                      .toRotationMatrix()
                : Eigen::Matrix3d::Identity();
  }
  Vector2d Project(const Vector3d& x) const {
    const Vector3d own = turn_.transpose() * (x - eye_);
    const Vector2d ideal(own.x() / own.z(), own.y() / own.z());
    const Vector2d seen = focal_ * (1 + distortion_ * ideal.squaredNorm()) * ideal;
    return {column_ - seen.x(), row_ + seen.y()};
  }
  Vector3d OnPlane(double column, double row, double z) const {
    const Vector3d ray = turn_ * Vector3d((column - column_) / focal_, (row_ - row) / focal_, -1);
    return eye_ + ray * ((z - eye_.z()) / ray.z());
  }
  double depth(const Vector3d& x) const { return -(turn_.transpose() * (x - eye_)).z(); }

 private:
  Vector3d eye_;
  double distortion_, focal_, column_, row_;
  Eigen::Matrix3d turn_;
};

// The light of a stored colour (sRGB).
Vector3d Light(const Rgb& stored) {
  return stored.unaryExpr(
      [](double s) { return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4); });
}

double Hash(int a, int b, unsigned seed) {
  uint32_t h = static_cast<uint32_t>(a) * 374761393u + static_cast<uint32_t>(b) * 668265263u +
               seed * 2246822519u;
  h = (h ^ (h >> 13)) * 1274126177u;
  return ((h ^ (h >> 16)) & 0xFFFF) / 32767.5 - 1.0;
}

Vector3d LightDirection(const PhotoScene& scene) {
  return Vector3d(scene.light.x(), scene.light.y(), 1).normalized();
}

// The largest radius of a piece in each of 360 directions [m], for its shadow.
std::vector<double> Reach(const ScenePiece& piece) {
  std::vector<double> reach(360, 0.0);
  const std::vector<int>& hem = piece.mesh->boundary_loops[0];
  for (size_t i = 0; i < hem.size(); ++i)
    for (int k = 0; k < 40; ++k) {
      const double t = k / 40.0;
      const Vector2d p = (1 - t) * piece.x.segment<2>(3 * hem[i]) +
                         t * piece.x.segment<2>(3 * hem[(i + 1) % hem.size()]);
      const int angle =
          static_cast<int>(std::floor(std::atan2(p.y(), p.x()) * 180 / M_PI) + 360) % 360;
      reach[angle] = std::max(reach[angle], p.norm());
    }
  return reach;
}

double Smooth(double t) {
  const double u = std::clamp(t, 0.0, 1.0);
  return u * u * (3 - 2 * u);
}

// The same for all samples of a pixel.
void PaintGround(const PhotoScene& scene, const Lens& lens, const std::vector<ScenePiece>& pieces,
                 Canvas* canvas) {
  constexpr double kHem = -0.045;  // [m]
  std::vector<std::vector<double>> reach;
  for (const ScenePiece& piece : pieces) reach.push_back(Reach(piece));
  const Vector3d from = LightDirection(scene), ground = Light(scene.ground);
  for (int row = 0; row < canvas->height; row += kFine)
    for (int col = 0; col < canvas->width; col += kFine) {
      const Vector3d p =
          lens.OnPlane(col + 0.5 * (kFine - 1), row + 0.5 * (kFine - 1), scene.ground_height);
      const Vector3d q = p + from * ((kHem - scene.ground_height) / from.z());
      double lit = 1.0;
      for (size_t i = 0; i < pieces.size(); ++i) {
        const Vector2d d = q.head<2>() - pieces[i].place;
        const int angle =
            static_cast<int>(std::floor(std::atan2(d.y(), d.x()) * 180 / M_PI) + 360) % 360;
        lit -= scene.shadow * Smooth(0.5 + (reach[i][angle] - d.norm()) / scene.soft);
      }
      const double grain = 1 + scene.texture * Hash(static_cast<int>(std::floor(p.x() * 900)),
                                                    static_cast<int>(std::floor(p.y() * 900)), 3);
      const Eigen::Vector3f light = (ground * std::max(lit, 0.2) * grain).cast<float>();
      for (int i = 0; i < kFine; ++i)
        for (int k = 0; k < kFine; ++k)
          canvas->light[size_t(row + i) * canvas->width + col + k] = light;
    }
}

// Paints a triangle. shade(u, v, w): the colour at these weights of the corners.
template <class Shade>
void PaintTriangle(const Lens& lens, const Vector3d corner[3], const Shade& shade, Canvas* canvas) {
  Vector2d p[3];
  double inverse[3];
  for (int i = 0; i < 3; ++i) {
    p[i] = lens.Project(corner[i]);
    inverse[i] = 1 / lens.depth(corner[i]);
  }
  const Vector2d e1 = p[1] - p[0], e2 = p[2] - p[0];
  const double area = e1.x() * e2.y() - e1.y() * e2.x();
  if (std::abs(area) < 1e-9) return;
  const int first =
      std::max(0, static_cast<int>(std::ceil(std::min({p[0].x(), p[1].x(), p[2].x()}))));
  const int last = std::min(canvas->width - 1,
                            static_cast<int>(std::floor(std::max({p[0].x(), p[1].x(), p[2].x()}))));
  const int top =
      std::max(0, static_cast<int>(std::ceil(std::min({p[0].y(), p[1].y(), p[2].y()}))));
  const int bottom = std::min(
      canvas->height - 1, static_cast<int>(std::floor(std::max({p[0].y(), p[1].y(), p[2].y()}))));
  for (int row = top; row <= bottom; ++row)
    for (int col = first, painted = 0; col <= last; ++col) {
      const Vector2d d = Vector2d(col, row) - p[0];
      const double v = (d.x() * e2.y() - d.y() * e2.x()) / area;
      const double w = (e1.x() * d.y() - e1.y() * d.x()) / area;
      if (v < 0 || w < 0 || v + w > 1) {
        if (painted > 0) break;
        continue;
      }
      ++painted;
      const double nearness = (1 - v - w) * inverse[0] + v * inverse[1] + w * inverse[2];
      float& depth = canvas->depth[size_t(row) * canvas->width + col];
      if (nearness <= depth) continue;
      depth = static_cast<float>(nearness);
      canvas->light[size_t(row) * canvas->width + col] =
          shade(1 - v - w, v, w).template cast<float>();
    }
}

auto Plain(const Rgb& color) {
  const Vector3d light = Light(color);
  return [light](double, double, double) { return light; };
}

void PaintCloth(const PhotoScene& scene, const Lens& lens, const ScenePiece& piece,
                Canvas* canvas) {
  const Mesh& mesh = *piece.mesh;
  const int count = mesh.num_vertices();
  const auto place = [&](int i) -> Vector3d {
    return piece.x.segment<3>(3 * i) + Vector3d(piece.place.x(), piece.place.y(), 0);
  };
  std::vector<Vector3d> normal(count, Vector3d::Zero());
  for (const auto& face : mesh.faces) {
    const Vector3d n = (place(face.vertex[1]) - place(face.vertex[0]))
                           .cross(place(face.vertex[2]) - place(face.vertex[0]));
    for (int k = 0; k < 3; ++k) normal[face.vertex[k]] += n;
  }
  const Vector3d light = LightDirection(scene);
  const Vector3d cloth = Light(scene.cloth), stripe = Light(scene.stripe);
  std::vector<double> lit(count);
  for (int i = 0; i < count; ++i)
    lit[i] = (0.45 + 0.55 * std::abs(normal[i].normalized().dot(light))) *
             (1 + scene.texture * Hash(i, 1, 5));
  for (const auto& face : mesh.faces) {
    const Vector3d corner[3] = {place(face.vertex[0]), place(face.vertex[1]),
                                place(face.vertex[2])};
    const auto shade = [&](double u, double v, double w) -> Vector3d {
      const int* k = face.vertex;
      const double weft = u * mesh.uv(0, k[0]) + v * mesh.uv(0, k[1]) + w * mesh.uv(0, k[2]);
      const bool striped =
          scene.stripes > 0 && static_cast<int>(std::floor(weft / scene.stripes)) % 2 == 0;
      return (striped ? stripe : cloth) * (u * lit[k[0]] + v * lit[k[1]] + w * lit[k[2]]);
    };
    PaintTriangle(lens, corner, shade, canvas);
  }
}

void PaintDisc(const PhotoScene& scene, const Lens& lens, const Vector2d& place, Canvas* canvas) {
  constexpr int kCorners = 720;
  const Vector3d middle(place.x(), place.y(), scene.disc_height + 2e-4);
  for (int k = 0; k < kCorners; ++k) {
    const auto at = [&](int i) -> Vector3d {
      const double angle = 2 * M_PI * i / kCorners;
      return middle + scene.disc_radius * Vector3d(std::cos(angle), std::sin(angle), 0);
    };
    const Vector3d corner[3] = {middle, at(k), at(k + 1)};
    PaintTriangle(lens, corner, Plain(scene.disc), canvas);
  }
}

void PaintPatch(const Lens& lens, const ScenePatch& patch, Canvas* canvas) {
  for (size_t i = 2; i < patch.corners.size(); ++i) {
    const Vector3d corner[3] = {patch.corners[0], patch.corners[i - 1], patch.corners[i]};
    PaintTriangle(lens, corner, Plain(patch.color), canvas);
  }
}

// Eight cells of black and bits, with a ring of white around them.
void PaintTag(const PhotoScene& scene, const Lens& lens, Canvas* canvas) {
  constexpr int kId = 7, kRing = 1;
  apriltag_family_t* family = tag36h11_create();
  image_u8_t* tag = apriltag_to_image(family, kId);
  const double cell = scene.tag_side / (tag->width - 2 * kRing);
  for (int row = 0; row < tag->height; ++row)
    for (int col = 0; col < tag->width; ++col) {
      const Rgb shade = Rgb::Constant(tag->buf[row * tag->stride + col] > 0 ? 0.92 : 0.06);
      const auto at = [&](int i, int k) -> Vector3d {
        return scene.tag_place +
               cell * Vector3d(col + i - 0.5 * tag->width, 0.5 * tag->height - row - k, 0);
      };
      const Vector3d upper[3] = {at(0, 0), at(1, 0), at(1, 1)};
      const Vector3d lower[3] = {at(0, 0), at(1, 1), at(0, 1)};
      PaintTriangle(lens, upper, Plain(shade), canvas);
      PaintTriangle(lens, lower, Plain(shade), canvas);
    }
  std::free(tag->buf);
  std::free(tag);
  tag36h11_destroy(family);
}

using Picture = std::vector<Eigen::Vector3f>;

void BlurRows(Picture* image, int width, int height, const std::vector<double>& kernel) {
  const int reach = static_cast<int>(kernel.size()) / 2;
  Picture line(width);
  for (int row = 0; row < height; ++row) {
    for (int col = 0; col < width; ++col) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int k = -reach; k <= reach; ++k)
        sum += static_cast<float>(kernel[size_t(k + reach)]) *
               (*image)[size_t(row) * width + std::clamp(col + k, 0, width - 1)];
      line[col] = sum;
    }
    std::copy(line.begin(), line.end(), image->begin() + static_cast<long>(size_t(row) * width));
  }
}

Picture Transposed(const Picture& image, int width, int height) {
  Picture turned(image.size());
  for (int row = 0; row < height; ++row)
    for (int col = 0; col < width; ++col)
      turned[size_t(col) * height + row] = image[size_t(row) * width + col];
  return turned;
}

std::vector<double> Gaussian(double sigma) {
  const int reach = std::max(1, static_cast<int>(std::ceil(3 * sigma)));
  std::vector<double> kernel;
  double sum = 0;
  for (int k = -reach; k <= reach; ++k) {
    kernel.push_back(std::exp(-0.5 * std::pow(k / std::max(sigma, 1e-3), 2)));
    sum += kernel.back();
  }
  for (double& weight : kernel) weight /= sum;
  return kernel;
}

void Blur(const PhotoScene& scene, Picture* image) {
  const std::vector<double> kernel = Gaussian(scene.blur);
  BlurRows(image, scene.width, scene.height, kernel);
  *image = Transposed(*image, scene.width, scene.height);
  BlurRows(image, scene.height, scene.width, kernel);
  *image = Transposed(*image, scene.height, scene.width);
  if (scene.motion < 1) return;
  const int length = 2 * static_cast<int>(scene.motion / 2) + 1;
  BlurRows(image, scene.width, scene.height, std::vector<double>(length, 1.0 / length));
}

// The light of each pixel: the mean of its samples.
Picture PixelLight(const PhotoScene& scene, const Canvas& canvas) {
  Picture image(size_t(scene.width) * scene.height, Eigen::Vector3f::Zero());
  for (int row = 0; row < canvas.height; ++row)
    for (int col = 0; col < canvas.width; ++col)
      image[size_t(row / kFine) * scene.width + col / kFine] +=
          canvas.light[size_t(row) * canvas.width + col] / (kFine * kFine);
  return image;
}

void AddGlare(const PhotoScene& scene, const Lens& lens, Picture* image) {
  const Vector2d spot = lens.Project({0.11, 0.05, -0.03}) / kFine;
  const double reach = (lens.Project({0.11 + scene.glare, 0.05, -0.03}) / kFine - spot).norm();
  for (int row = 0; row < scene.height; ++row)
    for (int col = 0; col < scene.width; ++col)
      (*image)[size_t(row) * scene.width + col].array() +=
          static_cast<float>(2 * Smooth(2 - (Vector2d(col, row) - spot).norm() / reach));
}

}  // namespace

RgbImage RenderPhoto(const PhotoScene& scene, const std::vector<ScenePiece>& pieces) {
  const Lens lens(scene);
  Canvas canvas{kFine * scene.width, kFine * scene.height, {}, {}};
  canvas.depth.assign(size_t(canvas.width) * canvas.height, 0.0f);
  canvas.light.resize(canvas.depth.size());
  PaintGround(scene, lens, pieces, &canvas);
  for (const ScenePiece& piece : pieces) {
    PaintCloth(scene, lens, piece, &canvas);
    if (scene.has_disc) PaintDisc(scene, lens, piece.place + scene.disc_place, &canvas);
  }
  for (const ScenePatch& patch : scene.patches) PaintPatch(lens, patch, &canvas);
  if (scene.tag_side > 0) PaintTag(scene, lens, &canvas);
  Picture image = PixelLight(scene, canvas);
  if (scene.glare > 0) AddGlare(scene, lens, &image);
  Blur(scene, &image);
  std::mt19937 random(scene.seed);
  std::normal_distribution<float> noise(0, static_cast<float>(scene.noise));
  RgbImage result{scene.width, scene.height, {}};
  result.rgb.reserve(3 * image.size());
  for (int row = 0; row < scene.height; ++row)
    for (int col = 0; col < scene.width; ++col) {
      const double light = scene.exposure * (1 + scene.falloff * (double(col) / scene.width - 0.5));
      for (int c = 0; c < 3; ++c) {
        const double seen = StoredFromLight(light * image[size_t(row) * scene.width + col][c]);
        const double s = std::clamp(seen, 0.0, 1.0);
        const double toned = s + scene.tone * s * (1 - s) * (2 * s - 1);
        result.rgb.push_back(
            static_cast<uint8_t>(std::lround(255 * std::clamp(toned + noise(random), 0.0, 1.0))));
      }
    }
  return result;
}

PhotoScene SmallScene() {
  PhotoScene scene;
  scene.width = 1000;
  scene.height = 750;
  scene.focal_35mm = 38;
  return scene;
}

std::vector<uint8_t> GreyLevels(const RgbImage& image) {
  std::vector<uint8_t> grey;
  for (size_t i = 0; i < image.rgb.size(); i += 3)
    grey.push_back(
        static_cast<uint8_t>((image.rgb[i] + 2 * image.rgb[i + 1] + image.rgb[i + 2]) / 4));
  return grey;
}

PhotoScene RandomScene(unsigned number) {
  std::mt19937 random(number * 7919 + 17);
  const auto uniform = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  constexpr double kDegree = M_PI / 180;
  const Rgb cloths[] = {{0.16, 0.2, 0.45}, {0.62, 0.14, 0.16}, {0.12, 0.12, 0.13},
                        {0.9, 0.88, 0.82}, {0.2, 0.45, 0.25},  {0.85, 0.7, 0.2},
                        {0.55, 0.5, 0.62}, {0.75, 0.45, 0.5}};
  const Rgb light_grounds[] = {{0.85, 0.84, 0.8}, {0.66, 0.7, 0.72}, {0.75, 0.66, 0.52}};
  const Rgb dark_grounds[] = {{0.2, 0.24, 0.22}, {0.12, 0.2, 0.32}, {0.3, 0.2, 0.14}};
  PhotoScene scene;
  scene.seed = number;
  scene.cloth = cloths[number % 8];
  const bool light_cloth = scene.cloth.mean() > 0.5;
  scene.ground = light_cloth ? dark_grounds[number % 3] : light_grounds[number % 3];
  scene.disc = scene.cloth.mean() > 0.4 ? Rgb(0.22, 0.2, 0.18) : Rgb(0.8, 0.78, 0.74);
  const double tilt = uniform(0, 10) * kDegree, direction = uniform(0, 2 * M_PI);
  scene.tilt = tilt * Vector2d(std::cos(direction), std::sin(direction));
  const double height = uniform(0.85, 1.2);
  // Aimed within 4 cm of the support: the axis meets the ground at eye + H(−tilt_y, tilt_x).
  scene.eye = {height * scene.tilt.y() + uniform(-0.04, 0.04),
               -height * scene.tilt.x() + uniform(-0.04, 0.04), height};
  scene.focal_35mm = std::lround(uniform(24, 28));
  scene.ground_height = uniform(-0.3, -0.12);
  scene.light = {uniform(-0.45, 0.45), uniform(-0.45, 0.45)};
  scene.shadow = uniform(0.1, 0.45);
  scene.falloff = uniform(-0.25, 0.25);
  scene.texture = uniform(0.0, 0.04);
  scene.noise = uniform(0.004, 0.02);
  scene.blur = uniform(0.5, 1.4);
  scene.jpeg_quality = static_cast<int>(uniform(80, 95));
  scene.orientation = number % 2 ? 1 : 8;
  return scene;
}

}  // namespace drape
