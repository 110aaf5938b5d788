#include "capture/media_input.h"

#include <algorithm>
#include <cerrno>
#include <vector>

#include <sys/stat.h>
#include <unistd.h>

#include "core/file.h"
#include "core/text.h"

namespace floatstage::capture::libav {
namespace {

constexpr int kBufferBytes = 1 << 16;
// Of one byte, more than any coding of stills has but those of fax machines: Deflate has 1032 bytes of eight
// pixels of one bit. And of pictures whose memory is nobody's concern.
constexpr std::int64_t kPixelsOfAByte = 1 << 15, kFewPixels = 1 << 24;

int read_some(void* opaque, std::uint8_t* buffer, int size) {
  const ssize_t n =
      ::read(static_cast<const FileDescriptor*>(opaque)->get(), buffer, static_cast<std::size_t>(size));
  if (n < 0) return AVERROR(errno);
  return n == 0 ? AVERROR_EOF : static_cast<int>(n);
}

std::int64_t seek(void* opaque, std::int64_t offset, int whence) {
  const int fd = static_cast<const FileDescriptor*>(opaque)->get();
  if (whence & AVSEEK_SIZE) {
    struct stat status = {};
    return ::fstat(fd, &status) == 0 ? status.st_size : AVERROR(errno);
  }
  const off_t at = ::lseek(fd, offset, whence & ~AVSEEK_FORCE);
  return at < 0 ? AVERROR(errno) : at;
}

int refuse_other_files(AVFormatContext*, AVIOContext**, const char*, int, AVDictionary**) {
  return AVERROR(EPERM);
}

}  // namespace

Result<std::unique_ptr<Input>> Input::open(const std::filesystem::path& file) {
  be_quiet();
  auto input = std::make_unique<Input>();
  Result<FileDescriptor> open = open_to_read(file);
  if (!open) return forward(open);
  input->file_ = std::move(*open);
  auto* buffer = static_cast<unsigned char*>(av_malloc(kBufferBytes));
  FLOATSTAGE_CHECK(buffer != nullptr, "out of memory");
  input->io_ = avio_alloc_context(buffer, kBufferBytes, 0, &input->file_, &read_some, nullptr, &seek);
  input->format_ = avformat_alloc_context();
  FLOATSTAGE_CHECK(input->io_ != nullptr && input->format_ != nullptr, "out of memory");
  input->format_->pb = input->io_;
  input->format_->io_open = &refuse_other_files;
  // Without a name, the content alone says what the file is.
  int error = avformat_open_input(&input->format_, "", nullptr, nullptr);
  // What libav takes for one picture it reads to the end, whatever comes after the picture.
  if (error >= 0 && input->is_still()) {
    const Result<std::uint64_t> size = size_of(input->file_, file);
    if (!size) return forward(size);
    if (*size > kLargestFile)
      return fail(ErrorCode::BadData, text(file.string(), " has more than ", kLargestFile >> 20,
                                           " MiB; no picture is that large"));
    input->most_pixels_ = std::min(input->most_pixels_,
                                   std::max(kFewPixels, static_cast<std::int64_t>(*size) * kPixelsOfAByte));
  }
  if (error >= 0) error = input->look_into_streams();
  if (error < 0)
    return fail(ErrorCode::BadData,
                text(file.string(), " is no picture or video that can be read: ", reason(error)));
  return input;
}

// libav decodes the first pictures there.
int Input::look_into_streams() {
  std::vector<AVDictionary*> options(format_->nb_streams, nullptr);
  for (AVDictionary*& of_stream : options) av_dict_set_int(&of_stream, "max_pixels", most_pixels_, 0);
  const int error = avformat_find_stream_info(format_, options.data());
  for (AVDictionary*& of_stream : options) av_dict_free(&of_stream);
  return error;
}

bool Input::is_still() const {
  const std::string_view demuxer = format_->iformat->name;
  return demuxer.ends_with("_pipe") || demuxer == "image2";
}

Input::~Input() {
  avformat_close_input(&format_);  // leaves a caller's input routine alone
  if (io_) av_freep(&io_->buffer);
  avio_context_free(&io_);
}

}  // namespace floatstage::capture::libav
