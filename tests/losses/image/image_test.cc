// SPDX-License-Identifier: Apache-2.0
#include "losses/image/image.h"

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include <csignal>
#include <functional>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "tests/losses/image/encode.h"
#include "tests/losses/temp_folder.h"

namespace drape {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

// A dark box on white, as grey levels.
std::vector<uint8_t> Box(int width, int height, uint8_t dark = 0) {
  std::vector<uint8_t> gray(size_t(width) * height, 255);
  for (int row = height / 4; row < height / 2; ++row) {
    for (int col = width / 4; col < 3 * width / 4; ++col) gray[row * width + col] = dark;
  }
  return gray;
}

std::vector<uint8_t> Repeat(const std::vector<uint8_t>& gray, int channels) {
  std::vector<uint8_t> pixels;
  for (uint8_t value : gray) pixels.insert(pixels.end(), channels, value);
  return pixels;
}

GrayImage Coverage(const std::vector<uint8_t>& gray, int width, int height) {
  GrayImage image(width, height);
  for (size_t i = 0; i < gray.size(); ++i) image.coverage[i] = 1 - gray[i] / 255.0f;
  return image;
}

class ImageFile : public testing::Test {
 protected:
  std::string Put(const std::string& name, const std::vector<uint8_t>& bytes) {
    EXPECT_FALSE(bytes.empty());
    WriteAll(folder_ / name, bytes);
    return folder_ / name;
  }
  void ExpectSame(const std::string& path, const GrayImage& expected, float tolerance) {
    const GrayImage image = ReadImage(path);
    ASSERT_EQ(image.width, expected.width);
    ASSERT_EQ(image.height, expected.height);
    EXPECT_THAT(image.coverage,
                testing::Pointwise(testing::FloatNear(tolerance), expected.coverage))
        << path;
  }
  void ExpectBad(const std::string& path, const std::string& problem) {
    EXPECT_THAT([&] { ReadImage(path); },
                ThrowsMessage<InputError>(AllOf(HasSubstr(path + ": "), HasSubstr(problem))));
  }
  TempFolder folder_;
};

TEST_F(ImageFile, ReadsGrayAndColourJpegOfAnySize) {
  const GrayImage expected = Coverage(Box(64, 40), 64, 40);
  ExpectSame(Put("gray.jpg", EncodeJpeg(Box(64, 40), 64, 40, 1)), expected, 0.03f);
  ExpectSame(Put("rgb.png", EncodeJpeg(Repeat(Box(64, 40), 3), 64, 40, 3)), expected, 0.03f);
}

TEST_F(ImageFile, ReadsPngOfEveryKind) {
  const int w = 50, h = 30;
  const auto gray = Box(w, h, 60);
  const GrayImage expected = Coverage(gray, w, h);
  ExpectSame(Put("gray.png", EncodePng(gray.data(), w, h, PNG_FORMAT_GRAY)), expected, 0);
  ExpectSame(Put("rgb.jpg", EncodePng(Repeat(gray, 3).data(), w, h, PNG_FORMAT_RGB)), expected,
             0.005f);
  auto rgba = Repeat(gray, 4);
  for (size_t i = 3; i < rgba.size(); i += 4) rgba[i] = 255;
  ExpectSame(Put("rgba.png", EncodePng(rgba.data(), w, h, PNG_FORMAT_RGBA)), expected, 0.005f);
  std::vector<uint8_t> indices(gray.size());
  for (size_t i = 0; i < gray.size(); ++i) indices[i] = gray[i] == 255 ? 1 : 0;
  const std::vector<uint8_t> palette = {60, 60, 60, 255, 255, 255};
  ExpectSame(
      Put("palette.png", EncodePng(indices.data(), w, h, PNG_FORMAT_RGB_COLORMAP, palette, 2)),
      expected, 0.005f);
}

TEST_F(ImageFile, TransparentPixelsAreBackground) {
  const auto gray = Box(32, 32);
  std::vector<uint8_t> rgba(4 * gray.size(), 0);  // black everywhere, transparent outside the box
  for (size_t i = 0; i < gray.size(); ++i) rgba[4 * i + 3] = 255 - gray[i];
  ExpectSame(Put("alpha.png", EncodePng(rgba.data(), 32, 32, PNG_FORMAT_RGBA)),
             Coverage(gray, 32, 32), 0.005f);
}

TEST_F(ImageFile, WritePngRoundTrip) {
  const GrayImage image = Coverage(Box(40, 33, 77), 40, 33);
  WritePng(image, folder_ / "out.png");
  ExpectSame(folder_ / "out.png", image, 1e-6f);
}

TEST_F(ImageFile, RejectsFilesThatAreNoImages) {
  ExpectBad(folder_ / "missing.jpg", "no such file");
  ExpectBad(folder_.path(), "is a folder");
  WriteAll(folder_ / "empty.png", {});
  ExpectBad(folder_ / "empty.png", "is empty");
  ExpectBad(Put("text.jpg", {'h', 'e', 'l', 'l', 'o'}), "neither JPEG nor PNG");
  ExpectBad(Put("start.jpg", {0xFF, 0xD8, 0xFF}), "truncated or damaged JPEG");
  ExpectBad(Put("start.png", {0x89, 'P', 'N', 'G', 13, 10, 26, 10}), "truncated or damaged PNG");
  ExpectBad(Put("cmyk.jpg", EncodeJpeg(Repeat(Box(32, 32), 4), 32, 32, 4)), "4 channels");
}

TEST_F(ImageFile, RejectsTruncatedImages) {
  const std::vector<uint8_t> jpeg = EncodeJpeg(Box(64, 64), 64, 64, 1);
  const std::vector<uint8_t> png = EncodePng(Box(64, 64).data(), 64, 64, PNG_FORMAT_GRAY);
  for (double share : {0.3, 0.6, 0.9}) {
    ExpectBad(Put("cut.jpg", {jpeg.begin(), jpeg.begin() + size_t(share * jpeg.size())}),
              "truncated or damaged JPEG");
  }
  for (double share : {0.3, 0.5, 0.7}) {
    ExpectBad(Put("cut.png", {png.begin(), png.begin() + size_t(share * png.size())}),
              "truncated or damaged PNG");
  }
}

// Scanners state the dots an inch: 300 of them are 11811 in a metre.
TEST_F(ImageFile, StatesItsScale) {
  const auto gray = Box(64, 64);
  std::vector<uint8_t> png = EncodePng(gray.data(), 64, 64, PNG_FORMAT_GRAY);
  const auto chunk = [&](uint32_t x, uint32_t y, uint8_t unit) {
    std::vector<uint8_t> bytes = png, more = {0, 0, 0, 9, 'p', 'H', 'Y', 's'};
    for (const uint32_t number : {x, y})
      for (int shift = 24; shift >= 0; shift -= 8) more.push_back(uint8_t(number >> shift));
    more.insert(more.end(), {unit, 0, 0, 0, 0});
    bytes.insert(bytes.begin() + 33, more.begin(), more.end());
    return Put("scan.png", bytes);
  };
  EXPECT_EQ(ReadPixelsPerMetre(chunk(11811, 11811, 1)), 11811);
  const auto expect_bad = [](const std::string& path, const std::string& text) {
    EXPECT_THAT([&] { ReadPixelsPerMetre(path); }, ThrowsMessage<InputError>(HasSubstr(text)));
  };
  expect_bad(chunk(11811, 23622, 1), "scan.png: states 299.999 and 599.999 dots an inch");
  expect_bad(chunk(1, 1, 0), "states 0 and 0 dots");
  expect_bad(Put("plain.png", png), "states 0 and 0 dots");
  std::vector<uint8_t> jpeg = EncodeJpeg(gray, 64, 64, 1);
  ASSERT_EQ(jpeg[6], 'J');
  const auto jfif = [&](uint8_t unit, uint8_t x) {
    jpeg[13] = unit;
    jpeg[14] = jpeg[16] = 0;
    jpeg[15] = jpeg[17] = x;
    return Put("scan.jpg", jpeg);
  };
  EXPECT_DOUBLE_EQ(ReadPixelsPerMetre(jfif(1, 254)), 1e4);
  EXPECT_DOUBLE_EQ(ReadPixelsPerMetre(jfif(2, 100)), 1e4);
  expect_bad(jfif(0, 1), "states 0 and 0 dots");
  testing::internal::CaptureStderr();
  EXPECT_DOUBLE_EQ(ReadPixelsPerMetre(jfif(1, 72)), 72 / 0.0254);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("states 72 dots an inch, which"));
  // EXIF, little-endian, before what JFIF leaves open: 200/2 in a centimetre.
  std::vector<uint8_t> exif = {
      0xFF, 0xE1, 0,  82,  'E', 'x', 'i',  'f', 0, 0,  'I', 'I', 42, 0,    8, 0, 0, 0, 3,
      0,    0x1A, 1,  5,   0,   1,   0,    0,   0, 50, 0,   0,   0,  0x1B, 1, 5, 0, 1, 0,
      0,    0,    58, 0,   0,   0,   0x28, 1,   3, 0,  1,   0,   0,  0,    3, 0, 0, 0, 0,
      0,    0,    0,  200, 0,   0,   0,    2,   0, 0,  0,   200, 0,  0,    0, 2, 0, 0, 0};
  exif[3] = uint8_t(exif.size() - 2);
  jfif(0, 1);
  jpeg.insert(jpeg.begin() + 20, exif.begin(), exif.end());
  EXPECT_DOUBLE_EQ(ReadPixelsPerMetre(Put("camera.jpg", jpeg)), 1e4);
}

