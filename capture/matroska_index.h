#pragma once

#include <cstdint>
#include <vector>

#include "core/result.h"

namespace floatstage::capture {

/// Where the pictures of a Matroska file lie: found by walking the element headers and skipping everything
/// else, so it costs one small read a picture and needs no index in the file. That is what makes a take that
/// was cut off open, count and seek like a whole one. (Matroska: RFC 9559; EBML: RFC 8794.)
struct MatroskaIndex {
  struct Picture {
    std::int64_t offset = 0;  ///< of the coded bytes, in the file
    std::int64_t size = 0;    ///< bytes
    bool keyframe = false;
  };
  std::vector<Picture>
      pictures;      ///< of the first track, in coding order; only those that are in the file whole
  bool cut = false;  ///< the file ends in the middle of an element, or in bytes that are none
};

/// Reads from an open file descriptor with pread(): its position does not matter and does not change. Never
/// fails on content (a file that is no Matroska has no pictures and is `cut`); Io when the operating system
/// refuses.
Result<MatroskaIndex> index_matroska(int fd);

}  // namespace floatstage::capture
