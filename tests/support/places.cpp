#include "tests/support/places.h"

namespace floatstage {

std::filesystem::path source_folder() { return FLOATSTAGE_SOURCE_DIR; }

std::filesystem::path data_folder() { return source_folder() / "../shared/data"; }

}  // namespace floatstage
