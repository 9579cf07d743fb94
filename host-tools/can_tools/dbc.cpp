#include "host-tools/can_tools/dbc.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <type_traits>

#include "firmware/faults.h"
#include "firmware/link/messages.h"
#include "host-tools/client/device.h"

namespace thimble::host {
namespace {

namespace link = firmware::link;

constexpr std::uint32_t kExtended = 1U << 31U;  // of an id in a DBC
constexpr std::uint8_t kModes = 6;

std::string quoted(std::string text) {
  std::ranges::replace(text, '"', '\'');
  return '"' + text + '"';
}

// What a DBC says in sections of their own, behind the messages.
struct Sections {
  std::string messages;
  std::string comments;
  std::string floats;  // which signals are IEEE numbers
  std::string values;  // names of values
};

// "0 "disarmed" 1 "homing" ...": the names of a field's values; empty: it has none.
std::string value_names(std::string_view message, std::string_view field) {
  std::string names;
  const auto add = [&names](unsigned value, std::string_view name) {
    names += fmt::format(" {} {}", value, quoted(std::string(name)));
  };
  if (field == "mode") {
    for (std::uint8_t mode = 0; mode < kModes; ++mode) add(mode, mode_name(mode));
  } else if (field == "fault") {
    add(0, "none");
    for (const firmware::FaultRow& row : firmware::kFaultTable)
      add(static_cast<unsigned>(row.fault), row.name);
  } else if (message == "Heartbeat" && field == "state") {
    add(0x04, "faulted");
    add(0x05, "armed");
    add(0x7F, "not armed");
  }
  return names;
}

template <class Message>
void add_message(std::uint8_t node, Sections& out) {
  const unsigned id = Message::kId + (Message::kPerNode ? node : 0U);
  constexpr bool kOrder = std::is_same_v<Message, link::ForceOrder>;  // the one that goes the other way
  // Any node may stop everything.
  out.messages += fmt::format("BO_ {} {}: {} {}\n", id, Message::kName, link::wire_size<Message>(),
                              kOrder              ? "Host"
                              : Message::kPerNode ? "Controller"
                                                  : "Vector__XXX");
  out.comments += fmt::format("CM_ BO_ {} {};\n", id, quoted(Message::kDescription));
  unsigned bit = 0;
  const Message message;
  link::visit_fields(message, [&]<class Wire>(Wire, const char* name, const auto&, float scale,
                                              const char* unit, const char* text) {
    using Limits = std::numeric_limits<Wire>;
    constexpr bool kFloat = std::is_floating_point_v<Wire>;
    const double step = std::stod(fmt::format("{}", scale));  // 1e-5F is meant as 0.00001
    const double low = kFloat ? 0.0 : static_cast<double>(Limits::lowest()) * step;
    const double high = kFloat ? 0.0 : static_cast<double>(Limits::max()) * step;
    out.messages += fmt::format(" SG_ {} : {}|{}@1{} ({},0) [{}|{}] {} {}\n", name, bit, 8 * sizeof(Wire),
                                Limits::is_signed ? '-' : '+', step, low, high, quoted(unit),
                                kOrder ? "Controller" : "Host");
    if (*text != '\0') out.comments += fmt::format("CM_ SG_ {} {} {};\n", id, name, quoted(text));
    if (kFloat) out.floats += fmt::format("SIG_VALTYPE_ {} {} : 1;\n", id, name);
    if (const std::string names = value_names(Message::kName, name); !names.empty())
      out.values += fmt::format("VAL_ {} {}{} ;\n", id, name, names);
    bit += 8 * sizeof(Wire);
  });
  out.messages += '\n';
}

}  // namespace

std::string dbc(std::uint8_t node) {
  Sections out;
  link::visit_messages([&](auto message) {
    using Message = decltype(message);
    if constexpr (Message::kIsFrame) add_message<Message>(node, out);
  });
  const auto add_service = [&out](std::uint32_t id, std::string_view name, std::string_view sender) {
    out.messages += fmt::format("BO_ {} {}: 8 {}\n\n", id | kExtended, name, sender);
    out.comments += fmt::format("CM_ BO_ {} {};\n", id | kExtended,
                                quoted("ISO-TP (ISO 15765-2) with services as in UDS; see `thimble decode`"));
  };
  add_service(link::request_id(node), "Request", "Host");
  add_service(link::response_id(node), "Response", "Controller");
  return fmt::format("VERSION \"Thimble link {}\"\n\nNS_ :\n\nBS_:\n\nBU_: Controller Host\n\n{}{}{}{}",
                     link::kProtocolVersion, out.messages, out.comments, out.values, out.floats);
}

}  // namespace thimble::host
