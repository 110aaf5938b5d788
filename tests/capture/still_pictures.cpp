#include "tests/capture/still_pictures.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavutil/imgutils.h>
#include <libavutil/pixdesc.h>
}

#include <cstring>
#include <vector>

namespace floatstage::capture {

std::string encode_still(const char* encoder, const char* pixel_format, int width, int height,
                         const std::function<unsigned(int x, int y, int component)>& sample) {
  const AVCodec* codec = avcodec_find_encoder_by_name(encoder);
  if (!codec) return {};
  AVCodecContext* context = avcodec_alloc_context3(codec);
  context->width = width;
  context->height = height;
  context->pix_fmt = av_get_pix_fmt(pixel_format);
  context->time_base = {1, 25};
  context->color_range = AVCOL_RANGE_JPEG;
  context->flags |= AV_CODEC_FLAG_QSCALE;
  context->global_quality = FF_QP2LAMBDA;
  AVFrame* frame = av_frame_alloc();
  frame->format = context->pix_fmt;
  frame->width = width;
  frame->height = height;
  frame->quality = context->global_quality;
  frame->color_range = AVCOL_RANGE_JPEG;
  AVPacket* packet = av_packet_alloc();
  std::string bytes;
  if (av_frame_get_buffer(frame, 0) >= 0 && avcodec_open2(context, codec, nullptr) >= 0) {
    for (int i = 0; i < AV_NUM_DATA_POINTERS && frame->buf[i]; ++i)
      std::memset(frame->buf[i]->data, 0, frame->buf[i]->size);
    const AVPixFmtDescriptor* description = av_pix_fmt_desc_get(context->pix_fmt);
    for (int c = 0; c < description->nb_components; ++c) {
      const bool chroma = c == 1 || c == 2;
      const int w = chroma ? AV_CEIL_RSHIFT(width, description->log2_chroma_w) : width;
      const int h = chroma ? AV_CEIL_RSHIFT(height, description->log2_chroma_h) : height;
      for (int y = 0; y < h; ++y) {
        std::vector<std::uint16_t> line(static_cast<std::size_t>(w));
        for (int x = 0; x < w; ++x)
          line[static_cast<std::size_t>(x)] = static_cast<std::uint16_t>(sample(x, y, c));
        av_write_image_line(line.data(), frame->data, frame->linesize, description, 0, y, c, w);
      }
    }
    if (avcodec_send_frame(context, frame) >= 0 && avcodec_send_frame(context, nullptr) >= 0 &&
        avcodec_receive_packet(context, packet) >= 0)
      bytes.assign(reinterpret_cast<const char*>(packet->data), static_cast<std::size_t>(packet->size));
  }
  av_packet_free(&packet);
  av_frame_free(&frame);
  avcodec_free_context(&context);
  return bytes;
}

}  // namespace floatstage::capture
