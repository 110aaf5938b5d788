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

std::optional<pipeline::LabelClick> click_of(std::string_view word) {
  constexpr auto kNone = std::string_view::npos;
  const std::size_t at = word.find('@'), place = word.rfind(':'), comma = word.rfind(',');
  if (at == kNone || at == 0 || place == kNone || place <= at || comma == kNone || comma < place)
    return std::nullopt;
  const std::size_t frame = word.rfind(':', place - 1);
  if (frame == kNone || frame <= at + 1) return std::nullopt;
  pipeline::LabelClick click;
  click.label = word.substr(0, at);
  click.serial = word.substr(at + 1, frame - at - 1);
  if (!read(word.substr(frame + 1, place - frame - 1), click.frame) || click.frame < 0 ||
      !read(word.substr(place + 1, comma - place - 1), click.x) || !read(word.substr(comma + 1), click.y))
    return std::nullopt;
  return click;
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
    std::optional<pipeline::LabelClick> click = click_of(word);
    if (!click)
      return fail(ErrorCode::InvalidArgument,
                  text("--label-click '", word,
                       "' is no place; write it as woman@cam00:12:310,200: label, "
                       "camera, frame, and x,y in pixels"));
    clicks.push_back(std::move(*click));
  }
  return clicks;
}

}  // namespace floatstage::apps
