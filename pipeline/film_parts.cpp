#include "pipeline/film_parts.h"

#include <algorithm>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "capture/alpha_video.h"
#include "capture/media_file.h"
#include "capture/sha256.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/json_fields.h"
#include "core/log.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/exr_file.h"
#include "pipeline/made_files.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kSharedTries = 100;  // tenths of a second

std::string numbered(int index) {
  char digits[16];
  std::snprintf(digits, sizeof digits, "%06d", index);
  return digits;
}

json read_record(const fs::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return {};
  Result<json> record = parse_json(*bytes, file.string());
  return record && record->is_object() ? std::move(*record) : json();
}

std::string string_in(const json& record, const char* key) {
  const auto found = record.find(key);
  return record.is_object() && found != record.end() && found->is_string() ? found->get<std::string>() : "";
}

// One hash of files, "" where any of them is missing.
Result<std::string> hash_of_all(const std::vector<fs::path>& files) {
  std::string hashes;
  for (const fs::path& file : files) {
    const Result<std::optional<std::string>> hash = hash_of(file);
    if (!hash) return forward(hash);
    if (!*hash) return std::string();
    hashes += **hash;
  }
  return capture::sha256(hashes);
}

Result<void> write_record(const fs::path& record, const std::string& inputs,
                          const std::vector<fs::path>& files) {
  const Result<std::string> hash = hash_of_all(files);
  if (!hash) return forward(hash);
  return write_file(record, json{{"inputs", inputs}, {"sha256", *hash}}.dump() + "\n");
}

class VideoPart final : public PictureSink {
 public:
  VideoPart(std::unique_ptr<capture::VideoWriter> writer, fs::path file, fs::path record, std::string inputs)
      : writer_(std::move(writer)),
        file_(std::move(file)),
        record_(std::move(record)),
        inputs_(std::move(inputs)) {}
  Result<void> write(const Image& picture) override { return writer_->write(picture); }
  Result<void> finish() override {
    if (Result<void> ok = writer_->finish(); !ok) return ok;
    return write_record(record_, inputs_, {file_});
  }

 private:
  const std::unique_ptr<capture::VideoWriter> writer_;
  const fs::path file_, record_;
  const std::string inputs_;
};

class StillsPart final : public PictureSink {
 public:
  StillsPart(Stills stills, std::vector<fs::path> files, fs::path record, std::string inputs)
      : stills_(stills), files_(std::move(files)), record_(std::move(record)), inputs_(std::move(inputs)) {}
  Result<void> write(const Image& picture) override {
    if (next_ == files_.size()) return fail(ErrorCode::InvalidArgument, "more pictures than the part has");
    const fs::path& file = files_[next_++];
    return stills_ == Stills::Exr ? save_exr(picture, file, ExrAlpha::Associated) : save_png(picture, file);
  }
  Result<void> finish() override { return write_record(record_, inputs_, files_); }

 private:
  const Stills stills_;
  const std::vector<fs::path> files_;
  const fs::path record_;
  const std::string inputs_;
  std::size_t next_ = 0;
};

}  // namespace

// The last part takes what is left over: none is short.
std::vector<FilmParts::Part> FilmParts::divide(const FilmShape& shape) {
  const int length = shape.part_pictures, count = shape.in_one ? 1 : std::max(1, shape.pictures / length);
  std::vector<Part> parts;
  for (int i = 0; i < count; ++i) parts.push_back({i * length, length});
  parts.back().count = shape.pictures - parts.back().first;
  return parts;
}

FilmParts::FilmParts(const fs::path& out, const FilmShape& shape, Use use)
    : out_(out), folder_(fs::path(out).concat(".parts")), shape_(shape), use_(use), parts_(divide(shape)) {}

FilmParts::~FilmParts() {
  if (!claim_) return;  // others may be about to write theirs
  for (std::size_t part = 0; part < parts_.size(); ++part)
    if (is_there(file(part, ".json"))) return;
  remove_folder();
}

fs::path FilmParts::file(std::size_t part, const char* extension) const {
  return folder_ / (numbered(parts_[part].first) + extension);
}

fs::path FilmParts::picture(int index) const {
  return folder_ / "pictures" / (numbered(index) + (shape_.stills == Stills::Exr ? ".exr" : ".png"));
}

Result<std::unique_ptr<FilmParts>> FilmParts::open(const fs::path& given, const FilmShape& shape,
                                                   const std::string& made_from, Use use) {
  const fs::path out = film_name(given);
  if (Result<void> ok = check_film_name(out, shape.with_opacity); !ok) return forward(ok);
  if (shape.stills == Stills::Exr && out.has_extension())
    return fail(ErrorCode::InvalidArgument, text(out.string(), ": EXRs are stills; name a folder for them"));
  std::unique_ptr<FilmParts> parts(new FilmParts(out, shape, use));
  if (Result<void> ok = parts->settle(made_from); !ok) return forward(ok);
  return parts;
}

