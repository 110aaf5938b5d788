// FFV1 pictures of any encoder, of which a decoder is given no more than a box needs.

#include "capture/ffv1_slices.h"

#include <algorithm>
#include <array>
#include <random>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/libav.h"
#include "core/text.h"

extern "C" {
#include <libavutil/pixdesc.h>
}

namespace floatstage::capture {
namespace {

using Bytes = std::vector<std::uint8_t>;

struct Coded {
  Bytes configuration;
  std::vector<Bytes> pictures;
};

struct Coding {
  AVPixelFormat format;
  const char* coder;
  int width, height, slices;
  int group = 1, level = 3;
};

int rows_of(const AVPixFmtDescriptor& format, int plane, int height) {
  return plane == 0 ? height : AV_CEIL_RSHIFT(height, format.log2_chroma_h);
}

libav::Owned<AVFrame> new_picture(const Coding& coding) {
  libav::Owned<AVFrame> picture = libav::new_frame();
  picture->format = coding.format;
  picture->width = coding.width;
  picture->height = coding.height;
  EXPECT_GE(av_frame_get_buffer(picture.get(), 0), 0);
  return picture;
}

// `count` pictures of noise over a gradient, as libav's encoder makes them.
Coded encode(const Coding& coding, int count = 1) {
  libav::be_quiet();
  const AVCodec* codec = avcodec_find_encoder(AV_CODEC_ID_FFV1);
  const libav::Owned<AVCodecContext> encoder(avcodec_alloc_context3(codec));
  encoder->width = coding.width;
  encoder->height = coding.height;
  encoder->pix_fmt = coding.format;
  encoder->time_base = {1, 25};
  encoder->level = coding.level;
  encoder->gop_size = coding.group;
  encoder->slices = coding.slices;
  encoder->thread_count = 1;
  encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  libav::Options options;
  options.set("coder", coding.coder).set("slicecrc", "1");
  if (coding.level < 3) options.set("slicecrc", "0");
  EXPECT_GE(avcodec_open2(encoder.get(), codec, options.get()), 0);
  Coded coded;
  std::minstd_rand random(7);
  const AVPixFmtDescriptor& format = *av_pix_fmt_desc_get(coding.format);
  for (int k = 0; k < count; ++k) {
    const libav::Owned<AVFrame> picture = new_picture(coding);
    for (int plane = 0; plane < av_pix_fmt_count_planes(coding.format); ++plane)
      for (int y = 0; y < rows_of(format, plane, coding.height); ++y)
        for (int x = 0; x < picture->linesize[plane]; ++x)
          picture->data[plane][y * picture->linesize[plane] + x] =
              static_cast<std::uint8_t>(x / 2 + y / 3 + static_cast<int>(random() % 9));
    picture->pts = k;
    EXPECT_EQ(avcodec_send_frame(encoder.get(), picture.get()), 0);
    const libav::Owned<AVPacket> packet = libav::new_packet();
    EXPECT_EQ(avcodec_receive_packet(encoder.get(), packet.get()), 0);
    coded.pictures.emplace_back(packet->data, packet->data + packet->size);
  }
  coded.configuration.assign(encoder->extradata, encoder->extradata + encoder->extradata_size);
  return coded;
}

// A fresh decoder's picture; null where it makes none.
libav::Owned<AVFrame> decode(const Coding& coding, const Coded& coded, const Bytes& picture) {
  const AVCodec* codec = avcodec_find_decoder(AV_CODEC_ID_FFV1);
  const libav::Owned<AVCodecContext> decoder(avcodec_alloc_context3(codec));
  decoder->width = coding.width;
  decoder->height = coding.height;
  decoder->thread_count = 1;
  decoder->extradata_size = static_cast<int>(coded.configuration.size());
  decoder->extradata =
      static_cast<std::uint8_t*>(av_mallocz(coded.configuration.size() + AV_INPUT_BUFFER_PADDING_SIZE));
  std::copy(coded.configuration.begin(), coded.configuration.end(), decoder->extradata);
  EXPECT_GE(avcodec_open2(decoder.get(), codec, nullptr), 0);
  const libav::Owned<AVPacket> packet = libav::new_packet();
  EXPECT_EQ(av_new_packet(packet.get(), static_cast<int>(picture.size())), 0);
  std::copy(picture.begin(), picture.end(), packet->data);
  packet->flags |= AV_PKT_FLAG_KEY;
  libav::Owned<AVFrame> frame = libav::new_frame();
  if (avcodec_send_packet(decoder.get(), packet.get()) < 0) return nullptr;
  if (avcodec_receive_frame(decoder.get(), frame.get()) < 0) return nullptr;
  return frame;
}

// How many of the box's samples differ, in all planes.
int differing(const AVFrame& a, const AVFrame& b, const PixelBox& box) {
  const auto format = static_cast<AVPixelFormat>(a.format);
  const AVPixFmtDescriptor& described = *av_pix_fmt_desc_get(format);
  int count = 0;
  for (int plane = 0; plane < av_pix_fmt_count_planes(format); ++plane) {
    const int h = plane > 0 ? described.log2_chroma_w : 0, v = plane > 0 ? described.log2_chroma_h : 0;
    const int bytes = described.comp[0].step;  // all of a plane's samples are as wide
    for (int y = box.y >> v; y <= (box.y + box.height - 1) >> v; ++y)
      for (int x = (box.x >> h) * bytes; x < (((box.x + box.width - 1) >> h) + 1) * bytes; ++x)
        count += a.data[plane][y * a.linesize[plane] + x] != b.data[plane][y * b.linesize[plane] + x];
  }
  return count;
}

using SliceCase = std::tuple<AVPixelFormat, const char*, int>;

class PicturesOfAnyEncoder : public testing::TestWithParam<SliceCase> {};

TEST_P(PicturesOfAnyEncoder, AreReadFromTheSlicesOfABox) {
  const auto [format, coder, slices] = GetParam();
  const Coding coding{format, coder, 258, 202, slices};
  const Coded coded = encode(coding);
  const Bytes& whole = coded.pictures.at(0);
  ASSERT_TRUE(ffv1_intact(whole));
  const auto grid = Ffv1Slices::of(coded.configuration, coding.width, coding.height);
  ASSERT_TRUE(grid);
  const libav::Owned<AVFrame> expected = decode(coding, coded, whole);
  ASSERT_TRUE(expected);
  std::minstd_rand random(3);
  std::size_t least = whole.size();
  for (int k = 0; k < 12; ++k) {
    PixelBox box{static_cast<int>(random() % 250) & ~1, static_cast<int>(random() % 196) & ~1, 2, 2};
    box.width = 2 + (static_cast<int>(random() % static_cast<unsigned>(coding.width - box.x - 1)) & ~1);
    box.height = 2 + (static_cast<int>(random() % static_cast<unsigned>(coding.height - box.y - 1)) & ~1);
    if (k == 0) box = {0, 0, 2, 2};
    if (k == 1) box = {coding.width - 2, coding.height - 2, 2, 2};
    Bytes part = whole;
    const std::size_t size = grid->keep(part, std::array{box});
    ASSERT_GT(size, 0u) << k;
    part.resize(size);
    EXPECT_TRUE(ffv1_intact(part)) << k;
    least = std::min(least, size);
    const libav::Owned<AVFrame> got = decode(coding, coded, part);
    ASSERT_TRUE(got) << k;
    EXPECT_EQ(differing(*got, *expected, box), 0) << k;
  }
  EXPECT_LT(least,
            whole.size() * 2 / static_cast<std::size_t>(slices) + 40 * static_cast<std::size_t>(slices));
}

std::string name_of_coding(const testing::TestParamInfo<SliceCase>& info) {
  const auto [format, coder, slices] = info.param;
  return text(av_get_pix_fmt_name(format), "_", coder, "_", slices);
}

INSTANTIATE_TEST_SUITE_P(Codings, PicturesOfAnyEncoder,
                         testing::Combine(testing::Values(AV_PIX_FMT_BGR0, AV_PIX_FMT_GRAY8,
                                                          AV_PIX_FMT_YUV422P, AV_PIX_FMT_YUV420P),
                                          testing::Values("rice", "range_def", "range_tab"),
                                          testing::Values(4, 12, 64)),
                         name_of_coding);

TEST(Ffv1Pictures, AreNotShortenedWhereTheyAreNoKeyPictures) {
  const Coding coding{AV_PIX_FMT_GRAY8, "rice", 256, 192, 4, /*group=*/5};
  Coded coded = encode(coding, 2);
  const auto grid = Ffv1Slices::of(coded.configuration, coding.width, coding.height);
  ASSERT_TRUE(grid);
  const Bytes before = coded.pictures[1];
  const std::array corner{PixelBox{0, 0, 10, 10}};
  EXPECT_GT(grid->keep(coded.pictures[0], corner), 0u);
  EXPECT_EQ(grid->keep(coded.pictures[1], corner), 0u);
  EXPECT_EQ(coded.pictures[1], before);
}

TEST(Ffv1Pictures, OfVersionsWithoutSlicesAreReadWhole) {
  const Coding coding{AV_PIX_FMT_GRAY8, "rice", 64, 48, 1, 1, /*level=*/1};
  const Coded coded = encode(coding);
  EXPECT_FALSE(Ffv1Slices::of(coded.configuration, coding.width, coding.height));
}

TEST(Ffv1Pictures, WhoseSlicesAreDamagedStayAsTheyAre) {
  const Coding coding{AV_PIX_FMT_BGR0, "rice", 256, 192, 16};
  const Coded coded = encode(coding);
  const auto grid = Ffv1Slices::of(coded.configuration, coding.width, coding.height);
  ASSERT_TRUE(grid);
  const std::array corner{PixelBox{0, 0, 20, 20}}, opposite{PixelBox{200, 150, 20, 20}};
  Bytes damaged = coded.pictures[0];
  damaged[60] ^= 1;  // in the first slice
  Bytes part = damaged;
  EXPECT_EQ(grid->keep(part, corner), 0u);
  EXPECT_EQ(part, damaged);
  EXPECT_GT(grid->keep(part, opposite), 0u);  // where it is not looked at
}

// Sizes that do not add up, pictures that are cut, bits that flipped: nothing is written outside, and what is
// kept is whole.
TEST(Ffv1Pictures, OfForeignBytesAreKeptWholeOrNotAtAll) {
  const Coding coding{AV_PIX_FMT_YUV420P, "rice", 128, 96, 4};
  const Coded coded = encode(coding);
  const auto grid = Ffv1Slices::of(coded.configuration, coding.width, coding.height);
  ASSERT_TRUE(grid);
  std::minstd_rand random(11);
  for (int k = 0; k < 4000; ++k) {
    Bytes bytes = coded.pictures[0];
    if (k % 2 == 0)
      bytes.resize(random() % bytes.size());
    else
      for (int n = 0; n < 3; ++n) bytes[random() % bytes.size()] ^= 1U << random() % 8;
    const Bytes before = bytes;
    const std::size_t size =
        grid->keep(bytes, std::array{PixelBox{static_cast<int>(random() % 120), 10, 8, 8}});
    ASSERT_LE(size, bytes.size());
    if (size == 0) {
      EXPECT_EQ(bytes, before);
    } else {
      bytes.resize(size);
    }
  }
  for (std::size_t n = 0; n < coded.configuration.size(); ++n)
    for (int bit = 0; bit < 8; ++bit) {
      Bytes configuration = coded.configuration;
      configuration[n] ^= 1U << bit;
      if (const auto other = Ffv1Slices::of(configuration, coding.width, coding.height)) {
        Bytes bytes = coded.pictures[0];
        EXPECT_LE(other->keep(bytes, std::array{PixelBox{3, 3, 8, 8}}), bytes.size());
      }
    }
}

}  // namespace
}  // namespace floatstage::capture
