// Method:  a key in one pass to rows of bits, cleaned and refined on those
// Paper:   A. R. Smith, J. F. Blinn, "Blue screen matting", 1996 (see clean_up.cpp and refine_edges.cpp, the
// references)
// Differs: opacity is computed where it is neither 0 nor 255 only
// ADR:     0195, 0342

#include "matting/keyers/live_key.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <optional>
#include <utility>

#include "core/reused.h"
#include "matting/keyers/alpha_bits.h"
#include "matting/keyers/bit_clean_up.h"
#include "matting/keyers/bit_edges.h"
#include "matting/keyers/bit_empty_stage.h"
#include "matting/keyers/byte_closing.h"
#include "matting/keyers/plate_measure.h"
#include "matting/keyers/rim_check.h"
#include "matting/keyers/row_measure.h"

namespace floatstage::matting {
namespace {

// Off the edge, a little opacity is noise of the cloth; half opacity stays half.
float without_noise(float a) { return a >= 0.5f ? a : std::max(0.0f, (a - 0.25f) * 2); }

// A matte's memory.
struct Sheet {
  std::vector<std::uint8_t> alpha;
  int width = 0, height = 0;
  BitBox drawn;  // outside it is 0
};

}  // namespace

struct LiveKey::Impl {
  explicit Impl(const Keyer& k) : keyer(k), measure(k.rows()), cleanup(k.cleanup()) {
    if (fast() && k.empty_stage() != nullptr) stage.emplace(*k.empty_stage());
  }
  bool fast() const { return measure != nullptr && BitCleanUp::can(cleanup); }
  void light(const PixelRows& rgb, const CastShade* shade);
  void classify(const PixelRows& rgb, int width, int height);
  void crop();
  void close(const PixelRows& rgb);
  double rim_share(int width, int height) const;
  std::shared_ptr<Sheet> blank(int width, int height);
  void draw(const PixelRows& rgb, Sheet& sheet);
  std::uint8_t key_of(const PixelRows& rgb, int x, int y) const;

