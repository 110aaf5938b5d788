#include "apps/check/studio.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "capture/frame_source.h"
#include "capture/sound/sound_source.h"
#include "core/file_presence.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "studio/node/capture_config.h"

namespace floatstage::apps {
namespace {

using Verdict = Finding::Verdict;

// Starts the camera, for what only it knows: the size of its pictures.
Result<capture::StreamInfo> ask_camera(const studio::CaptureConfig::Camera& camera,
                                       const std::function<bool()>& stop) {
  Result<std::unique_ptr<capture::FrameSource>> source = capture::open_source(camera.source);
  if (!source) return forward(source);
  (*source)->stop_when(stop);
  Result<capture::StreamInfo> info = (*source)->start();
  if (info) (*source)->stop();
  return info;
}

// "tcp://127.0.0.1:5570".
Finding look_at_endpoint(const std::string& endpoint, const std::string& whose) {
  constexpr std::string_view kScheme = "tcp://";
  const std::size_t colon = endpoint.rfind(':');
  if (!endpoint.starts_with(kScheme) || colon < kScheme.size())
    return {Verdict::Fail, text("port: '", endpoint, "' for ", whose,
                                " is not tcp://<address>:<port>; correct it in [publish]")};
  return look_at_port(endpoint.substr(kScheme.size(), colon - kScheme.size()),
                      std::atoi(endpoint.c_str() + colon + 1), whose);
}

}  // namespace

Result<std::vector<Finding>> look_at_studio(const std::filesystem::path& file,
                                            const std::function<bool()>& stop) {
  const Result<studio::CaptureConfig> config = studio::load_capture_config(file);
  if (!config) return forward(config);
  std::vector<Finding> findings;
  double bytes_per_second = 0;
  std::size_t largest = 0;
  for (const studio::CaptureConfig::Camera& camera : config->cameras) {
    const Result<capture::StreamInfo> info = ask_camera(camera, stop);
    if (!info && info.error().code == ErrorCode::Cancelled) return forward(info);
    if (!info) {
      findings.push_back({Verdict::Fail, text("camera ", camera.serial, ": ", info.error().message)});
      continue;
    }
    const double rate = info->frame_rate > 0 ? info->frame_rate : config->frame_rate;
    const bool agrees = std::abs(rate / config->frame_rate - 1) <= config->recorder.limits.rate_deviation;
    const std::string what =
        text("camera ", camera.serial, ": ", info->layout.width, "x", info->layout.height, " ",
             name_of(info->layout.format), " at ", rate, " a second");
    findings.push_back(
        agrees ? Finding{Verdict::Pass, what}
               : Finding{Verdict::Warn, text(what, " where the config says ", config->frame_rate,
                                             "; correct its exposure, its trigger or the config")});
    bytes_per_second += static_cast<double>(info->layout.size_bytes) * config->frame_rate;
    largest = std::max(largest, info->layout.size_bytes);
  }
  for (const std::string& uri : config->sounds) {
    const Result<std::unique_ptr<capture::SoundSource>> sound = capture::open_sound(uri);
    findings.push_back(
        sound ? Finding{Verdict::Pass, text("sound ", uri, ": ", (*sound)->channels(), " channels of ",
                                            (*sound)->rate(), " samples a second")}
              : Finding{Verdict::Fail, text("sound: ", sound.error().message)});
    if (sound)
      bytes_per_second += static_cast<double>((*sound)->channels()) * (*sound)->rate() * (*sound)->bits() / 8;
  }
  if (!config->rig.empty())
    if (const Result<Rig> rig = load_rig(config->rig); !rig)
      findings.push_back(
          {Verdict::Fail, text("rig: ", rig.error().message, "; calibrate, or correct the config")});
  findings.push_back(look_at_receive_buffers("/", largest));
  if (config->web)
    findings.push_back(look_at_port(config->web->address, config->web->port, "the node's page"));
  if (config->publish) {
    findings.push_back(look_at_endpoint(config->publish->address, "the node's outlines"));
    findings.push_back(look_at_endpoint(config->publish->control, "requests to the node"));
  }
  std::filesystem::path folder = std::filesystem::absolute(config->folder);
  while (!is_there(folder) && folder.has_relative_path()) folder = folder.parent_path();
  // Uncompressed: what FFV1 makes of noise is not less by much.
  findings.push_back(look_at_disk(folder, bytes_per_second, "the config's cameras"));
  return findings;
}

}  // namespace floatstage::apps
