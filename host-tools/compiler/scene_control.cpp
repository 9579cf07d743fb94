#include "host-tools/compiler/scene_control.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace thimble::host {
namespace {

constexpr double kMaxEffort = static_cast<double>(control::kMaxControlEffort);
constexpr double kMinPitch = static_cast<double>(control::kMinDetentPitch);
constexpr double kDegree = std::numbers::pi / 180.0;

// What differs between a slide and a turn: the words, and the file's unit of the coordinate.
struct Kind {
  const char* name;
  const std::array<std::string_view, 9>& keys;
  const std::array<std::string_view, 3>& detent_keys;
  const std::array<std::string_view, 2>& switch_keys;
  double unit;  // in m or rad
  double most;  // of a coordinate, in the file's unit
  const char* of_coordinate;
  const char* of_effort;
  const char* of_stiffness;
  const char* of_damping;
};
constexpr Kind kSlide{"a control that slides",
                      kSlideControlKeys,
                      kSlideDetentKeys,
                      kSlideSwitchKeys,
                      1.0,
                      kMaxCoordinate,
                      "m",
                      "N",
                      "N/m",
                      "N s/m"};
// 5729 degrees are just below control::kMaxTurn_rad.
constexpr Kind kTurn{"a control that turns",
                     kTurnControlKeys,
                     kTurnDetentKeys,
                     kTurnSwitchKeys,
                     kDegree,
                     5729.0,
                     "degrees",
                     "N m",
                     "N m/rad",
                     "N m s/rad"};

std::vector<scene::CurvePoint> read_curve(const Value& value, const Kind& kind) {
  if (!value.raw().is_array() || value.raw().empty()) {
    value.wrong("an array of points [at, effort]");
  }
  if (value.raw().size() > control::kMaxCurvePoints) {
    value.fail("too-many-curve-points",
               "has " + std::to_string(value.raw().size()) + " points, at most " +
                   std::to_string(control::kMaxCurvePoints) + " are allowed",
               "leave out points that are nearly on a line with their neighbours");
  }
  std::vector<scene::CurvePoint> curve;
  for (std::size_t i = 0; i < value.raw().size(); ++i) {
    const Value point = value.at(i);
    if (!point.raw().is_array() || point.raw().size() != 2) {
      point.wrong("two numbers [at, effort]");
    }
    const Value at = point.at(std::size_t{0});
    const double q = at.as_number({-kind.most, kind.most, false, kind.of_coordinate});
    const double effort =
        point.at(std::size_t{1}).as_number({-kMaxEffort, kMaxEffort, false, kind.of_effort});
    const scene::CurvePoint next(static_cast<float>(q * kind.unit), static_cast<float>(effort));
    if (!curve.empty() && next.at() <= curve.back().at()) {
      at.wrong("a number above the one of the point before, in " + std::string(kind.of_coordinate));
    }
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

SceneControl read_control(const Value& value, bool turns) {
  const Kind& kind = turns ? kTurn : kSlide;
  value.object(kind.name, kind.keys);
  const Range kPlace{-kind.most, kind.most, false, kind.of_coordinate};
  SceneControl control;
  control.place = value.place();
  control.stiffness = value.number_or(
      kind.keys[0], {0.0, static_cast<double>(control::kMaxStiffness_N_m), false, kind.of_stiffness}, 0.0);
  control.rest = kind.unit * value.number_or(kind.keys[1], kPlace, 0.0);
  control.damping = value.number_or(
      kind.keys[2], {0.0, static_cast<double>(control::kMaxDamping_N_s_m), false, kind.of_damping}, 0.0);
  control.friction = value.number_or(kind.keys[3], {0.0, kMaxEffort, false, kind.of_effort}, 0.0);
  control.low =
      kind.unit * value.number_or(kind.keys[4], {-kind.most, 0.0, false, kind.of_coordinate}, -kind.most);
  control.high =
      kind.unit * value.number_or(kind.keys[5], {0.0, kind.most, false, kind.of_coordinate}, kind.most);
  if (static_cast<float>(control.low) == static_cast<float>(control.high)) {
    value.at(kind.keys[5]).wrong("a number above " + std::string(kind.keys[4]));
  }
  if (value.has("detents")) {
    const Value detents = value.at("detents");
    detents.object("detents", kind.detent_keys);
    control.detent_pitch =
        kind.unit * detents.at(kind.detent_keys[0])
                        .as_number({kMinPitch / kind.unit, kind.most, false, kind.of_coordinate});
    control.detent_phase = kind.unit * detents.number_or(kind.detent_keys[1], kPlace, 0.0);
    control.detent_effort =
        detents.at(kind.detent_keys[2]).as_number({0.0, kMaxEffort, true, kind.of_effort});
  }
  if (value.has(kind.keys[7])) {
    control.curve = read_curve(value.at(kind.keys[7]), kind);
  }
  if (value.has("switch")) {
    const Value places = value.at("switch");
    places.object("a switch", kind.switch_keys);
    control.has_switch = true;
    control.on_at = kind.unit * places.at(kind.switch_keys[0]).as_number(kPlace);
    control.off_at = kind.unit * places.at(kind.switch_keys[1]).as_number(kPlace);
    if (static_cast<float>(control.on_at) == static_cast<float>(control.off_at)) {
      places.at(kind.switch_keys[1]).wrong("a number other than " + std::string(kind.switch_keys[0]));
    }
  }
  return control;
}

flatbuffers::Offset<scene::Control> write_control(flatbuffers::FlatBufferBuilder& builder,
                                                  const SceneControl& control, double inertia) {
  const double detents = control.detent_pitch > 0.0
                             ? 2.0 * std::numbers::pi * control.detent_effort / control.detent_pitch
                             : 0.0;
  const double rate = std::sqrt((control.stiffness + detents + stiffness_of_curve(control.curve)) / inertia);
  // The controller says the same of the numbers as rounded to float.
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
