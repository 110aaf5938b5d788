#pragma once

#include <filesystem>

namespace floatstage {

/// Says which foreign file this thread decodes, for as long as it lives. In a confined child
/// (core/confined.h) its parent names that file when the child dies, and ends a child that stays in one for
/// too long; elsewhere it does nothing. Inside another one of the same thread the outer name counts. Any
/// thread.
class WorkingOn {
 public:
  explicit WorkingOn(const std::filesystem::path& file);
  ~WorkingOn();
  WorkingOn(const WorkingOn&) = delete;
  WorkingOn& operator=(const WorkingOn&) = delete;
};

}  // namespace floatstage
