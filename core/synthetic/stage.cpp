#include "core/synthetic/stage.h"

namespace floatstage {

const std::vector<SyntheticStageName>& synthetic_stages() {
  using enum SyntheticStage;
  static const std::vector<SyntheticStageName> all = {
      {Green, "green", "green cloth all around"},
      {Black, "black", "black all around"},
      {GreenBlack, "green-black", "green floor, black walls with lines, poles and lamps"},
      {BlueCyclorama, "blue", "blue cyclorama, unevenly lit"},
      {LitBlack, "lit-black", "black, with cloth that catches the light"},
      {Room, "room", "a furnished room: nothing to key on"},
      {Markers, "markers", "green cloth with tracking markers"},
      {Cables, "cables", "green cloth with cables"},
      {GreenClothes, "green-clothes", "green cloth, and green in the performer's clothes"},
  };
  return all;
}

std::optional<SyntheticStage> synthetic_stage(std::string_view name) {
  for (const SyntheticStageName& known : synthetic_stages())
    if (known.name == name) return known.stage;
  return std::nullopt;
}

}  // namespace floatstage
