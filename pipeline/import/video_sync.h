#pragma once

#include <optional>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/import/import_sound.h"
#include "pipeline/import/media_files.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

class PictureStream;

/// By what videos that were started by hand are brought together.
enum class SyncSign {
  Clap,   ///< the beginning of sounds, to the sample
  Flash,  ///< jumps of the pictures' brightness
};

/// What was measured of one camera.
struct CameraSync {
  std::string serial;
  double seconds = 0;  ///< how much earlier than the first camera it was started: its clock is that far ahead
  int events = 0;      ///< claps or flashes that tell so; 0 of the first camera
  double spread = 0;   ///< s: by how much they disagree
};

/// Which pictures of each camera's video are shown at the take's instants, and when they were taken.
struct SyncedVideos {
  struct Camera {
    std::vector<int> pictures;     ///< one an instant: the picture's number in the video, -1: there is none
    std::vector<Timestamp> times;  ///< when it was taken, of a gap when it should have been
    VideoTimes sound;
  };
  double frame_rate = 0;
  std::vector<Camera> cameras;
  std::vector<CameraSync> found;
};

/// Finds when each of the videos was started by claps or flashes in them (onset_sync.h), and the instants in
/// which all of them run: `frame_rate` a second (absent: as the slowest one has), each with the picture of
/// every camera that is nearest to it. Decodes every video once. Errors, each naming the camera:
/// InvalidArgument for one without a video; NotFound for one without a sound track, clap or flash; BadData
/// for a video that states no times, an empty sound track, or signs that are ambiguous, contradict each other
/// or leave no instant in which all run; Cancelled.
Result<SyncedVideos> sync_videos(const std::vector<CameraMedia>& media,
                                 const std::vector<std::string>& serials, SyncSign sign,
                                 std::optional<double> frame_rate, int threads, Progress* progress);

/// Writes one camera's pictures at their instants; the number of gaps. Errors of the stream and the writer.
Result<int> copy_synced(PictureStream& stream, const SyncedVideos::Camera& plan, std::size_t camera,
                        const Progress* watch, capture::TakeWriter& writer);

}  // namespace floatstage::pipeline