// Some telephones write bytes between the last pixel and the end marker; elsewhere they are damage.
TEST_F(ImageFile, AcceptsStrayBytesBeforeTheEndAlone) {
  const std::vector<uint8_t> jpeg = EncodeJpeg(Box(64, 64), 64, 64, 1);
  std::vector<uint8_t> stray = jpeg;
  stray.insert(stray.end() - 2, {0, 1, 2, 3});
  ExpectSame(Put("stray.jpg", stray), ReadImage(Put("plain.jpg", jpeg)), 0);
  stray = jpeg;
  stray.insert(stray.begin() + 20, {0, 1, 2, 3});  // between two segments
  ExpectBad(Put("early.jpg", stray), "truncated or damaged JPEG: Corrupt JPEG data");
}

TEST_F(ImageFile, RejectsTooManyPixels) {
  std::vector<uint8_t> jpeg = EncodeJpeg(Box(64, 64), 64, 64, 1);
  for (size_t i = 0; i + 9 < jpeg.size(); ++i) {  // the size in the start-of-frame marker
    if (jpeg[i] == 0xFF && jpeg[i + 1] == 0xC0) jpeg[i + 5] = jpeg[i + 7] = 0xFF;
  }
  ExpectBad(Put("huge.jpg", jpeg), "at most 2^26 pixels");
}

