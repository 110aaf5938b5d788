#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "capture/take.h"
#include "core/result.h"

namespace floatstage::apps {

// The flags that several verbs have, each defined once: its name, its short form, its check and its sentence
// are the same wherever it stands (docs/command-line.md). Every function returns the option, so that a verb
// may say ->required().

/// The groups of a help page, in the order in which they are shown. What nearly everybody needs is in
/// kGroupCommon, where options are when nothing is said; what only who compares methods needs is in
/// kGroupTuning, which is last.
inline constexpr const char *kGroupCommon = "Options", *kGroupHull = "Hull", *kGroupCleanup = "Mesh clean-up",
                            *kGroupPicture = "Picture", *kGroupWindow = "Window", *kGroupMattes = "Mattes",
                            *kGroupDefects = "Defects of the studio", *kGroupPlan = "Plan",
                            *kGroupRun = "Run", *kGroupTuning = "Tuning";
std::vector<std::string> option_groups();

/// Width and height of an output, pixels.
struct Size {
  int width = 640, height = 480;
};

/// The take's folder, the verb's positional argument.
CLI::Option* add_take(CLI::App& verb, std::filesystem::path& take,
                      const std::string& help = "The take's folder");
/// -o,--out: the product itself, a file or a folder.
CLI::Option* add_out(CLI::App& verb, std::filesystem::path& out, const std::string& help);
/// --json: the report for machines.
CLI::Option* add_json(CLI::App& verb, std::filesystem::path& file);
/// -j,--threads.
CLI::Option* add_threads(CLI::App& verb, int& threads);
/// --cameras a,b,c: serials; left out: all.
CLI::Option* add_cameras(CLI::App& verb, std::vector<std::string>& serials,
                         const std::string& help = "Only these cameras: serials");
/// --camera-count: how many there are to be.
CLI::Option* add_camera_count(CLI::App& verb, int& count, int fewest);
/// --frames A:B[:step] of a take; the text is for parse_frames(). `otherwise` says what no --frames means.
CLI::Option* add_frames(CLI::App& verb, std::string& frames, const std::string& otherwise);
/// --frame-count: how many there are to be.
CLI::Option* add_frame_count(CLI::App& verb, int& count, const std::string& help);
/// --size WxH of the output; shows what is in `size` as the default.
CLI::Option* add_size(CLI::App& verb, Size& size, const std::string& help,
                      const std::string& name = "--size");
/// --fps: instants or pictures a second.
CLI::Option* add_fps(CLI::App& verb, double& fps, const std::string& help);
/// --seconds: for how long.
CLI::Option* add_seconds(CLI::App& verb, double& seconds, const std::string& help);
/// --blend K: photographs in a view.
CLI::Option* add_blend(CLI::App& verb, int& photographs);
/// --background rrggbb; the text is for renderer_options().
CLI::Option* add_background(CLI::App& verb, std::string& color);
/// --codec of a take's media.
CLI::Option* add_codec(CLI::App& verb, capture::TakeCodec& codec);
/// --redo: what the program made is made again; files of unknown origin stay.
CLI::Option* add_redo(CLI::App& verb, bool& redo);
/// --added hide|keep: what cameras and converters added to pictures; absent: as before, else hidden.
CLI::Option* add_added(CLI::App& verb, std::optional<bool>& hide);
/// --matte HOW: one way to mattes, `usual` where none is said. With a line for each.
CLI::Option* add_matte_how(CLI::App& verb, std::string& how, const std::string& usual);
/// --matte HOW of what keys picture by picture: keyers alone.
CLI::Option* add_matte_keyer(CLI::App& verb, std::string& keyer);
/// --guide: others' mattes to start from.
CLI::Option* add_guide(CLI::App& verb, std::filesystem::path& folder);

/// What --matte is where nobody says it.
inline constexpr const char* kUsualMattes = "as before; given where mattes were put into the take; else auto";

/// The frames that --frames names of a take. Errors: those of TakeReader::open() and parse_frames().
Result<std::vector<int>> frames_of_take(const std::filesystem::path& take, const std::string& frames);

/// A list in one word: a,b,c; anything before the name's first comma. Elements are checked when `known` is
/// not empty.
CLI::Option* add_list(CLI::App& verb, const std::string& name, std::vector<std::string>& list,
                      const std::string& help, const std::vector<std::string>& known = {});

/// Checks that a value is one of these words, and says which one was probably meant.
CLI::Validator one_of(const std::vector<std::string>& words);

/// The place of `word`, which one_of() has checked, in `words`.
std::size_t place_of(const std::vector<std::string>& words, const std::string& word);

/// Methods of rendering, for one_of().
std::vector<std::string> renderer_names();

}  // namespace floatstage::apps
