#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace floatstage {

/// What stands behind the performer. All are boxes that hold every camera and catch no shadow; they differ in
/// what their sides show.
enum class SyntheticStage {
  Green,          ///< green cloth all around, hung with slight folds
  Black,          ///< black all around
  GreenBlack,     ///< green floor; black walls with a grid of lines, poles and lamps
  BlueCyclorama,  ///< blue without corners, lit three times as bright in places as in others
  LitBlack,       ///< black with a cloth under the performer that catches the light
  Room,           ///< nothing to key on: planks, wallpaper, shelves of books, a window
  Markers,        ///< Green with tracking markers, white and orange crosses
  Cables,         ///< Green with cables on the floor and hanging along the walls
  GreenClothes,   ///< Green, and one sleeve and parts of the shirt have the cloth's colour
};

/// Who is on the stage. Two walk to and fro along x, every two seconds once past one another: side by side
/// for most cameras of a ring, one hidden by the other for some.
enum class SyntheticCast {
  One,    ///< a dancer in the middle
  Two,    ///< two in different clothes, who pass at 0.7 m
  Alike,  ///< two in the same clothes, who pass through one another: nothing says who is who afterwards
};

struct SyntheticStageName {
  SyntheticStage stage;
  std::string_view name, help;
};

/// Every stage with its name on the command line ("green-black") and a line of help.
const std::vector<SyntheticStageName>& synthetic_stages();
/// Nothing when no stage has that name.
std::optional<SyntheticStage> synthetic_stage(std::string_view name);

}  // namespace floatstage
