#include "pipeline/matte/label_take.h"

#include <algorithm>
#include <chrono>
#include <set>

#include "capture/sha256.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/matte_edits.h"
#include "core/png.h"
#include "core/text.h"
#include "matting/doubt_picture.h"
#include "matting/labels/label_split.h"
#include "pipeline/derived_files.h"
#include "pipeline/made_files.h"
#include "pipeline/matte/doubt_pictures.h"
#include "pipeline/matte/label_follower.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostLabels = 31;  // bits of LabelsAllowed, and one to spare
constexpr int kDoubtWidth = 960;         // px

void add(std::vector<std::string>& names, const std::string& label) {
  if (std::find(names.begin(), names.end(), label) == names.end()) names.push_back(label);
}

// The labels that were named, in the order in which they were.
std::vector<std::string> names_in(const LabelsSaid& said) {
  std::vector<std::string> names;
  for (const LabelMasks& m : said.masks) add(names, m.label);
  for (const LabelClick& c : said.clicks) add(names, c.label);
  return names;
}

// Likewise of strokes, in the order of the alphabet: which was drawn first nobody knows.
std::vector<std::string> names_in(const MatteEdits& edits) {
  std::vector<std::string> names;
  for (const auto& [serial, camera] : edits.cameras)
    for (const MatteKeyframe& keyframe : camera.keyframes)
      for (const MatteStroke& stroke : keyframe.strokes)
        if (!stroke.subject.empty()) add(names, stroke.subject);
  std::sort(names.begin(), names.end());
  return names;
}

Result<void> check(const std::vector<std::string>& names) {
  for (const std::string& label : names)
    if (!is_usable_label(label))
      return fail(
          ErrorCode::InvalidArgument,
          text("'", label,
               "' cannot be a label: letters, digits, '-' and '_', at most 64, since it names a folder"));
  if (names.size() == 1)
    return fail(ErrorCode::InvalidArgument, text("'", names[0],
                                                 "' is the only label that was given; a take's mattes "
                                                 "are divided among 2 to ",
                                                 kMostLabels, "; give one to everybody on stage"));
  if (names.size() > kMostLabels)
    return fail(ErrorCode::InvalidArgument, text("a take's mattes are divided among 2 to ", kMostLabels,
                                                 " labels, and ", names.size(), " were given"));
  return {};
}

