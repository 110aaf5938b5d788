#pragma once

#include <filesystem>

namespace floatstage {

/// The checkout that the tests were built from. Asked for, not compiled into every test: objects are then the
/// same in any folder, and a compile cache serves them all.
std::filesystem::path source_folder();

/// The real data that lie beside the checkout, or should.
std::filesystem::path data_folder();

}  // namespace floatstage
