#include "apps/matte/label_words.h"

#include <charconv>
#include <optional>
#include <string_view>

#include "core/text.h"

namespace floatstage::apps {
namespace {

template <class Number>
bool read(std::string_view word, Number& number) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  return error == std::errc() && end == word.data() + word.size();
}

// NAME@WHERE:X,Y, where WHERE is what lies between: SERIAL:FRAME of a take, FRAME of a clip.
struct ClickWord {
  std::string label;
  std::string_view where;
  double x = 0, y = 0;
};

std::optional<ClickWord> click_of(std::string_view word) {
  constexpr auto kNone = std::string_view::npos;
  const std::size_t at = word.find('@'), place = word.rfind(':'), comma = word.rfind(',');
  if (at == kNone || at == 0 || place == kNone || place <= at + 1 || comma == kNone || comma < place)
    return std::nullopt;
  ClickWord click{std::string(word.substr(0, at)), word.substr(at + 1, place - at - 1)};
  if (!read(word.substr(place + 1, comma - place - 1), click.x) || !read(word.substr(comma + 1), click.y))
    return std::nullopt;
  return click;
}

std::optional<pipeline::LabelClick> take_click_of(std::string_view word) {
  const std::optional<ClickWord> click = click_of(word);
  const std::size_t colon = click ? click->where.rfind(':') : std::string_view::npos;
  int frame = 0;
  if (colon == std::string_view::npos || colon == 0 || !read(click->where.substr(colon + 1), frame) ||
      frame < 0)
    return std::nullopt;
  return pipeline::LabelClick{click->label, std::string(click->where.substr(0, colon)), frame, click->x,
                              click->y};
}

std::optional<pipeline::ClipClick> clip_click_of(std::string_view word) {
  const std::optional<ClickWord> click = click_of(word);
  int frame = 0;
  if (!click || !read(click->where, frame) || frame < 0) return std::nullopt;
  return pipeline::ClipClick{click->label, frame, click->x, click->y};
}

}  // namespace

Result<std::vector<NamedPath>> named_paths(const std::vector<std::string>& words) {
  std::vector<NamedPath> named;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == word.size())
      return fail(ErrorCode::InvalidArgument,
                  text("--label '", word, "' names no masks; write woman=mask.png or woman=folder"));
    named.push_back({word.substr(0, equals), word.substr(equals + 1)});
  }
  return named;
}

Result<std::vector<pipeline::LabelClick>> label_clicks(const std::vector<std::string>& words) {
  std::vector<pipeline::LabelClick> clicks;
  for (const std::string& word : words) {
    std::optional<pipeline::LabelClick> click = take_click_of(word);
    if (!click)
      return fail(ErrorCode::InvalidArgument,
                  text("--label-click '", word,
                       "' is no place; write it as woman@cam00:12:310,200: label, "
                       "camera, frame, and x,y in pixels"));
    clicks.push_back(std::move(*click));
  }
  return clicks;
}

Result<std::vector<pipeline::ClipClick>> clip_clicks(const std::vector<std::string>& words) {
  std::vector<pipeline::ClipClick> clicks;
  for (const std::string& word : words) {
    std::optional<pipeline::ClipClick> click = clip_click_of(word);
    if (!click)
      return fail(ErrorCode::InvalidArgument,
                  text("--label-click '", word,
                       "' is no place in a clip; write it as woman@12:310,200: label, frame, and x,y in "
                       "pixels"));
    clicks.push_back(std::move(*click));
  }
  return clicks;
}

}  // namespace floatstage::apps