// The folder in which work is done, beside what it is for; gone when it is.
class Scratch {
 public:
  explicit Scratch(const TakeLayout& layout) : folder_(layout.mattes() / ".labels.tmp") { clear(); }
  ~Scratch() { clear(); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const fs::path& folder() const { return folder_; }

 private:
  void clear() const {
    std::error_code error;
    fs::remove_all(folder_, error);
  }
  const fs::path folder_;
};

// A folder by another, or by none where that is not there.
Result<void> replace(const fs::path& folder, const fs::path& by) {
  std::error_code error;
  fs::remove_all(folder, error);
  if (!error && is_there(by)) fs::rename(by, folder, error);
  if (!error) return {};
  return fail(ErrorCode::Io, text("cannot write ", folder.string(), ": ", error.message()));
}

// The masks that are said now, copied to `folder`.
Result<void> copy_masks(const capture::TakeReader& take, const LabelsSaid& said, const fs::path& folder) {
  for (const LabelMasks& masks : said.masks) {
    const auto each = [&](int camera, int frame, const Image& mask) -> Result<void> {
      const std::string& serial = take.rig().cameras[static_cast<std::size_t>(camera)].serial;
      const fs::path file = folder / masks.label / serial / take.layout().matte(serial, frame).filename();
      if (Result<void> ok = make_folder(file.parent_path()); !ok) return ok;
      return save_png(mask, file);
    };
    if (Result<void> ok = read_label_masks(take, masks, each); !ok) return ok;
  }
  return {};
}

// Who is told apart: those of masks and clicks, said now or before, and those of strokes.
Result<void> name_labels(const std::optional<LabelsSaid>& said, const MatteEdits& edits,
                         LabelRecord& record) {
  std::vector<std::string> names;
  if (said) {
    names = names_in(*said);
    record.clicks = said->clicks;
  } else {
    for (const std::string& label : record.labels)
      if (std::find(record.drawn.begin(), record.drawn.end(), label) == record.drawn.end()) add(names, label);
  }
  const std::size_t before = names.size();
  for (const std::string& label : names_in(edits)) add(names, label);
  record.drawn.assign(names.begin() + static_cast<std::ptrdiff_t>(before), names.end());
  record.labels = std::move(names);
  return check(record.labels);
}

// mattes/labels is ours to replace only if a record says that it is.
Result<void> check_room(const capture::TakeReader& take, const LabelRecord& before) {
  const fs::path masks = take.layout().label_masks();
  if (camera_index(take.rig(), masks.filename().string()) >= 0)
    return fail(
        ErrorCode::InvalidArgument,
        text("a camera of ", take.layout().folder().string(), " is called '", masks.filename().string(),
             "', and its mattes lie where masks of labels do; such a take's mattes cannot be divided"));
  if (!before.labels.empty() || !is_there(masks)) return {};
  return fail(ErrorCode::AlreadyExists,
              text(masks.string(), " is there, and nothing says that it was made here; move it away"));
}

Result<LabelRecord::Hashes> sums_of(const capture::TakeReader& take) {
  LabelRecord::Hashes sums;
  for (const RigCamera& c : take.rig().cameras)
    for (const int frame : take.layout().frames_with_mattes(c.serial)) {
      if (frame >= take.frame_count()) break;
      const Result<std::optional<std::string>> hash = hash_of(take.layout().matte(c.serial, frame));
      if (!hash) return forward(hash);
      if (*hash) sums[c.serial][frame] = **hash;
    }
  if (!sums.empty()) return sums;
  return fail(ErrorCode::NotFound,
              text(take.layout().folder().string(),
                   " has no mattes to divide among labels; run `floatstage matte` first"));
}

std::string hash_of_inputs(const capture::TakeReader& take, const LabelRecord& record,
                           const MatteEdits& edits, std::vector<std::string> masks) {
  std::string all = take.manifest().rig_sha256;
  for (const std::string& label : record.labels) all += "\n" + label;
  for (const LabelClick& c : record.clicks)
    all += text("\n", c.label, " ", c.serial, " ", c.frame, " ", c.x, " ", c.y);
  for (const LabelWord& word : label_words(take.rig(), {}, edits)) {
    all += text("\nstroke ", word.stroke.subject, " ", word.serial, " ", word.frame, " ", word.stroke.radius);
    for (const Eigen::Vector2d& p : word.stroke.points) all += text(" ", p.x(), ",", p.y());
  }
  std::sort(masks.begin(), masks.end());
  for (const std::string& m : masks) all += "\n" + m;
  return capture::sha256(all);
}

// What we made of labels before goes.
Result<void> remove_made(const TakeLayout& layout, const LabelRecord& before) {
  for (const auto& [label, cameras] : before.files)
    for (const auto& [serial, frames] : cameras)
      for (const auto& [frame, hash] : frames) {
        const Result<bool> theirs = is_others_label_matte(layout, before, label, serial, frame);
        if (!theirs) return forward(theirs);
        std::error_code error;
        if (!*theirs) fs::remove(layout.label_matte(serial, label, frame), error);
      }
  return {};
}

// Nobody names labels any more.
Result<void> forget_labels(const TakeLayout& layout, const LabelRecord& before) {
  if (Result<void> ok = remove_made(layout, before); !ok) return ok;
  const auto none = [](const std::string&, const DoubtPicture&) { return false; };
  if (Result<void> ok = DoubtPictures(doubts_folder(layout)).keep("labels", none); !ok) return ok;
  std::error_code error;
  fs::remove(layout.label_record(), error);
  if (!error) return {};
  return fail(ErrorCode::Io, text("cannot remove ", layout.label_record().string(), ": ", error.message()));
}

class LabelJob {
 public:
  LabelJob(capture::TakeReader& take, const LabelTakeOptions& options, LabelRecord before, fs::path scratch)
      : take_(take),
        options_(options),
        layout_(take.layout()),
        before_(std::move(before)),
        scratch_(std::move(scratch)) {}