void AppendTo(std::vector<uint8_t>* bytes, const std::vector<uint8_t>& more) {
  bytes->insert(bytes->end(), more.begin(), more.end());
}

// The payload of an EXIF segment that says how the camera was held.
std::vector<uint8_t> MakeExif(int orientation, bool big_endian) {
  const auto two = [&](int v) {
    return big_endian ? std::vector<uint8_t>{uint8_t(v >> 8), uint8_t(v)}
                      : std::vector<uint8_t>{uint8_t(v), uint8_t(v >> 8)};
  };
  std::vector<uint8_t> exif = {'E', 'x', 'i', 'f', 0, 0};
  AppendTo(&exif, big_endian ? std::vector<uint8_t>{'M', 'M'} : std::vector<uint8_t>{'I', 'I'});
  AppendTo(&exif, two(42));
  AppendTo(&exif, big_endian ? std::vector<uint8_t>{0, 0, 0, 8} : std::vector<uint8_t>{8, 0, 0, 0});
  AppendTo(&exif, two(2));  // entries
  for (const auto& [tag, value] : {std::pair{0x0100, 77}, std::pair{0x0112, orientation}}) {
    AppendTo(&exif, two(tag));
    AppendTo(&exif, two(3));  // SHORT
    AppendTo(&exif,
             big_endian ? std::vector<uint8_t>{0, 0, 0, 1} : std::vector<uint8_t>{1, 0, 0, 0});
    AppendTo(&exif, two(value));
    AppendTo(&exif, {0, 0});
  }
  AppendTo(&exif, {0, 0, 0, 0});
  return exif;
}

