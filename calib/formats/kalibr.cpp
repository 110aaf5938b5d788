#include <algorithm>
#include <map>

#include "calib/formats/camera_parts.h"
#include "calib/formats/format_files.h"
#include "calib/formats/parsers.h"
#include "calib/formats/text_lines.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr auto kOrigin = PixelOrigin::FirstPixelCenter;

// One key of one camera: its words with brackets, commas and list dashes taken out, and where it began.
struct Entry {
  int line = 0;
  std::vector<std::string> words;
  int open_brackets = 0;
};

struct CamchainCamera {
  std::string key;
  int line = 0;
  std::map<std::string, Entry> entries;
};

// "key:" at the beginning of a line, behind its blanks; empty when the line begins otherwise.
std::string_view key_of(std::string_view line) {
  const std::size_t begin = line.find_first_not_of(' ');
  if (begin == std::string_view::npos) return {};
  std::size_t end = begin;
  while (end < line.size() && (std::isalnum(static_cast<unsigned char>(line[end])) || line[end] == '_'))
    ++end;
  if (end == begin || end >= line.size() || line[end] != ':') return {};
  return line.substr(begin, end - begin);
}

void add_words(Entry& entry, std::string_view value) {
  std::string spaced;
  bool first = true;  // a dash at the beginning is a list's, elsewhere a minus
  for (std::size_t i = 0; i < value.size(); ++i) {
    const char c = value[i];
    const bool dash = first && c == '-' && i + 1 < value.size() &&
                      (value[i + 1] == ' ' || value[i + 1] == '[' || value[i + 1] == '-');
    if (c == '#') break;
    entry.open_brackets += (c == '[') - (c == ']');
    spaced += c == '[' || c == ']' || c == ',' || c == '\'' || c == '"' || dash ? ' ' : c;
    if (c != ' ' && !dash) first = false;
  }
  TextLines one(spaced, "");
  if (const std::optional<TextLine> line = one.next_filled())
    for (const std::string_view word : line->words) entry.words.emplace_back(word);
}

class Camchain {
 public:
  static Result<Camchain> parse(std::string_view content, std::string_view name) {
    Camchain chain;
    chain.name_ = name;
    TextLines lines(content, name);
    Entry* open = nullptr;
    while (const std::optional<TextLine> line = lines.next_filled('#')) {
      if (line->whole.starts_with("---") || line->whole.starts_with("%")) continue;
      const std::string key(key_of(line->whole));
      if (line->whole.find('\t') != std::string_view::npos)
        return lines.bad("YAML is indented by blanks, not by tabs");
      if (!key.empty() && line->whole[0] != ' ') {
        if (!key.starts_with("cam"))
          return lines.bad(text("'", key.substr(0, 40), "' is not a camera (cam0, cam1, …)"));
        chain.cameras.push_back({key, line->number, {}});
        open = nullptr;
      } else if (!key.empty()) {
        if (chain.cameras.empty()) return lines.bad("there is no camera (cam0:) before this");
        const auto [entry, fresh] = chain.cameras.back().entries.emplace(key, Entry{line->number, {}});
        if (!fresh) return lines.bad(text("'", key, "' stands there twice"));
        open = &entry->second;
        add_words(*open, line->whole.substr(line->whole.find(':') + 1));
      } else if (open) {
        add_words(*open, line->whole);
      } else {
        return lines.bad("this belongs to no key");
      }
    }
    for (const CamchainCamera& c : chain.cameras)
      for (const auto& [key, entry] : c.entries)
        if (entry.open_brackets != 0)
          return chain.bad(c, key, "has brackets that do not match; the file may be cut off");
    if (chain.cameras.empty())
      return fail(ErrorCode::BadData,
                  text(name, ": there is no camera (cam0:) in it; is it a Kalibr camchain?"));
    return chain;
  }