  Result<LabelTakeReport> run(LabelRecord record, const LabelGivens& givens) {
    record_ = std::move(record);
    report_.labels = record_.labels;
    for (const auto& [frame, cameras] : givens) report_.given += static_cast<int>(cameras.size());
    const Result<bool> there = all_there();
    if (!there) return forward(there);
    if (*there && !options_.redo) {
      report_.kept = count(record_.files) + report_.others;
    } else {
      if (Result<void> ok = make(givens); !ok) return forward(ok);
    }
    if (Result<void> ok = speak(); !ok) return forward(ok);
    return std::move(report_);
  }

 private:
  static int count(const std::map<std::string, LabelRecord::Hashes>& files) {
    int n = 0;
    for (const auto& [label, cameras] : files)
      for (const auto& [serial, frames] : cameras) n += static_cast<int>(frames.size());
    return n;
  }

  Result<bool> others(const std::string& label, const std::string& serial, int frame) const {
    return is_others_label_matte(layout_, before_, label, serial, frame);
  }

  // Whether every label matte is there, and was made from what is there now.
  Result<bool> all_there() {
    bool all =
        before_.inputs == record_.inputs && before_.sums == record_.sums && before_.labels == record_.labels;
    for (const auto& [serial, frames] : record_.sums)
      for (const auto& [frame, hash] : frames)
        for (const std::string& label : record_.labels) {
          const Result<bool> theirs = others(label, serial, frame);
          if (!theirs) return theirs;
          report_.others += *theirs;
          all = all && (*theirs || is_there(layout_.label_matte(serial, label, frame)));
        }
    if (all) record_.files = before_.files, record_.doubts = before_.doubts;
    return all;
  }

  Result<void> make(const LabelGivens& givens) {
    LabelFollower follower(take_, record_, givens, options_.threads);
    record_.files.clear();
    {
      ProgressPart part(options_.progress, "labels", static_cast<std::size_t>(take_.frame_count()));
      const auto done = [&](const LabelInstant& instant) -> Result<void> {
        if (is_cancelled(options_.progress)) return cancelled();
        part.advance();
        return write(instant);
      };
      if (Result<void> ok = follower.run(done); !ok) return ok;
    }
    record_.doubts = follower.doubts();
    DoubtPictures pictures(doubts_folder(layout_));
    std::set<std::string> drawn;
    for (std::size_t i = 0; i < record_.doubts.size(); ++i) {
      LabelDoubt& doubt = record_.doubts[i];
      doubt.picture = text("label-", doubt.serial, "-", doubt.frame, "-", i, ".png");
      const Result<Image> tiles = shown(doubt);
      if (!tiles) return forward(tiles);
      const DoubtPicture what{
          .of = "labels", .why = doubt.why, .cameras = {doubt.serial}, .frame = doubt.frame};
      if (Result<void> ok = pictures.put(doubt.picture, what, *tiles); !ok) return ok;
      drawn.insert(doubt.picture);
    }
    const auto holds = [&](const std::string& name, const DoubtPicture&) { return drawn.contains(name); };
    if (Result<void> ok = pictures.keep("labels", holds); !ok) return ok;
    return place();
  }

  // Into the scratch folder.
  Result<void> write(const LabelInstant& instant) {
    for (std::size_t c = 0; c < instant.mattes.size(); ++c) {
      if (instant.mattes[c].empty()) continue;
      const std::string& serial = take_.rig().cameras[c].serial;
      const std::vector<Image> mattes =
          matting::share_matte(instant.mattes[c], instant.labels[c], static_cast<int>(record_.labels.size()));
      for (std::size_t l = 0; l < mattes.size(); ++l) {
        const std::string& label = record_.labels[l];
        const Result<bool> theirs = others(label, serial, instant.frame);
        if (!theirs) return forward(theirs);
        if (*theirs) continue;
        const fs::path file = scratched(label, serial, instant.frame);
        if (Result<void> ok = make_folder(file.parent_path()); !ok) return ok;
        const Result<std::string> bytes = encode_png_of_runs(mattes[l]);
        if (!bytes) return forward(bytes);
        if (Result<void> ok = write_file(file, *bytes); !ok) return ok;
        record_.files[label][serial][instant.frame] = capture::sha256(*bytes);
        ++report_.made;
      }
    }
    return {};
  }

  fs::path scratched(const std::string& label, const std::string& serial, int frame) const {
    return scratch_ / "mattes" / serial / label / layout_.matte(serial, frame).filename();
  }

