#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/frame.h"
#include "core/result.h"

namespace floatstage {

/// Where everything lies in a take (a recording): one place that knows the names.
///
///   take.json  rig.json  <serial>.mkv  <serial>.frames.csv  the recording, never changed again
///   quality.json                                            the recorder's verdict
///   mattes/<serial>/<frame>.png  meshes/<frame>.ply  renders/  derived by `process`, may be deleted
///   mattes/<serial>/<label>/<frame>.png                     of several subjects, each one's
///   mattes/made.json  meshes/hull.json                      how they were made, from what
///   mattes/labels.json  mattes/labels/<label>/<serial>/…     how those were made, and from which masks
///   mattes/edits.json                                       a person's corrections, never removed
///   mattes/given/<serial>/<frame>.png                       a person's mattes that the editor works on
///   truth/…                                                 ground truth of a synthetic take, laid out alike
///   plates/<serial>.png                                     clean plates, when they were shot
///   colors.json                                             `calibrate color`: a rig.json with colours
class TakeLayout {
 public:
  explicit TakeLayout(std::filesystem::path folder) : folder_(std::move(folder)) {}

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path manifest() const { return folder_ / "take.json"; }
  std::filesystem::path rig() const { return folder_ / "rig.json"; }
  std::filesystem::path quality() const { return folder_ / "quality.json"; }
  std::filesystem::path frames_csv(std::string_view serial) const {
    return folder_ / (std::string(serial) + ".frames.csv");
  }
  std::filesystem::path mattes() const { return folder_ / "mattes"; }
  std::filesystem::path matte(std::string_view serial, int frame) const;
  /// That of one label alone.
  std::filesystem::path label_matte(std::string_view serial, std::string_view label, int frame) const;
  std::filesystem::path made_mattes() const { return mattes() / "made.json"; }
  std::filesystem::path mattes_journal() const { return mattes() / "made.log"; }
  std::filesystem::path given_mattes(std::string_view serial) const { return mattes() / "given" / serial; }
  std::filesystem::path edits() const { return mattes() / "edits.json"; }
  /// How labels were made, and the masks that somebody gave: <label>/<serial>/<frame>.png.
  std::filesystem::path label_record() const { return mattes() / "labels.json"; }
  std::filesystem::path label_masks() const { return mattes() / "labels"; }
  /// The same take with nothing but these labels in it, in the order of the record: meshes lie apart, in
  /// meshes/labels/<label>+<label>. Whoever reads mattes adds those of the labels up (load_mattes()).
  TakeLayout with_labels(std::vector<std::string> labels) const;
  /// What makes the matte of a camera: the sum's file, or, with labels, theirs.
  std::vector<std::filesystem::path> matte_files(std::string_view serial, int frame) const;
  const std::vector<std::string>& labels() const { return labels_; }  ///< empty: everything
  std::filesystem::path meshes() const;
  std::filesystem::path mesh(int frame) const;
  /// The frames whose matte or mesh lies there, ascending, by one look into the folder: a recording's length
  /// says nothing about how many there are. No folder is no frames.
  std::vector<int> frames_with_mattes(std::string_view serial) const;
  std::vector<int> frames_with_meshes() const;
  std::filesystem::path hull_report() const { return meshes() / "hull.json"; }
  std::filesystem::path meshes_journal() const { return meshes() / "hull.log"; }
  std::filesystem::path renders() const { return folder_ / "renders"; }
  std::filesystem::path plate(std::string_view serial) const {
    return folder_ / "plates" / (std::string(serial) + ".png");
  }
  std::filesystem::path colors() const { return folder_ / "colors.json"; }
  TakeLayout truth() const { return TakeLayout(folder_ / "truth"); }

 private:
  std::filesystem::path folder_;
  std::vector<std::string> labels_;
};

/// A label's name is that of a folder and a word of the command line: letters, digits, '-' and '_', at most
/// 64.
bool is_usable_label(std::string_view name);

/// take.json. `complete` is false while recording: a take cut off by a crash still opens and says so.
struct TakeManifest {
  struct Camera {
    std::string serial;
    std::string media;  ///< file name inside the take
    std::string codec;  ///< "ffv1", "raw", "h264"
    PixelFormat format = PixelFormat::Rgb8;
    int width = 0, height = 0;
    bool operator==(const Camera&) const = default;
  };
  /// A recorded file as it was when the recording was over.
  struct File {
    std::string name;  ///< inside the take
    std::uint64_t bytes = 0;
    std::string sha256;  ///< lower-case hex
    bool operator==(const File&) const = default;
  };
  int version = 1;
  std::string label;
  std::string created;     ///< UTC, ISO 8601
  std::string writer;      ///< program and version
  double frame_rate = 0;   ///< nominal frames per second; 0 when there is only one instant
  std::string rig_sha256;  ///< of rig.json's bytes, lower-case hex
  bool complete = false;
  std::vector<Camera> cameras;  ///< in rig order
  std::vector<File> files;      ///< every media and side file, once the take is sealed
  bool operator==(const TakeManifest&) const = default;
};

Result<TakeManifest> parse_manifest(std::string_view json, std::string_view name_for_errors);
std::string to_json(const TakeManifest& manifest);

/// One row of <serial>.frames.csv: one per frame *expected*. A gap is a row with status Lost and no media
/// index.
struct FrameRow {
  FrameInfo info;                           ///< info.camera is not stored; the file is one camera's
  std::optional<std::int64_t> media_index;  ///< which picture of the media file; absent for a gap
  bool operator==(const FrameRow&) const = default;
};

/// "sequence,device_time_ns,studio_time_ns,exposure_ns,status,media_index\n" and rows; absent values are
/// empty fields.
std::string frames_csv_header();
std::string to_csv(const FrameRow& row);

/// Reads a side file. A last line without its newline (a take cut off mid-write) is ignored; any other
/// malformed line is BadData with its number.
Result<std::vector<FrameRow>> parse_frames_csv(std::string_view csv, int camera,
                                               std::string_view name_for_errors);

}  // namespace floatstage