  Unexpected bad(const CamchainCamera& camera, const std::string& key, const std::string& what,
                 ErrorCode code = ErrorCode::BadData) const {
    const auto found = camera.entries.find(key);
    return fail(code, text(name_, ": line ", found == camera.entries.end() ? camera.line : found->second.line,
                           ": ", camera.key, ": ", key, ' ', what));
  }
  Result<std::vector<double>> numbers(const CamchainCamera& camera, const std::string& key,
                                      std::size_t count) const {
    const auto found = camera.entries.find(key);
    if (found == camera.entries.end()) return bad(camera, key, "is missing");
    std::vector<double> out;
    for (const std::string& word : found->second.words) {
      const std::optional<double> value = parse_number(word);
      if (!value)
        return bad(camera, key, text("holds '", word.substr(0, 40), "', which is no finite number"));
      out.push_back(*value);
    }
    if (out.size() != count)
      return bad(camera, key, text("holds ", out.size(), " numbers; ", count, " are expected"));
    return out;
  }
  std::string word(const CamchainCamera& camera, const std::string& key) const {
    const auto found = camera.entries.find(key);
    return found == camera.entries.end() || found->second.words.empty() ? "" : found->second.words.front();
  }

  std::vector<CamchainCamera> cameras;

 private:
  std::string name_;
};

Result<CameraModel> read_model(const Camchain& chain, const CamchainCamera& c) {
  if (chain.word(c, "camera_model") != "pinhole")
    return chain.bad(c, "camera_model",
                     text("is '", chain.word(c, "camera_model"), "'; Floatstage has 'pinhole' only"),
                     ErrorCode::Unsupported);
  const Result<std::vector<double>> k = chain.numbers(c, "intrinsics", 4),
                                    size = chain.numbers(c, "resolution", 2);
  if (!k) return forward(k);
  if (!size) return forward(size);
  CameraModel m;
  if (!((*size)[0] >= 1 && (*size)[1] >= 1 && (*size)[0] <= 1e6 && (*size)[1] <= 1e6))
    return chain.bad(c, "resolution", "is not a picture's size");
  m.width = static_cast<int>((*size)[0]);
  m.height = static_cast<int>((*size)[1]);
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  matrix(0, 0) = (*k)[0];
  matrix(1, 1) = (*k)[1];
  matrix(0, 2) = (*k)[2];
  matrix(1, 2) = (*k)[3];
  if (Result<void> ok = set_k(m, matrix, kOrigin); !ok) return chain.bad(c, "intrinsics", ok.error().message);
  const std::string lens = chain.word(c, "distortion_model");
  if (lens == "none" || lens.empty()) return m;
  if (lens != "radtan" && lens != "equidistant")
    return chain.bad(c, "distortion_model",
                     text("is '", lens.substr(0, 40), "'; Floatstage has 'radtan', 'equidistant' and 'none'"),
                     ErrorCode::Unsupported);
  const Result<std::vector<double>> d = chain.numbers(c, "distortion_coeffs", 4);
  if (!d) return forward(d);
  if (lens == "radtan")
    m.lens = BrownConrady{(*d)[0], (*d)[1], (*d)[2], (*d)[3], 0};
  else
    m.lens = KannalaBrandt{(*d)[0], (*d)[1], (*d)[2], (*d)[3]};
  return m;
}

// From the camera before to this one.
Result<Rigid3> read_step(const Camchain& chain, const CamchainCamera& c) {
  const Result<std::vector<double>> v = chain.numbers(c, "T_cn_cnm1", 16);
  if (!v) return forward(v);
  const Eigen::Matrix4d m = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(v->data());
  if (!m.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), 1e-9))
    return chain.bad(c, "T_cn_cnm1", "does not end in the row 0 0 0 1");
  const Result<Eigen::Quaterniond> rotation = rotation_from_matrix(m.topLeftCorner<3, 3>());
  if (!rotation) return chain.bad(c, "T_cn_cnm1", text("is wrong: ", rotation.error().message));
  return Rigid3{*rotation, m.topRightCorner<3, 1>()};
}

// "/left/image_raw" → left: who wrote the chain named the camera there; without a topic it is cam0, cam1, ….
std::string camera_name(const Camchain& chain, const CamchainCamera& c) {
  std::string topic = chain.word(c, "rostopic");
  for (const char* ending : {"/image_raw", "/image", "/image_color", "/image_mono"})
    if (topic.ends_with(ending)) topic.resize(topic.size() - std::string_view(ending).size());
  topic.erase(
      0, topic.find_first_not_of('/') == std::string::npos ? topic.size() : topic.find_first_not_of('/'));
  return topic.empty() ? c.key : topic;
}

