#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "core/rig.h"

namespace floatstage::calib {

/// A calibration that was read: the rig in our conventions, and what its format says about pictures.
struct ForeignRig {
  Rig rig;                               ///< width and height may be 0 where the format does not state them
  std::vector<std::string> image_names;  ///< per camera, where the format names one; else the serial
  std::filesystem::path pictures;        ///< the folder where such a calibration's pictures lie, if anywhere
  bool one_picture_each = false;  ///< the named picture is the camera's only one, whatever lies beside it
};

/// What a format can hold of a camera's lens. (A rig that was written for one that holds less is fitted
/// again, see formats/refit.h.)
struct LensLimits {
  int radial = 3;          ///< terms of a Brown-Conrady lens: k1, k1 k2, …; 6 with the denominator k4 k5 k6
  bool tangential = true;  ///< p1 and p2
  bool skew = true;
  bool fisheye = true;  ///< Kannala-Brandt
};

/// One calibration format: a row of the table that import, known rigs, export, session files and the help of
/// all of them read. docs/calibration-formats.md says what each file is taken to mean.
struct RigFormat {
  std::string_view name;   ///< as commands and session files say it: "middlebury"
  std::string_view title;  ///< "Middlebury multi-view stereo"
  std::string_view files;  ///< what is read: "a folder with one *_par.txt and the images, or that file"
  std::string_view
      written;  ///< what export makes: "a _par.txt"; empty: this format is not written, `write` is null
  bool states_unit = true;  ///< false: `metres_per_unit` is needed to read it
  LensLimits holds = {};    ///< what `write` can write

  /// Whether what lies at the path (the calibration's file, or a folder that holds it) has this format's
  /// names. Opens no file.
  bool (*recognises)(const std::filesystem::path& path);
  /// Finds the file or files at or below the path and reads them. NotFound says what should lie there,
  /// InvalidArgument which of several to name.
  Result<ForeignRig> (*read)(const std::filesystem::path& path, double metres_per_unit);
  /// One image name a camera, which formats without pictures' names ignore. Refuses what the format cannot
  /// hold; a folder may then be written in part.
  Result<void> (*write)(const Rig& rig, const std::vector<std::string>& image_names,
                        const std::filesystem::path& out);
};

/// All of them, our own rig.json first.
std::span<const RigFormat> rig_formats();

/// The green dome's, about a decimetre: for formats that state no unit.
inline constexpr double kMetresPerUnit = 0.1;

/// The name that stands for "whichever format recognises what is there".
inline constexpr std::string_view kAnyRigFormat = "auto";

/// The row of that name; for "auto" the one that recognises `path`. InvalidArgument lists the names, or those
/// that might be meant; NotFound when nothing is there or nothing recognises it. Never null.
Result<const RigFormat*> rig_format(std::string_view name, const std::filesystem::path& path);

/// "auto, rig, middlebury, …"
std::string rig_format_names();

/// A calibration where it lies: what import and known rigs are given.
struct RigFile {
  std::string format = std::string(kAnyRigFormat);
  std::filesystem::path path;  ///< the calibration's file, or the folder that holds it
  double metres_per_unit = kMetresPerUnit;
};

/// Errors of rig_format() and of the format's reader.
Result<ForeignRig> read_rig(const RigFile& file);

}  // namespace floatstage::calib