std::vector<uint8_t> WithExif(const std::vector<uint8_t>& jpeg, const std::vector<uint8_t>& exif) {
  std::vector<uint8_t> all(jpeg.begin(), jpeg.begin() + 2);
  const size_t length = exif.size() + 2;
  AppendTo(&all, {0xFF, 0xE1, uint8_t(length >> 8), uint8_t(length)});
  AppendTo(&all, exif);
  all.insert(all.end(), jpeg.begin() + 2, jpeg.end());
  return all;
}

// The same as a chunk of a PNG, before or after the chunks of the picture.
std::vector<uint8_t> WithExifChunk(const std::vector<uint8_t>& png,
                                   const std::vector<uint8_t>& exif, bool is_first) {
  constexpr size_t kFirst = 8 + 25, kEnd = 12;  // after IHDR; the length of IEND
  std::vector<uint8_t> typed = {'e', 'X', 'I', 'f'};
  typed.insert(typed.end(), exif.begin() + 6, exif.end());
  const auto at = png.begin() + static_cast<long>(is_first ? kFirst : png.size() - kEnd);
  const auto number = [](uint32_t n) {
    return std::vector<uint8_t>{uint8_t(n >> 24), uint8_t(n >> 16), uint8_t(n >> 8), uint8_t(n)};
  };
  std::vector<uint8_t> all(png.begin(), at);
  AppendTo(&all, number(static_cast<uint32_t>(typed.size() - 4)));
  AppendTo(&all, typed);
  AppendTo(&all, number(static_cast<uint32_t>(crc32(0, typed.data(), uInt(typed.size())))));
  all.insert(all.end(), at, png.end());
  return all;
}

// The stored image is 64 × 40 with a dark box in its top left corner; where it is shown follows
// from the definition of the tag.
TEST_F(ImageFile, HonoursAllExifOrientations) {
  const int w = 64, h = 40;
  std::vector<uint8_t> gray(w * h, 255);
  for (int row = 0; row < 16; ++row)
    for (int col = 0; col < 24; ++col) gray[row * w + col] = 0;
  const auto jpeg = EncodeJpeg(gray, w, h, 1), png = EncodePng(gray.data(), w, h, PNG_FORMAT_GRAY);
  struct Shown {
    bool exchanged, right, bottom;  // width with height; where the box is
  };
  const Shown shown[] = {{false, false, false}, {false, true, false}, {false, true, true},
                         {false, false, true},  {true, false, false}, {true, true, false},
                         {true, true, true},    {true, false, true}};
  for (int kind = 0; kind < 4; ++kind) {
    for (int orientation = 1; orientation <= 8; ++orientation) {
      const std::vector<uint8_t> exif = MakeExif(orientation, kind % 2 == 1);
      const GrayImage image = ReadImage(
          Put("o", kind < 2 ? WithExif(jpeg, exif) : WithExifChunk(png, exif, kind == 2)));
      const auto& [exchanged, right, bottom] = shown[orientation - 1];
      ASSERT_EQ(image.width, exchanged ? h : w) << orientation;
      ASSERT_EQ(image.height, exchanged ? w : h) << orientation;
      const int wide = exchanged ? 16 : 24, high = exchanged ? 24 : 16;
      for (int row = 0; row < image.height; ++row) {
        for (int col = 0; col < image.width; ++col) {
          const bool inside = (right ? col >= image.width - wide : col < wide) &&
                              (bottom ? row >= image.height - high : row < high);
          ASSERT_NEAR(image.at(col, row), inside, 0.1)
              << kind << ", " << orientation << ": " << col << ", " << row;
        }
      }
    }
  }
  for (const int unknown : {0, 9, 300})
    EXPECT_EQ(ReadImage(Put("o.jpg", WithExif(jpeg, MakeExif(unknown, true)))).width, w);
}

