#include "tests/capture/stream/stream_receiver.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include "capture/libav.h"
#include "capture/studio_clock.h"

namespace floatstage::capture {
namespace {

Image rgb_of(const AVFrame& frame) {
  Image rgb(frame.width, frame.height, 3);
  const libav::Owned<SwsContext> scaler(
      sws_getContext(frame.width, frame.height, static_cast<AVPixelFormat>(frame.format), frame.width,
                     frame.height, AV_PIX_FMT_RGB24, SWS_BILINEAR, nullptr, nullptr, nullptr));
  libav::set_bt709(scaler.get(), false, true);
  std::uint8_t* planes[4] = {rgb.pixels.data(), nullptr, nullptr, nullptr};
  const int strides[4] = {3 * frame.width, 0, 0, 0};
  sws_scale(scaler.get(), frame.data, frame.linesize, 0, frame.height, planes, strides);
  return rgb;
}

}  // namespace

bool play_stream(const std::string& url, const std::function<bool(const ReceivedPicture&)>& visit,
                 const std::function<bool()>& stop, bool keep_probed) {
  AVFormatContext* made = avformat_alloc_context();
  const auto interrupted = [](void* asked) {
    return (*static_cast<const std::function<bool()>*>(asked))() ? 1 : 0;
  };
  made->interrupt_callback = {interrupted, const_cast<std::function<bool()>*>(&stop)};
  libav::Options options;
  if (!keep_probed) options.set("fflags", "nobuffer");
  options.set("probesize", "32768").set("analyzeduration", "500000");
  if (avformat_open_input(&made, url.c_str(), nullptr, options.get()) < 0) return false;
  const libav::Format input(made);
  if (avformat_find_stream_info(made, nullptr) < 0 || made->nb_streams < 1) return false;
  const libav::Owned<AVCodecContext> decoder(avcodec_alloc_context3(avcodec_find_decoder(AV_CODEC_ID_H264)));
  avcodec_parameters_to_context(decoder.get(), made->streams[0]->codecpar);
  decoder->flags |= AV_CODEC_FLAG_LOW_DELAY;
  decoder->thread_count = 1;
  avcodec_open2(decoder.get(), nullptr, nullptr);
  const auto packet = libav::new_packet();
  const auto frame = libav::new_frame();
  while (!stop() && av_read_frame(made, packet.get()) >= 0) {
    avcodec_send_packet(decoder.get(), packet.get());
    av_packet_unref(packet.get());
    while (avcodec_receive_frame(decoder.get(), frame.get()) >= 0) {
      const Timestamp decoded = studio_now();
      const double time = static_cast<double>(frame->pts) * av_q2d(made->streams[0]->time_base);
      if (!visit({rgb_of(*frame), time, frame->key_frame != 0, decoded})) return true;
    }
  }
  return true;
}

int free_udp_port() {
  const int probe = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ::bind(probe, reinterpret_cast<sockaddr*>(&address), size);
  ::getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size);
  ::close(probe);
  return ntohs(address.sin_port);
}

}  // namespace floatstage::capture