  const Keyer& keyer;
  const RowMeasure* measure;        // the keyer's, or `lit`
  std::optional<PlateMeasure> lit;  // since the first shade
  CleanupOptions cleanup;
  std::vector<std::uint8_t> scratch;  // of the measure
  BitRows whole[3];                   // of the picture: subject, faint, doubt
  int left = 0, top = 0;              // of the part of it where something is, of which the next are
  BitRows subject, faint, doubt;
  ByteClosing closed;  // of that part, where there is a closing
  BitCleanUp cleaner;
  BitEdges edges;
  std::optional<BitEmptyStage> stage;
  Reused<Sheet> sheets;
  Image converted;  // of a frame that is not RGB
};

LiveKey::LiveKey(const Keyer& keyer) : impl_(std::make_unique<Impl>(keyer)) {}
LiveKey::LiveKey(LiveKey&&) noexcept = default;
LiveKey& LiveKey::operator=(LiveKey&&) noexcept = default;
LiveKey::~LiveKey() = default;

bool LiveKey::fast() const { return impl_->fast(); }

void LiveKey::Impl::light(const PixelRows& rgb, const CastShade* shade) {
  measure = keyer.rows();
  if (shade == nullptr || !shade->any()) return;
  if (!lit)
    if (const auto* plate = dynamic_cast<const PlateMeasure*>(measure)) lit.emplace(*plate);
  if (!lit) return;
  lit->light(rgb, *shade);
  measure = &*lit;
}

void LiveKey::Impl::classify(const PixelRows& rgb, int width, int height) {
  for (BitRows& bits : whole) bits.resize(width, height);
  for (int y = 0; y < height; ++y) {
    measure->classify(rgb.at(0, y), y, width, scratch, whole[0].row(y), whole[1].row(y), whole[2].row(y));
    for (BitRows& bits : whole) bits.trim(y);
  }
}

// The part around what is not all cloth, with room for everything that looks around itself; from a whole word
// on.
void LiveKey::Impl::crop() {
  BitBox box = bounding_box(whole[1]);
  if (!box.empty()) box = grown(box, BitMorphology::kMostRadius, whole[1]);
  left = box.x0 / 64 * 64;
  top = box.y0;
  BitRows* parts[3] = {&subject, &faint, &doubt};
  for (int k = 0; k < 3; ++k) {
    parts[k]->resize(box.x1 - left, box.y1 - top);
    for (int y = 0; y < parts[k]->height(); ++y) {
      std::copy_n(whole[k].row(top + y) + left / 64, parts[k]->words(), parts[k]->row(y));
      parts[k]->trim(y);
    }
  }
}

// The part's key, closed, and what is subject and faint of that.
void LiveKey::Impl::close(const PixelRows& rgb) {
  closed.resize(subject.width(), subject.height());
  for (int y = 0; y < closed.height(); ++y)
    measure->opacities(rgb.at(left, top + y), left, top + y, closed.width(), closed.row(y));
  closed.close(cleanup.close_radius);
  for (int y = 0; y < closed.height(); ++y)
    for (const auto& [bits, least] : {std::pair(&subject, kSubjectAlpha), std::pair(&faint, kFaintAlpha)})
      bits_of_row(closed.row(y), closed.width(), least, bits->row(y));
}

double LiveKey::Impl::rim_share(int width, int height) const {
  const int rim = rim_width(width, height);
  if (rim == 0) return 0;
  long seen = 0, inside = 0;
  const auto count = [&](int y, int x0, int x1) {
    seen += x1 - x0;
    if (y < top || y >= top + subject.height()) return;
    const int end = std::min(x1 - left, subject.width());
    for (int x = std::max(x0 - left, 0); x < end; ++x) inside += subject.at(x, y - top);
  };
  for (int y = 0; y < height; ++y) {
    if (y < rim || y >= height - rim || 2 * rim >= width) {
      count(y, 0, width);
    } else {
      count(y, 0, rim);
      count(y, width - rim, width);
    }
  }
  return static_cast<double>(inside) / static_cast<double>(seen);
}

// A matte of nothing.
std::shared_ptr<Sheet> LiveKey::Impl::blank(int width, int height) {
  std::shared_ptr<Sheet> sheet = sheets.take();
  const std::size_t row = static_cast<std::size_t>(width);
  if (sheet->width != width || sheet->height != height) {
    sheet->alpha.assign(row * static_cast<std::size_t>(height), 0);
    sheet->width = width;
    sheet->height = height;
  } else {
    const BitBox& box = sheet->drawn;
    for (int y = box.y0; y < box.y1; ++y)
      std::memset(sheet->alpha.data() + row * static_cast<std::size_t>(y) + box.x0, 0,
                  static_cast<std::size_t>(box.x1 - box.x0));
  }
  sheet->drawn = {};
  return sheet;
}

// The key of a pixel of the part, before it is cleaned and after its closing.
std::uint8_t LiveKey::Impl::key_of(const PixelRows& rgb, int x, int y) const {
  if (cleanup.close_radius > 0) return closed.row(y)[x];
  std::uint8_t key = 0;
  measure->opacities(rgb.at(left + x, top + y), left + x, top + y, 1, &key);
  return key;
}

// Opacity of the cleaned key: 255 inside, solved along the edge and in hair.
void LiveKey::Impl::draw(const PixelRows& rgb, Sheet& sheet) {
  edges.find(subject, faint, doubt);
  const BitRows& inside = edges.inside();
  const std::size_t width = static_cast<std::size_t>(sheet.width);
  const auto pixel = [&](int x, int y) -> std::uint8_t& {
    return sheet.alpha[width * static_cast<std::size_t>(top + y) + static_cast<std::size_t>(left + x)];
  };
  BitBox drawn = bounding_box(inside);
  for (int y = drawn.y0; y < drawn.y1; ++y)
    for (std::size_t w = 0; w < inside.words(); ++w)
      for (std::uint64_t bits = inside.row(y)[w]; bits != 0;) {
        const int first = std::countr_zero(bits), count = std::countr_one(bits >> first);
        std::memset(&pixel(static_cast<int>(64 * w) + first, y), 255, static_cast<std::size_t>(count));
        if (first + count >= 64) break;
        bits = bits >> (first + count) << (first + count);
      }
  if (drawn.empty()) drawn = {subject.width(), subject.height(), 0, 0};
  const auto solve = [&](const BitEdges::Solved& p) {
    const std::uint8_t* c = rgb.at(left + p.x, top + p.y);
    std::uint8_t& out = pixel(p.x, p.y);
    if (p.known && std::abs(p.subject - p.backing) >= measure->contrast()) {
      const float solved = (measure->at(c, left + p.x, top + p.y) - p.backing) / (p.subject - p.backing);
      out = static_cast<std::uint8_t>(
          std::clamp(255 * (p.on_edge ? solved : without_noise(solved)) + 0.5f, 0.0f, 255.0f));
    } else if (cleaner.filled().at(p.x, p.y)) {
      out = 255;
    } else if (cleaner.kept().at(p.x, p.y)) {
      out = key_of(rgb, p.x, p.y);
    }
    if (out == 0) return;
    drawn = {std::min(drawn.x0, p.x), std::min(drawn.y0, p.y), std::max(drawn.x1, p.x + 1),
             std::max(drawn.y1, p.y + 1)};
  };
  const auto rows = [&](int y, int x0, int x1, std::int32_t* out) {
    measure->quantize(rgb.at(left + x0, top + y), left + x0, top + y, x1 - x0, scratch, out + x0);
  };
  edges.solve(std::cref(rows), std::cref(solve));
  sheet.drawn =
      drawn.empty() ? BitBox{} : BitBox{left + drawn.x0, top + drawn.y0, left + drawn.x1, top + drawn.y1};
}

Result<Matte> LiveKey::key(const Frame& frame, const CastShade* shade) {
  Impl& own = *impl_;
  const ImageLayout& layout = frame.layout;
  const int width = layout.width, height = layout.height;
  if (!own.fast() || frame.empty() || layout.format == PixelFormat::Gray8 || width <= 0 || height <= 0 ||
      !own.keyer.rows()->fits(width, height))
    return own.keyer.key(frame);
  PixelRows rgb{reinterpret_cast<const std::uint8_t*>(frame.pixels.get()), layout.stride};
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(layout.width);
  const bool as_it_is =
      layout.format == PixelFormat::Rgb8 && layout.height > 0 && layout.stride >= row_bytes &&
      layout.size_bytes >= layout.stride * static_cast<std::size_t>(layout.height - 1) + row_bytes;
  if (!as_it_is) {
    if (Result<void> ok = to_rgb(frame, own.converted); !ok) return forward(ok);
    rgb = {own.converted.pixels.data(), 3 * static_cast<std::size_t>(own.converted.width)};
  }
  own.light(rgb, shade);
  own.classify(rgb, width, height);
  own.crop();
  if (own.cleanup.close_radius > 0) own.close(rgb);
  own.cleaner.run(own.cleanup, own.subject, own.faint);
  if (const std::string_view sought = own.measure->sought(); !sought.empty())
    if (Result<void> ok = check_rim(own.rim_share(width, height), frame.info, sought); !ok)
      return forward(ok);
  const std::shared_ptr<Sheet> sheet = own.blank(width, height);
  own.draw(rgb, *sheet);
  if (own.stage && own.stage->fits(width, height))
    own.stage->correct(rgb,
                       {own.left, own.top, own.left + own.subject.width(), own.top + own.subject.height()},
                       sheet->alpha.data(), static_cast<std::size_t>(width), sheet->drawn);
  return Matte{frame.info, width, height, static_cast<std::size_t>(width),
               std::shared_ptr<const std::uint8_t[]>(sheet, sheet->alpha.data())};
}

}  // namespace floatstage::matting
