#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/take_layout.h"

namespace floatstage::pipeline {

/// A place in a photograph of which somebody says whose it is.
struct LabelClick {
  std::string label, serial;
  int frame = 0;
  double x = 0, y = 0;  ///< px
  bool operator==(const LabelClick&) const = default;
};

/// Label mattes that are not to be trusted, from a frame on.
struct LabelDoubt {
  std::string why;  ///< and what to do
  std::string serial;
  int frame = 0, frames = 1;  ///< the first, and how many in all
  std::string picture = {};   ///< a file's name in the folder of doubts; empty: none
  bool operator==(const LabelDoubt&) const = default;
};

/// mattes/labels.json: who is told apart, what somebody said of it, and which files were made from what.
struct LabelRecord {
  using Hashes = std::map<std::string, std::map<int, std::string>>;  ///< by serial and frame, SHA-256

  std::vector<std::string> labels;  ///< in order; empty: nobody asked for any
  std::vector<std::string> drawn;   ///< those of them that strokes of mattes/edits.json alone name
  std::vector<LabelClick> clicks;
  std::string inputs;  ///< SHA-256 of what is the same for all frames: rig, names, clicks, strokes, masks
  Hashes sums;         ///< of the mattes that were divided
  std::map<std::string, Hashes> files;  ///< by label, of the mattes that were made
  std::vector<LabelDoubt> doubts;

  bool operator==(const LabelRecord&) const = default;
};

/// Empty without a file. BadData names the file.
Result<LabelRecord> load_label_record(const TakeLayout& layout);
/// Whole or not at all.
Result<void> save_label_record(const LabelRecord& record, const TakeLayout& layout);

/// The take with these of its labels in it, or without those; both empty is all of it, as it is. NotFound for
/// a label that the record does not have; InvalidArgument where nobody would be left, or for both at once.
Result<TakeLayout> choose_labels(const TakeLayout& layout, const std::vector<std::string>& only,
                                 const std::vector<std::string>& without);

}  // namespace floatstage::pipeline