Result<void> FilmParts::settle(const std::string& made_from) {
  if (const fs::path beside = out_.has_parent_path() ? out_.parent_path() : ".";
      is_video() && !is_folder(beside))
    return fail(ErrorCode::Io,
                text("cannot write ", out_.string(), ": there is no folder ", beside.string()));
  if (Result<void> ok = make_folder(folder_); !ok) return ok;
  // One of several has it for a moment only.
  int tries = use_ == Use::Shared ? kSharedTries : 0;
  Result<Claim> claim = wait_for_folder(folder_, [&] { return tries-- > 0; });
  if (!claim && claim.error().code == ErrorCode::Cancelled)
    return fail(ErrorCode::AlreadyExists,
                text(out_.string(), " is being written by another run; wait for it, or choose another name"));
  if (!claim) return forward(claim);
  if (use_ == Use::Alone) claim_ = std::move(*claim);
  // Once more, now that nobody else can write it.
  if (Result<void> ok = check_film_name(out_, shape_.with_opacity); !ok) return ok;
  const std::string there = string_in(read_record(folder_ / "film.json"), "made_from");
  if (there == made_from) return {};
  if (!there.empty() && use_ == Use::Shared)
    return fail(ErrorCode::AlreadyExists,
                text(folder_.string(),
                     " holds parts of another film: other options, or the take has changed; "
                     "remove it, or choose another --out"));
  if (!there.empty())
    log::info(text(folder_.string(),
                   " holds parts of another film (other options, or the take has changed); "
                   "it is begun again"));
  remove_parts();
  if (!is_video())
    if (Result<void> ok = make_folder(folder_ / "pictures"); !ok) return ok;
  return write_file(folder_ / "film.json", json{{"floatstage_film", 1},
                                                {"made_from", made_from},
                                                {"pictures", shape_.pictures},
                                                {"width", shape_.width},
                                                {"height", shape_.height},
                                                {"fps", shape_.frame_rate}}
                                                   .dump(1) +
                                               "\n");
}

// Only what is named as ours: numbers, and halves of them.
void FilmParts::remove_parts() {
  const auto numbers = [](const fs::path& path) {
    const std::string stem = path.stem();
    return !stem.empty() &&
           std::all_of(stem.begin(), stem.end(), [](char c) { return c >= '0' && c <= '9'; });
  };
  std::error_code ignored;
  for (const fs::path& folder : {folder_ / "pictures", folder_}) {
    std::vector<fs::path> ours;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
      if (entry.is_regular_file() && !entry.is_symlink() &&
          (numbers(entry.path()) || is_temporary(entry.path())))
        ours.push_back(entry.path());
    for (const fs::path& one : ours) fs::remove(one, ignored);
  }
  fs::remove(folder_ / "film.json", ignored);
  fs::remove(folder_ / "pictures", ignored);
}

void FilmParts::remove_folder() {
  remove_parts();
  std::error_code ignored;
  fs::remove(folder_, ignored);  // when nobody else put anything there
}

std::vector<fs::path> FilmParts::files(std::size_t part) const {
  if (is_video()) return {file(part, part_extension())};
  std::vector<fs::path> pictures;
  for (int i = 0; i < parts_[part].count; ++i) pictures.push_back(picture(parts_[part].first + i));
  return pictures;
}

bool FilmParts::is_done(std::size_t part, const std::string& inputs) const {
  const json record = read_record(file(part, ".json"));
  if (string_in(record, "inputs") != inputs) return false;
  const Result<std::string> hash = hash_of_all(files(part));
  return hash && !hash->empty() && *hash == string_in(record, "sha256");
}

Result<std::unique_ptr<PictureSink>> FilmParts::begin(std::size_t part, const std::string& inputs) {
  const fs::path record = file(part, ".json");
  if (!is_video())
    return std::unique_ptr<PictureSink>(
        std::make_unique<StillsPart>(shape_.stills, files(part), record, inputs));
  const fs::path video = files(part).front();
  Result<std::unique_ptr<capture::VideoWriter>> writer =
      shape_.with_opacity
          ? capture::create_alpha_video(video, shape_.width, shape_.height, shape_.frame_rate)
          : capture::VideoWriter::create(video, shape_.width, shape_.height, shape_.frame_rate);
  if (!writer) return forward(writer);
  return std::unique_ptr<PictureSink>(std::make_unique<VideoPart>(std::move(*writer), video, record, inputs));
}

Result<void> FilmParts::join(const capture::FilmSound* sound) {
  if (is_video()) {
    std::vector<fs::path> files;
    for (std::size_t part = 0; part < parts_.size(); ++part) files.push_back(file(part, part_extension()));
    if (Result<void> ok = capture::join_videos(files, shape_.frame_rate, shape_.pictures, out_, sound); !ok)
      return ok;
  } else if (Result<void> ok = rename_new(folder_ / "pictures", out_); !ok) {
    return ok;
  }
  remove_folder();
  return {};
}

}  // namespace floatstage::pipeline
