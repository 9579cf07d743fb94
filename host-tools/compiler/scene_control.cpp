#include "host-tools/compiler/scene_control.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace thimble::host {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

// The rows of the table for a slide or a turn, in one order, and the file's unit of the coordinate in m or rad.
struct Kind {
  const char* control;
  const char* detents;
  const char* switch_;
  double unit;
};
constexpr Kind kSlide{"slide_control", "slide_detents", "slide_switch", 1.0};
constexpr Kind kTurn{"turn_control", "turn_detents", "turn_switch", kDegree};

std::vector<scene::CurvePoint> read_curve(const Value& value, const Range& range, double unit) {
  if (!value.raw().is_array() || value.raw().empty()) value.wrong("an array of points [at, effort]");
  if (value.raw().size() > control::kMaxCurvePoints) {
    value.fail("too-many-curve-points",
               "has " + std::to_string(value.raw().size()) + " points, at most " +
                   std::to_string(control::kMaxCurvePoints) + " are allowed",
               "leave out points that are nearly on a line with their neighbours");
  }
  constexpr auto kMaxEffort = static_cast<double>(control::kMaxControlEffort);
  std::vector<scene::CurvePoint> curve;
  for (std::size_t i = 0; i < value.raw().size(); ++i) {
    const Value point = value.at(i);
    if (!point.raw().is_array() || point.raw().size() != 2) point.wrong("two numbers [at, effort]");
    const Value at = point.at(std::size_t{0});
    const double q = at.number(range);
    const double effort =
        point.at(std::size_t{1}).number({-kMaxEffort, kMaxEffort, unit == 1.0 ? "N" : "N m"});
    const scene::CurvePoint next(static_cast<float>(q * unit), static_cast<float>(effort));
    if (!curve.empty() && next.at() <= curve.back().at())
      at.wrong("a number above the one of the point before, in " + std::string(range.unit));
    curve.push_back(next);
  }
  return curve;
}

double stiffness_of_curve(const std::vector<scene::CurvePoint>& curve) {
  double steepest = 0;
  for (std::size_t i = 1; i < curve.size(); ++i) {
    const float rise = curve[i].effort() - curve[i - 1].effort();
    const float run = curve[i].at() - curve[i - 1].at();
    steepest = std::max(steepest, static_cast<double>(std::abs(rise) / run));
  }
  return steepest;
}

}  // namespace

SceneControlElement read_control(const Value& value, bool turns) {
  const Kind& kind = turns ? kTurn : kSlide;
  const ScenePart part(value, kind.control);
  const std::vector<std::string_view>& keys = part.kind().key_names;
  SceneControlElement control;
  control.place = value.place();
  control.stiffness = part.number(keys[0]);
  control.rest = kind.unit * part.number(keys[1]);
  control.damping = part.number(keys[2]);
  control.friction = part.number(keys[3]);
  control.low = kind.unit * part.number(keys[4]);
  control.high = kind.unit * part.number(keys[5]);
  if (static_cast<float>(control.low) == static_cast<float>(control.high))
    part.at(keys[5]).wrong("a number above " + std::string(keys[4]));
  if (part.has("detents")) {
    const ScenePart detents(part.at("detents"), kind.detents);
    const std::vector<std::string_view>& words = detents.kind().key_names;
    control.detent_pitch = kind.unit * detents.number(words[0]);
    control.detent_phase = kind.unit * detents.number(words[1]);
    control.detent_effort = detents.number(words[2]);
  }
  if (part.has(keys[7])) control.curve = read_curve(part.at(keys[7]), part.range(keys[7]), kind.unit);
  if (part.has("switch")) {
    const ScenePart places(part.at("switch"), kind.switch_);
    const std::vector<std::string_view>& words = places.kind().key_names;
    control.has_switch = true;
    control.on_at = kind.unit * places.number(words[0]);
    control.off_at = kind.unit * places.number(words[1]);
    if (static_cast<float>(control.on_at) == static_cast<float>(control.off_at))
      places.at(words[1]).wrong("a number other than " + std::string(words[0]));
  }
  return control;
}

flatbuffers::Offset<scene::Control> write_control(flatbuffers::FlatBufferBuilder& builder,
                                                  const SceneControlElement& control, double inertia) {
  const double detents = control.detent_pitch > 0.0
                             ? 2.0 * std::numbers::pi * control.detent_effort / control.detent_pitch
                             : 0.0;
  const double rate = std::sqrt((control.stiffness + detents + stiffness_of_curve(control.curve)) / inertia);
  // The controller checks the same with floats.
  constexpr double kRounding = 1.0 - 1.0e-5;
  constexpr auto kMost = static_cast<double>(control::kMaxControlRate_rad_s);
  if (!(rate <= kMost * kRounding)) {
    throw Error(
        ExitCode::kBadInput, "control-too-stiff",
        control.place +
            " is too stiff for what it moves: spring, detents and curve together over the inertia of " +
            number(inertia) + " give " + number(std::round(rate)) + " rad/s, at most " + number(kMost) +
            " rad/s are allowed",
        "make it softer, its detents or the steps of its curve wider, or the body heavier");
  }
  const auto cast = [](double value) { return static_cast<float>(value); };
  const auto curve =
      control.curve.empty() ? 0 : builder.CreateVectorOfStructs(control.curve.data(), control.curve.size());
  return scene::CreateControl(
      builder, cast(control.stiffness), cast(control.rest), cast(control.damping), cast(control.friction),
      cast(control.low), cast(control.high), cast(control.detent_pitch), cast(control.detent_phase),
      cast(control.detent_effort), curve, cast(control.on_at), cast(control.off_at), control.has_switch);
}

}  // namespace thimble::host
