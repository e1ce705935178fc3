// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/wear_job.h"

#include <gmock/gmock.h>

#include <cstring>
#include <filesystem>

#include "tests/physics/file_fixture.h"
#include "tests/physics/io_error.h"
#include "tests/solver/prediction/garment/read_cache.h"

namespace drape {
namespace {

using test::ReadCacheFrames;

class GeometryCacheTest : public FileFixture {
 protected:
  static Eigen::VectorXd Frame(double value) {
    return Eigen::VectorXd::LinSpaced(6, value, value + .5);
  }
};

TEST_F(GeometryCacheTest, HasTheHeaderOfPc2AndFloats) {
  GeometryCacheWriter writer(Path("a.pc2"), 2);
  writer.Append(Frame(1));
  const std::string bytes = Read(Path("a.pc2"));
  ASSERT_EQ(bytes.size(), 32u + 24u);
  EXPECT_EQ(bytes.substr(0, 12), std::string("POINTCACHE2\0", 12));
  int32_t numbers[5];
  std::memcpy(numbers, bytes.data() + 12, sizeof(numbers));
  EXPECT_THAT(numbers, ::testing::ElementsAre(1, 2, 0, 0x3f800000, 1));  // 0 and 1 as floats
  float last;
  std::memcpy(&last, bytes.data() + 52, 4);
  EXPECT_EQ(last, 1.5f);
}

TEST_F(GeometryCacheTest, IsReadableAfterEveryFrame) {
  GeometryCacheWriter writer(Path("a.pc2"), 2);
  EXPECT_EQ(ReadCacheFrames(Path("a.pc2")).size(), 0u);
  for (int frame = 0; frame < 3; ++frame) {
    writer.Append(Frame(frame));
    const std::vector<Eigen::VectorXf> frames = ReadCacheFrames(Path("a.pc2"));
    ASSERT_EQ(frames.size(), frame + 1u);
    EXPECT_EQ(frames[frame], Frame(frame).cast<float>());
  }
}

TEST_F(GeometryCacheTest, ResumesAfterTheFramesThatAreKept) {
  {
    GeometryCacheWriter writer(Path("a.pc2"), 2);
    for (int frame = 0; frame < 4; ++frame) writer.Append(Frame(frame));
  }
  // Of a frame that an interrupted run had begun to write.
  std::filesystem::resize_file(Path("a.pc2"), 32 + 4 * 24 + 7);
  {
    GeometryCacheWriter writer(Path("a.pc2"), 2, 3);
    EXPECT_EQ(writer.num_frames(), 3);
    EXPECT_EQ(ReadCacheFrames(Path("a.pc2")).size(), 3u);
    writer.Append(Frame(9));
  }
  const std::vector<Eigen::VectorXf> frames = ReadCacheFrames(Path("a.pc2"));
  ASSERT_EQ(frames.size(), 4u);
  EXPECT_EQ(frames[2], Frame(2).cast<float>());
  EXPECT_EQ(frames[3], Frame(9).cast<float>());
  EXPECT_EQ(std::filesystem::file_size(Path("a.pc2")), 32u + 4 * 24u);
}

TEST_F(GeometryCacheTest, RefusesOtherFiles) {
  EXPECT_IO_ERROR(GeometryCacheWriter(Path("none.pc2"), 2, 1), "none.pc2: No such file");
  Write("text.pc2", "hello");
  EXPECT_INPUT_ERROR(GeometryCacheWriter(Path("text.pc2"), 2, 1), "text.pc2: not a point cache");
  { GeometryCacheWriter(Path("a.pc2"), 2).Append(Frame(0)); }
  EXPECT_INPUT_ERROR(GeometryCacheWriter(Path("a.pc2"), 3, 1), "found 1 frames of 2 points");
  EXPECT_INPUT_ERROR(GeometryCacheWriter(Path("a.pc2"), 2, 2), "expected 2 frames of 2");
  EXPECT_EQ(ReadCacheFrames(Path("a.pc2")).size(), 1u);  // nothing was lost
  Write("short.pc2", Read(Path("a.pc2")).substr(0, 40));
  EXPECT_INPUT_ERROR(GeometryCacheWriter(Path("short.pc2"), 2, 1),
                     "found 40 bytes, expected 1 frames");
}

}  // namespace
}  // namespace drape