TEST_F(ImageFile, DamagedExifIsUpright) {
  const auto jpeg = EncodeJpeg(Box(64, 40), 64, 40, 1);
  const auto width = [&](const std::vector<uint8_t>& exif) {
    return ReadImage(Put("o.jpg", WithExif(jpeg, exif))).width;
  };
  const std::vector<uint8_t> exif = MakeExif(6, false);
  ASSERT_EQ(width(exif), 40);
  for (size_t size = 0; size < exif.size() - 6; ++size)  // the last 6 bytes are padding
    EXPECT_EQ(width({exif.begin(), exif.begin() + size}), 64) << size;
  std::vector<uint8_t> far = exif;
  for (int i = 10; i < 14; ++i) far[i] = 0xFF;  // the directory lies outside
  EXPECT_EQ(width(far), 64);
}

// Runs `body` in a child process, so that its limits and user do not affect the other tests.
// Returns whether it returned true.
bool InChild(const std::function<bool()>& body) {
  const pid_t child = fork();
  if (child == 0) _exit(body() ? 0 : 1);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

// Returns whether writing fails with an IoError that names the path.
bool WriteIsRefused(const std::string& path) {
  try {
    WritePng(GrayImage(200, 200, 0.25f), path);
  } catch (const IoError& error) {
    return std::string(error.what()).find(path + ": cannot ") == 0;
  }
  return false;
}

class OldFile : public ImageFile {
 protected:
  OldFile() : path_(Put("old.png", old_bytes_)) {}
  void ExpectUntouched() {
    EXPECT_EQ(ReadAll(path_), old_bytes_);
    const std::filesystem::directory_iterator files(folder_.path());
    EXPECT_EQ(std::distance(begin(files), end(files)), 1) << "a temporary file was left behind";
  }
  const std::vector<uint8_t> old_bytes_ = {'o', 'l', 'd'};
  const std::string path_;
};

TEST_F(OldFile, IsReplacedByASuccess) {
  WritePng(GrayImage(20, 20, 0.25f), path_);
  EXPECT_EQ(ReadImage(path_).at(3, 3), ReadImage(path_).at(0, 0));
  EXPECT_NE(ReadAll(path_), old_bytes_);
}

TEST_F(OldFile, SurvivesAFullDisk) {
  EXPECT_TRUE(InChild([&] {
    std::signal(SIGXFSZ, SIG_IGN);  // then write() fails with EFBIG, as it would with ENOSPC
    const rlimit limit = {20, 20};
    setrlimit(RLIMIT_FSIZE, &limit);
    return WriteIsRefused(path_);
  }));
  ExpectUntouched();
}

TEST_F(OldFile, SurvivesAnUnwritableFolder) {
  std::filesystem::permissions(folder_.path(), std::filesystem::perms(0555));
  EXPECT_TRUE(InChild([&] {
    if (geteuid() == 0 && seteuid(65534) != 0) return false;  // root may write everywhere
    return WriteIsRefused(path_);
  }));
  std::filesystem::permissions(folder_.path(), std::filesystem::perms(0755));
  ExpectUntouched();
}

TEST_F(OldFile, WritingIntoNoFolderOrOverAFolderIsRefused) {
  EXPECT_TRUE(WriteIsRefused(folder_ / "none/out.png"));
  EXPECT_TRUE(WriteIsRefused(path_ + "/out.png"));
  EXPECT_TRUE(WriteIsRefused(folder_.path()));
  ExpectUntouched();
}

// A comment that says of which discs a silhouette is changes no pixel.
TEST(WritePng, KeepsTheDiscsOfADrape) {
  const TempFolder folder;
  GrayImage image(64, 48);
  image.at(20, 30) = 1;
  WritePng(image, folder / "a.png", DrapeDiscs{0.18, 0.09});
  WritePng(image, folder / "b.png");
  EXPECT_EQ(ReadPngDiscs(folder / "a.png"), (DrapeDiscs{0.18, 0.09}));
  EXPECT_EQ(ReadPngDiscs(folder / "b.png"), std::nullopt);
  EXPECT_EQ(ReadImage(folder / "a.png").coverage, image.coverage);
  WriteAll(folder / "c.png", {1, 2, 3});
  EXPECT_EQ(ReadPngDiscs(folder / "c.png"), std::nullopt);
  std::vector<uint8_t> cut = ReadAll(folder / "a.png");
  cut.resize(50);
  WriteAll(folder / "d.png", cut);
  EXPECT_EQ(ReadPngDiscs(folder / "d.png"), std::nullopt);
}

}  // namespace
}  // namespace drape
