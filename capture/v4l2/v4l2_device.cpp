#include "capture/v4l2/v4l2_device.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>

#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "core/text.h"

namespace floatstage::capture {
namespace {

struct FormatCode {
  PixelFormat format;
  std::uint32_t fourcc;
};

// In the order in which they are taken when none is asked for: colour without a decoder first.
constexpr std::array kFormats = {
    FormatCode{PixelFormat::Rgb8, V4L2_PIX_FMT_RGB24},
    FormatCode{PixelFormat::Yuyv, V4L2_PIX_FMT_YUYV},
    FormatCode{PixelFormat::Nv12, V4L2_PIX_FMT_NV12},
    FormatCode{PixelFormat::BayerRggb8, V4L2_PIX_FMT_SRGGB8},
    FormatCode{PixelFormat::Mjpeg, V4L2_PIX_FMT_MJPEG},
    FormatCode{PixelFormat::Gray8, V4L2_PIX_FMT_GREY},
};

auto refused(ErrorCode code, const V4l2Settings& settings, const std::string& what) {
  return fail(code, text("camera '", settings.path, "': ", what));
}

std::vector<std::uint32_t> offered_formats(const V4l2Device& device) {
  std::vector<std::uint32_t> codes;
  v4l2_fmtdesc description{};
  description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  while (device.ioctl(VIDIOC_ENUM_FMT, &description) == 0) {
    codes.push_back(description.pixelformat);
    ++description.index;
  }
  return codes;
}

Result<std::uint32_t> choose_format(const V4l2Device& device, const V4l2Settings& settings) {
  const std::vector<std::uint32_t> offered = offered_formats(device);
  std::string list;
  for (const FormatCode& known : kFormats) {
    if (std::find(offered.begin(), offered.end(), known.fourcc) == offered.end()) continue;
    if (!settings.format || *settings.format == known.format) return known.fourcc;
    list += text(list.empty() ? "" : ", ", name_of(known.format));
  }
  return refused(
      ErrorCode::Unsupported, settings,
      text("it does not offer ", settings.format ? name_of(*settings.format) : "any format we read",
           "; it offers ", list.empty() ? "none of ours" : list));
}

std::string sizes_of(const V4l2Device& device, std::uint32_t fourcc) {
  std::string list;
  v4l2_frmsizeenum size{};
  size.pixel_format = fourcc;
  for (; device.ioctl(VIDIOC_ENUM_FRAMESIZES, &size) == 0; ++size.index) {
    if (size.type != V4L2_FRMSIZE_TYPE_DISCRETE) {
      return text(size.stepwise.min_width, "x", size.stepwise.min_height, " to ", size.stepwise.max_width,
                  "x", size.stepwise.max_height);
    }
    list += text(list.empty() ? "" : ", ", size.discrete.width, "x", size.discrete.height);
  }
  return list.empty() ? "sizes it does not tell" : list;
}

Result<ImageLayout> set_format(const V4l2Device& device, const V4l2Settings& settings) {
  const Result<std::uint32_t> fourcc = choose_format(device, settings);
  if (!fourcc) return forward(fourcc);
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int error = device.ioctl(VIDIOC_G_FMT, &format); error != 0)
    return refused(ErrorCode::Disconnected, settings,
                   text("it does not tell its format (", std::strerror(error), ")"));
  v4l2_pix_format& pix = format.fmt.pix;
  if (settings.width > 0) {
    pix.width = static_cast<std::uint32_t>(settings.width);
    pix.height = static_cast<std::uint32_t>(settings.height);
  }
  pix.pixelformat = *fourcc;
  pix.field = V4L2_FIELD_NONE;
  pix.bytesperline = 0;
  if (const int error = device.ioctl(VIDIOC_S_FMT, &format); error != 0)
    return refused(ErrorCode::Unsupported, settings,
                   text("it refuses the format (", std::strerror(error),
                        error == EBUSY ? "): another program uses it" : ")"));
  const bool as_asked = pix.pixelformat == *fourcc &&
                        (settings.width == 0 || (static_cast<int>(pix.width) == settings.width &&
                                                 static_cast<int>(pix.height) == settings.height));
  if (!as_asked)
    return refused(ErrorCode::Unsupported, settings,
                   text("it makes ", pix.width, "x", pix.height, " of ", settings.width, "x", settings.height,
                        "; it offers ", sizes_of(device, *fourcc)));
  const auto* known =
      std::find_if(kFormats.begin(), kFormats.end(), [&](auto& f) { return f.fourcc == *fourcc; });
  ImageLayout layout{known->format, static_cast<int>(pix.width), static_cast<int>(pix.height),
                     pix.bytesperline, pix.sizeimage};
  if (layout.format == PixelFormat::Mjpeg) layout.stride = 0;
  return layout;
}

Result<void> set_rate(const V4l2Device& device, const V4l2Settings& settings, V4l2Format& answer) {
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  v4l2_fract& period = parameters.parm.capture.timeperframe;
  const bool known = device.ioctl(VIDIOC_G_PARM, &parameters) == 0;
  if (settings.frame_rate) {
    constexpr double kTicks = 1000;
    period.numerator = static_cast<std::uint32_t>(kTicks);
    period.denominator = static_cast<std::uint32_t>(std::lround(*settings.frame_rate * kTicks));
    if (!known || device.ioctl(VIDIOC_S_PARM, &parameters) != 0)
      return refused(ErrorCode::Unsupported, settings, "its frame rate cannot be set; leave rate out");
  }
  if ((known || settings.frame_rate) && period.numerator > 0)
    answer.frame_rate = static_cast<double>(period.denominator) / period.numerator;
  if (settings.frame_rate && std::abs(answer.frame_rate - *settings.frame_rate) > 0.01 * *settings.frame_rate)
    return refused(ErrorCode::Unsupported, settings,
                   text("it makes ", answer.frame_rate, " pictures a second of ", *settings.frame_rate));
  return {};
}

std::vector<v4l2_queryctrl> controls_of(const V4l2Device& device) {
  std::vector<v4l2_queryctrl> all;
  v4l2_queryctrl query{};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  while (device.ioctl(VIDIOC_QUERYCTRL, &query) == 0) {
    if (!(query.flags & V4L2_CTRL_FLAG_DISABLED) && query.type != V4L2_CTRL_TYPE_CTRL_CLASS)
      all.push_back(query);
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  return all;
}

Result<void> set_control(const V4l2Device& device, const V4l2Settings& settings,
                         const std::vector<v4l2_queryctrl>& all, const std::string& word, int value) {
  std::string words;
  for (const v4l2_queryctrl& control : all) {
    const std::string offered = control_word(reinterpret_cast<const char*>(control.name));
    words += text(words.empty() ? "" : ", ", offered);
    if (offered != word) continue;
    v4l2_control set{control.id, value};
    const bool fits =
        control.type == V4L2_CTRL_TYPE_BUTTON || (value >= control.minimum && value <= control.maximum);
    const int error = fits ? device.ioctl(VIDIOC_S_CTRL, &set) : ERANGE;
    if (error == 0) return {};
    return refused(ErrorCode::InvalidArgument, settings,
                   text("it refuses ", word, " = ", value, " (", std::strerror(error), "); from ",
                        control.minimum, " to ", control.maximum));
  }
  return refused(ErrorCode::Unsupported, settings, text("it has no control '", word, "'; it has ", words));
}

}  // namespace

Result<V4l2Device> V4l2Device::open(const std::string& path) {
  const auto failed = [&](ErrorCode code, const auto&... what) {
    return fail(code, text("camera '", path, "': ", what...));
  };
  V4l2Device device(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  if (device.fd_ < 0) {
    switch (errno) {
      case EACCES:
        return failed(ErrorCode::Io, "no permission; add yourself to the group 'video'");
      case EBUSY:
        return failed(ErrorCode::Io, "another program uses it");
      default:
        return failed(ErrorCode::NotFound, "it is not there (", std::strerror(errno), "); check its cable");
    }
  }
  v4l2_capability capability{};
  if (device.ioctl(VIDIOC_QUERYCAP, &capability) != 0)
    return failed(ErrorCode::Unsupported, "it is no video device");
  const std::uint32_t has =
      capability.capabilities & V4L2_CAP_DEVICE_CAPS ? capability.device_caps : capability.capabilities;
  if (!(has & V4L2_CAP_VIDEO_CAPTURE) || !(has & V4L2_CAP_STREAMING))
    return failed(ErrorCode::Unsupported,
                  "it is no camera that streams single-plane pictures; is it another node of one?");
  return device;
}

V4l2Device::V4l2Device(V4l2Device&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

V4l2Device::~V4l2Device() {
  if (fd_ >= 0) ::close(fd_);
}

int V4l2Device::ioctl(unsigned long request, void* argument) const {
  for (;;) {
    if (::ioctl(fd_, request, argument) == 0) return 0;
    if (errno != EINTR) return errno;
  }
}

Result<V4l2Format> apply_settings(const V4l2Device& device, const V4l2Settings& settings) {
  const Result<ImageLayout> layout = set_format(device, settings);
  if (!layout) return forward(layout);
  V4l2Format answer;
  answer.device = *layout;
  if (Result<void> set = set_rate(device, settings, answer); !set) return forward(set);
  const std::vector<v4l2_queryctrl> controls = controls_of(device);
  for (const auto& [word, value] : settings.controls) {
    if (Result<void> set = set_control(device, settings, controls, word, value); !set) return forward(set);
  }
  answer.exposure = exposure_time(device);
  return answer;
}

std::optional<Nanoseconds> exposure_time(const V4l2Device& device) {
  v4l2_control exposure{V4L2_CID_EXPOSURE_ABSOLUTE, 0};
  if (device.ioctl(VIDIOC_G_CTRL, &exposure) != 0 || exposure.value <= 0) return std::nullopt;
  return Nanoseconds{exposure.value * std::int64_t{100'000}};  // its unit is 100 us
}

std::vector<CameraControl> light_controls(const V4l2Device& device) {
  constexpr std::array<std::uint32_t, 13> kOfLight = {V4L2_CID_EXPOSURE_AUTO,
                                                      V4L2_CID_EXPOSURE_ABSOLUTE,
                                                      V4L2_CID_EXPOSURE,
                                                      V4L2_CID_AUTOGAIN,
                                                      V4L2_CID_GAIN,
                                                      V4L2_CID_AUTO_WHITE_BALANCE,
                                                      V4L2_CID_RED_BALANCE,
                                                      V4L2_CID_BLUE_BALANCE,
                                                      V4L2_CID_WHITE_BALANCE_TEMPERATURE,
                                                      V4L2_CID_BRIGHTNESS,
                                                      V4L2_CID_BACKLIGHT_COMPENSATION,
                                                      V4L2_CID_FOCUS_AUTO,
                                                      V4L2_CID_FOCUS_ABSOLUTE};
  constexpr std::uint32_t kFixed =
      V4L2_CTRL_FLAG_READ_ONLY | V4L2_CTRL_FLAG_INACTIVE | V4L2_CTRL_FLAG_GRABBED;
  std::vector<CameraControl> found;
  for (const v4l2_queryctrl& control : controls_of(device)) {
    const bool wanted = std::find(kOfLight.begin(), kOfLight.end(), control.id) != kOfLight.end();
    v4l2_control now{control.id, 0};
    if (!wanted || (control.flags & kFixed) != 0 || device.ioctl(VIDIOC_G_CTRL, &now) != 0) continue;
    const auto as_number = [](auto value) { return static_cast<double>(value); };
    found.push_back({control_word(reinterpret_cast<const char*>(control.name)), as_number(now.value),
                     as_number(control.minimum), as_number(control.maximum), as_number(control.step)});
  }
  return found;
}

Result<void> set_light_control(const V4l2Device& device, const std::string& path, const std::string& name,
                               double value) {
  const Result<void> fits = check_control(light_controls(device), text("camera '", path, "'"), name, value);
  if (!fits) return fits;
  V4l2Settings settings;
  settings.path = path;
  return set_control(device, settings, controls_of(device), name, static_cast<int>(std::lround(value)));
}

const char* why_not_streaming(int error) {
  switch (error) {
    case ENOSPC:
      return "no space left on device, which is the USB bus: its bandwidth is used up; use a smaller or a "
             "compressed format, fewer pictures a second or another USB controller";
    case EBUSY:
      return "another program streams from it";
    case ENODEV:
      return "it was unplugged";
    case EPIPE:
      return "its pipeline is not set up";
    default:
      return std::strerror(error);
  }
}

std::string control_word(std::string_view name) {
  std::string word;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)))
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (!word.empty() && word.back() != '-')
      word += '-';
  }
  while (!word.empty() && word.back() == '-') word.pop_back();
  return word;
}

}  // namespace floatstage::capture