std::string list(const std::vector<double>& values) {
  std::string out = "[";
  for (std::size_t i = 0; i < values.size(); ++i) out += (i == 0 ? "" : ", ") + to_text(values[i]);
  return out + "]";
}

}  // namespace

Result<ForeignRig> parse_kalibr(std::string_view yaml, std::string_view name) {
  const Result<Camchain> chain = Camchain::parse(yaml, name);
  if (!chain) return forward(chain);
  ForeignRig foreign;
  Rigid3 cam_from_first;
  for (const CamchainCamera& c : chain->cameras) {
    const Result<CameraModel> model = read_model(*chain, c);
    if (!model) return forward(model);
    if (!foreign.rig.cameras.empty()) {
      const Result<Rigid3> step = read_step(*chain, c);
      if (!step) return forward(step);
      cam_from_first = *step * cam_from_first;
      cam_from_first.rotation.normalize();
      if (!cam_from_first.translation.allFinite())
        return chain->bad(c, "T_cn_cnm1", "leads beyond all bounds");
    }
    const std::string camera = camera_name(*chain, c);
    foreign.rig.cameras.push_back({serial_from_name(camera), *model, cam_from_first, {}});
    foreign.image_names.push_back(camera);
  }
  return checked(std::move(foreign), name);
}

Result<ForeignRig> read_kalibr(const std::filesystem::path& camchain_yaml) {
  const Result<std::string> content = read_file(camchain_yaml);
  if (!content) return forward(content);
  return parse_kalibr(*content, camchain_yaml.string());
}

Result<void> write_kalibr(const Rig& rig, const std::filesystem::path& camchain_yaml) {
  const std::string file = camchain_yaml.string();
  if (Result<void> ok = check(rig); !ok) return fail(ok.error().code, text(file, ": ", ok.error().message));
  std::string out;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const RigCamera& c = rig.cameras[i];
    const Eigen::Matrix3d k = k_with_origin(c.model, kOrigin);
    const auto* brown = std::get_if<BrownConrady>(&c.model.lens);
    const auto* fisheye = std::get_if<KannalaBrandt>(&c.model.lens);
    if (c.model.skew != 0 || (brown && (brown->k3 != 0 || brown->rational())))
      return fail(ErrorCode::Unsupported,
                  text(file, ": camera '", c.serial, "' has ",
                       c.model.skew != 0   ? "skew"
                       : brown->rational() ? "a rational lens"
                                           : "a k3",
                       ", which a camchain cannot hold; write COLMAP or OpenCV instead"));
    out += text("cam", i, ":\n");
    if (i > 0) {
      const Eigen::Matrix4d step = (c.cam_from_world * rig.cameras[i - 1].cam_from_world.inverse()).matrix();
      out += "  T_cn_cnm1:\n";
      for (int r = 0; r < 4; ++r)
        out += "  - " + list({step(r, 0), step(r, 1), step(r, 2), step(r, 3)}) + "\n";
    }
    out += "  cam_overlaps: []\n  camera_model: pinhole\n";
    if (fisheye)
      out += "  distortion_coeffs: " + list({fisheye->k1, fisheye->k2, fisheye->k3, fisheye->k4}) +
             "\n  distortion_model: equidistant\n";
    else
      out += "  distortion_coeffs: " +
             (brown ? list({brown->k1, brown->k2, brown->p1, brown->p2}) : list({0, 0, 0, 0})) +
             "\n  distortion_model: " + (brown ? "radtan" : "none") + "\n";
    out += "  intrinsics: " + list({k(0, 0), k(1, 1), k(0, 2), k(1, 2)}) + "\n";
    out += text("  resolution: [", c.model.width, ", ", c.model.height, "]\n  rostopic: /", c.serial,
                "/image_raw\n");
  }
  return write_file(camchain_yaml, out);
}

}  // namespace floatstage::calib
