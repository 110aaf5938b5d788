#include "pipeline/import/picture_stream.h"

#include <algorithm>
#include <charconv>
#include <vector>

#include "core/text.h"

namespace floatstage::pipeline {
namespace {

std::optional<int> whole_number(std::string_view s) {
  int value = 0;
  const auto [end, error] = std::from_chars(s.data(), s.data() + s.size(), value);
  if (s.empty() || error != std::errc() || end != s.data() + s.size() || value < 0) return std::nullopt;
  return value;
}

std::filesystem::path place_of(const CameraMedia& media) {
  return media.video.empty() ? media.stills.at(0).parent_path() : media.video;
}

}  // namespace

Result<FrameRange> parse_frame_range(std::string_view s) {
  const auto bad =
      fail(ErrorCode::InvalidArgument,
           text("'", s, "' names no frames; write 5, 10:20, 10:, :20 or 10:20:2 (the end is not included)"));
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0; begin <= s.size();) {
    const std::size_t end = std::min(s.find(':', begin), s.size());
    parts.push_back(s.substr(begin, end - begin));
    begin = end + 1;
  }
  std::vector<std::optional<int>> numbers(3);
  bool any = false;
  if (parts.size() > numbers.size()) return bad;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].empty()) continue;
    numbers[i] = whole_number(parts[i]);
    if (!numbers[i]) return bad;
    any = true;
  }
  FrameRange range{numbers[0].value_or(0), numbers[1], numbers[2].value_or(1)};
  if (parts.size() == 1) range.end = range.first + 1;
  if (!any || range.step < 1 || (range.end && *range.end <= range.first)) return bad;
  return range;
}

Result<PictureStream> PictureStream::open(const CameraMedia& media, const FrameRange& range) {
  PictureStream stream;
  stream.media_ = media;
  stream.end_ = range.end;
  stream.step_ = range.step;
  if (!media.video.empty()) {
    Result<std::unique_ptr<capture::MediaReader>> video = capture::MediaReader::open(media.video);
    if (!video) return forward(video);
    stream.video_ = std::move(*video);
    stream.frame_rate_ = stream.video_->frame_rate() / range.step;
  }
  // A camera of a single picture has it at every range's beginning: a range is about films.
  const bool one_still = media.video.empty() && media.stills.size() == 1;
  stream.next_still_ = one_still ? 0 : static_cast<std::size_t>(range.first);
  stream.position_ = media.video.empty() && !one_still ? range.first : 0;
  if (one_still) stream.end_.reset();
  while (!media.video.empty() && stream.position_ < range.first) {
    const Result<std::optional<Image>> skipped = stream.decode();
    if (!skipped) return forward(skipped);
    if (!*skipped) break;
  }
  Result<std::optional<Image>> first = stream.decode();
  if (!first) return forward(first);
  if (!*first)
    return fail(ErrorCode::NotFound,
                text(place_of(media).string(), ": holds no picture from number ", range.first, " on"));
  stream.width_ = (*first)->width;
  stream.height_ = (*first)->height;
  stream.first_ = std::move(**first);
  if (stream.video_) stream.first_time_ = stream.last_time_ = stream.video_->time();
  return stream;
}

Result<std::optional<Image>> PictureStream::next() {
  if (first_) return std::exchange(first_, std::nullopt);
  if (Result<void> ok = skip(step_ - 1); !ok) return forward(ok);
  Result<std::optional<Image>> picture = decode();
  if (picture && *picture && video_) last_time_ = video_->time();
  if (picture && *picture && ((*picture)->width != width_ || (*picture)->height != height_))
    return fail(ErrorCode::BadData,
                text(place_of(media_).string(), ": picture ", position_ - 1, " is ", (*picture)->width, "x",
                     (*picture)->height, ", but the first one is ", width_, "x", height_));
  return picture;
}

// Files of their own are passed over; a video has to be decoded on the way.
Result<void> PictureStream::skip(int pictures) {
  for (int i = 0; i < pictures; ++i) {
    if (!video_) {
      ++next_still_, ++position_;
      continue;
    }
    const Result<std::optional<Image>> skipped = decode();
    if (!skipped) return forward(skipped);
    if (!*skipped) break;
  }
  return {};
}

Result<std::optional<Image>> PictureStream::decode() {
  if (end_ && position_ >= *end_) return std::optional<Image>();
  ++position_;
  if (video_) {
    Result<Image> picture = video_->next();
    if (!picture && picture.error().code == ErrorCode::EndOfStream) return std::optional<Image>();
    if (!picture) return forward(picture);
    return std::optional<Image>(std::move(*picture));
  }
  if (next_still_ >= media_.stills.size()) return std::optional<Image>();
  Result<std::unique_ptr<capture::MediaReader>> reader =
      capture::MediaReader::open(media_.stills[next_still_++]);
  if (!reader) return forward(reader);
  Result<Image> picture = (*reader)->next();
  if (!picture) return forward(picture);
  return std::optional<Image>(std::move(*picture));
}

Result<Image> load_still(const std::filesystem::path& file) {
  Result<PictureStream> stream = PictureStream::open({{}, {file}}, {});
  if (!stream) return forward(stream);
  Result<std::optional<Image>> picture = stream->next();
  if (!picture) return forward(picture);
  return **std::move(picture);
}

}  // namespace floatstage::pipeline
