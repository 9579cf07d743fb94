#include "board/linux/check_uses.h"

#include <algorithm>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace thimble::board {
namespace {

class Uses {
 public:
  // what: "the GPIO line". where: the value that names the thing. remedy: what to do at a second use.
  // shared: uses of the same text may name one thing together; empty: no other may.
  void take(const std::string& what, const std::string& thing, const JsonValue& where, const char* remedy,
            const std::string& shared = "") {
    const auto before =
        std::ranges::find_if(uses_, [&](const Use& use) { return use.what == what && use.thing == thing; });
    if (before == uses_.end()) {
      uses_.push_back({what, thing, shared, where.place()});
    } else if (shared.empty() || shared != before->shared) {
      where.fail("used-twice", "names " + what + " " + thing + ", which " + before->place + " names too",
                 remedy);
    }
  }

 private:
  struct Use {
    std::string what, thing, shared, place;
  };
  std::vector<Use> uses_;
};

constexpr const char* kOtherLine = "wire each purpose to a line of its own, and name that";

void take_line(Uses& uses, const JsonValue& value, std::string_view key, const std::string& shared = "") {
  const JsonValue line = value.at(key);
  uses.take("the GPIO line", line.raw().dump(), line, kOtherLine, shared);
}

void take_encoders(Uses& uses, const JsonValue& joints) {
  for (std::size_t j = 0; j < joints.raw().size(); ++j) {
    const JsonValue joint = joints.at(j);
    if (joint.has("line_a")) {
      take_line(uses, joint, "line_a");
      take_line(uses, joint, "line_b");
    } else if (joint.has("counter")) {
      uses.take("the count", joint.at("counter").raw().dump() + " " + joint.at("count").raw().dump(), joint,
                "give each joint a count of its own");
    }
  }
}

}  // namespace

void check_uses(const JsonValue& root) {
  Uses uses;
  for (const char* key : {"e_stop", "dead_man", "heartbeat", "event"})
    if (root.has(key)) take_line(uses, root.at(key), "line");
  const JsonValue arms = root.at("arms");
  for (std::size_t i = 0; i < arms.raw().size(); ++i) {
    const JsonValue arm = arms.at(i);
    if (arm.has("enable")) take_line(uses, arm.at("enable"), "line");
    for (const char* key : {"drive_fault", "index"})
      if (arm.has(key))
        take_line(uses, arm.at(key), "line", std::string(key) + " " + arm.at(key).at("active").text());
    if (arm.has("dac"))  // its outputs are those of the arm's joints
      uses.take("the converter", arm.at("dac").at("spi").raw().dump(), arm.at("dac").at("spi"),
                "give each arm a converter of its own");
    if (arm.has("encoders")) take_encoders(uses, arm.at("encoders").at("joints"));
  }
  const JsonValue links = root.at("links");
  for (std::size_t i = 0; i < links.raw().size(); ++i)
    for (const char* key : {"can", "slcan"})
      if (links.at(i).has(key))
        uses.take("the interface", links.at(i).at(key).raw().dump(), links.at(i).at(key),
                  "leave out one of the links");
}

}  // namespace thimble::board