  // A label in doubt, drawn into its photograph.
  Result<Image> shown(const LabelDoubt& doubt) const {
    const int camera = camera_index(take_.rig(), doubt.serial);
    Result<Frame> frame = take_.frame(camera, doubt.frame);
    if (!frame) return forward(frame);
    if (frame->empty()) return Image();
    Result<Image> rgb = to_rgb(*frame);
    if (!rgb) return forward(rgb);
    std::vector<Image> tiles;
    for (const std::string& label : record_.labels) {
      const fs::path file = scratched(label, doubt.serial, doubt.frame);
      const Result<Image> matte =
          load_png(is_there(file) ? file : layout_.label_matte(doubt.serial, label, doubt.frame));
      if (!matte) continue;
      tiles.push_back(matting::doubt_tile(*rgb, make_matte({}, *matte), std::nullopt, kDoubtWidth));
    }
    return tiles.empty() ? Image() : matting::contact_sheet(tiles);
  }

  // What we made before goes, and what was made now takes its place. They are ours before they are there.
  Result<void> place() {
    if (Result<void> ok = remove_made(layout_, before_); !ok) return ok;
    if (options_.said)
      if (Result<void> ok = replace(layout_.label_masks(), scratch_ / "labels"); !ok) return ok;
    if (Result<void> ok = save_label_record(record_, layout_); !ok) return ok;
    for (const auto& [label, cameras] : record_.files)
      for (const auto& [serial, frames] : cameras)
        for (const auto& [frame, hash] : frames)
          if (Result<void> ok =
                  move_file(scratched(label, serial, frame), layout_.label_matte(serial, label, frame));
              !ok)
            return ok;
    return {};
  }

  Result<void> speak() {
    for (const LabelDoubt& d : record_.doubts) {
      MatteDoubt doubt{
          .why = d.why, .cameras = {d.serial}, .frames = d.frames, .worst = d.frame, .picture = {}};
      if (const fs::path file = doubts_folder(layout_) / d.picture; !d.picture.empty() && is_there(file))
        doubt.picture = file;
      report_.doubts.push_back(std::move(doubt));
    }
    return {};
  }

  capture::TakeReader& take_;
  const LabelTakeOptions& options_;
  const TakeLayout layout_;
  const LabelRecord before_;
  const fs::path scratch_;
  LabelRecord record_;
  LabelTakeReport report_;
};

}  // namespace

Result<LabelTakeReport> label_take(capture::TakeReader& take, const LabelTakeOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  Result<LabelRecord> before = load_label_record(take.layout());
  if (!before) return forward(before);
  Result<MatteEdits> edits = load_matte_edits(take.layout().edits());
  if (!edits) return forward(edits);
  LabelRecord record = *before;
  if (Result<void> ok = name_labels(options.said, *edits, record); !ok) return forward(ok);
  if (record.labels.empty()) {
    if (!before->labels.empty())
      if (Result<void> ok = forget_labels(take.layout(), *before); !ok) return forward(ok);
    return LabelTakeReport();
  }
  if (Result<void> ok = check_room(take, *before); !ok) return forward(ok);
  Result<LabelRecord::Hashes> sums = sums_of(take);
  if (!sums) return forward(sums);
  const Scratch scratch(take.layout());
  const fs::path masks = options.said ? scratch.folder() / "labels" : take.layout().label_masks();
  if (options.said)
    if (Result<void> ok = copy_masks(take, *options.said, masks); !ok) return forward(ok);
  record.sums = std::move(*sums);
  std::vector<std::string> hashes;
  const Result<LabelGivens> givens =
      label_givens(take, record, label_words(take.rig(), record, *edits), masks, hashes);
  if (!givens) return forward(givens);
  record.inputs = hash_of_inputs(take, record, *edits, std::move(hashes));
  Result<LabelTakeReport> report =
      LabelJob(take, options, std::move(*before), scratch.folder()).run(std::move(record), *givens);
  if (report)
    report->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

Result<LabelTakeReport> label_take(const fs::path& take, const LabelTakeOptions& options) {
  Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(take);
  if (!opened) return forward(opened);
  const Result<Claim> claim = claim_take(take, options.progress);
  if (!claim) return forward(claim);
  return label_take(**opened, options);
}

}  // namespace floatstage::pipeline
