#include "host-tools/can_tools/dbc.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <type_traits>

#include "firmware/core/faults.h"
#include "firmware/link/host_address.h"
#include "firmware/link/messages.h"

namespace thimble::host {
namespace {

namespace link = firmware::link;

constexpr std::uint32_t kExtended = 1U << 31U;  // of an id in a DBC

std::string quoted(std::string text) {
  std::ranges::replace(text, '"', '\'');
  return '"' + text + '"';
}

// The sections of a DBC that follow the messages.
struct Sections {
  std::string messages;
  std::string comments;
  std::string floats;  // which signals are IEEE numbers
  std::string values;  // names of values
};

// " 0 "disarmed" 1 "homing" ...": the names of the values of a field.
template <class Value>
std::string value_names(std::string_view field) {
  std::string names;
  const auto add = [&names](unsigned value, std::string_view name) {
    names += fmt::format(" {} {}", value, quoted(std::string(name)));
  };
  if constexpr (link::TableEnum<Value>) {
    for (const link::EnumRow& row : link::EnumTable<Value>::kRows) add(row.number, row.name);
  } else if (field == "fault") {
    add(0, "none");
    for (const firmware::FaultRow& row : firmware::kFaultTable)
      add(static_cast<unsigned>(row.fault), row.name);
  }
  return names;
}

// The signals of one message. Those of a kind begin with its name, and are there only where the multiplexer has its number.
class Signals {
 public:
  struct Kind {
    const char* name = nullptr;  // none: the message is of one kind
    unsigned number = 0;
    bool first = true;  // of its identifier
  };

  Signals(unsigned id, Kind kind, const char* receiver, Sections& out)
      : id_(id), kind_(kind), receiver_(receiver), out_(out) {}

  template <class Row, class Value>
  void operator()(const Row& row, const Value& /*value*/, const link::Place& place) {
    std::string name = place.part == nullptr ? row.name : fmt::format("{}_{}", place.part, row.name);
    if (place.index >= 0) name += fmt::format("_{}", place.index);
    if (Row::kIsKind && !kind_.first) return;
    is_multiplexer_ = Row::kIsKind;
    if (kind_.name != nullptr && !Row::kIsKind) name = fmt::format("{}_{}", kind_.name, name);
    if constexpr (!std::is_void_v<typename Row::Flags>) {
      for (const link::EnumRow& flag : link::EnumTable<typename Row::Flags>::kRows) {
        const auto bit = static_cast<unsigned>(std::countr_zero(flag.number));
        if (bit >= Row::kBits) continue;  // this message has no room for it
        signal(fmt::format("{}_{}", name, flag.name), row.at + bit, 1, false, 1.0, "", flag.description);
      }
    } else {
      using Wire = typename Row::Wire;
      const double step = std::stod(fmt::format("{}", row.scale));  // 1e-5F is meant as 0.00001
      signal(name, row.at, Row::kBits, std::is_signed_v<Wire>, step, row.unit, row.description,
             std::is_floating_point_v<Wire>);
      if (const std::string names = value_names<Value>(row.name); !names.empty())
        out_.values += fmt::format("VAL_ {} {}{} ;\n", id_, name, names);
    }
  }

 private:
  void signal(const std::string& name, unsigned at, unsigned bits, bool is_signed, double step,
              const char* unit, const char* text, bool is_float = false) {
    const double low = is_signed && !is_float ? -std::exp2(bits - 1) : 0.0;
    const double high = is_float ? 0.0 : std::exp2(is_signed ? bits - 1 : bits) - 1;
    const std::string multiplex = is_multiplexer_         ? " M"
                                  : kind_.name != nullptr ? fmt::format(" m{}", kind_.number)
                                                          : "";
    out_.messages +=
        fmt::format(" SG_ {}{} : {}|{}@1{} ({},0) [{}|{}] {} {}\n", name, multiplex, at, bits,
                    is_signed ? '-' : '+', step, low * step, high * step, quoted(unit), receiver_);
    if (*text != '\0') out_.comments += fmt::format("CM_ SG_ {} {} {};\n", id_, name, quoted(text));
    if (is_float) out_.floats += fmt::format("SIG_VALTYPE_ {} {} : 1;\n", id_, name);
  }

  unsigned id_;
  Kind kind_;
  const char* receiver_;
  Sections& out_;
  bool is_multiplexer_ = false;
};

// "Arm" of the frames that ArmKind tells apart.
template <class Kind>
std::string name_of_kinds() {
  std::string name = link::EnumTable<Kind>::kName;
  return name.substr(0, name.size() - std::string_view("Kind").size());
}

template <class Message>
inline constexpr bool kIsOrder =
    std::is_same_v<Message, link::ForceOrder> || std::is_same_v<Message, link::TorqueOrder>;

// Messages of one identifier follow each other in the table.
template <class Message>
void add_message(std::uint8_t node, unsigned& last_id, Sections& out) {
  const unsigned id = Message::kId + (Message::kPerNode ? node : 0U);
  const bool first = id != last_id;
  last_id = id;
  Signals::Kind kind;
  std::string name = Message::kName;
  if constexpr (requires { Message::kKind; }) {
    kind = {link::name(Message::kKind), static_cast<unsigned>(Message::kKind), first};
    name = name_of_kinds<std::remove_const_t<decltype(Message::kKind)>>();
  }
  if (first) {
    // Any node may send a message that is not per node.
    out.messages += fmt::format("\nBO_ {} {}: {} {}\n", id, name, link::wire_size<Message>(),
                                kIsOrder<Message>   ? "Host"
                                : Message::kPerNode ? "Controller"
                                                    : "Vector__XXX");
    out.comments += fmt::format(
        "CM_ BO_ {} {};\n", id,
        quoted(kind.name == nullptr ? Message::kDescription
                                    : "Frames of several kinds, told apart by their signal kind"));
  }
  const Message message;
  link::visit_numbers(message, Signals(id, kind, kIsOrder<Message> ? "Controller" : "Host", out));
}

// The claims that it answers have a random number in their identifier, which a DBC cannot describe.
void add_grant(std::uint8_t node, Sections& out) {
  const std::uint32_t id = link::grant_id(node) | kExtended;
  out.messages += fmt::format(
      "\nBO_ {} HostGrant: 8 Controller\n"
      " SG_ key : 0|48@1+ (1,0) [0|{}] \"\" Host\n"
      " SG_ address : 48|8@1+ (1,0) [0|255] \"\" Host\n"
      " SG_ places : 56|8@1+ (1,0) [0|255] \"\" Host\n",
      id, link::kHostKeyMask);
  out.comments += fmt::format("CM_ BO_ {} \"The address that a host gets for its services\";\n", id);
  out.comments += fmt::format("CM_ SG_ {} key \"of the host's claim\";\n", id);
  out.comments += fmt::format("CM_ SG_ {} address \"0: all places are taken\";\n", id);
  out.comments += fmt::format("CM_ SG_ {} places \"hosts that the controller serves at once\";\n", id);
}

}  // namespace

std::string dbc(std::uint8_t node) {
  Sections out;
  unsigned last_id = 0;
  link::visit_messages([&](auto message) {
    using Message = decltype(message);
    if constexpr (Message::kIsFrame && link::wire_size<Message>() <= link::kClassicDataBytes)
      add_message<Message>(node, last_id, out);
  });
  const auto add_service = [&out](std::uint32_t id, std::string_view name, std::string_view sender) {
    out.messages += fmt::format("\nBO_ {} {}: 8 {}\n", id | kExtended, name, sender);
    out.comments += fmt::format("CM_ BO_ {} {};\n", id | kExtended,
                                quoted("ISO-TP (ISO 15765-2) with services as in UDS; see `thimble decode`"));
  };
  add_service(link::request_id(node), "Request", "Host");
  add_service(link::response_id(node), "Response", "Controller");
  for (std::uint8_t host = link::kFirstHostAddress; host <= link::kLastHostAddress; ++host) {
    add_service(link::request_id(node, host), fmt::format("Request_{:X}", host), "Host");
    add_service(link::response_id(node, host), fmt::format("Response_{:X}", host), "Controller");
  }
  add_grant(node, out);
  return fmt::format("VERSION \"Thimble link {}\"\n\nNS_ :\n\nBS_:\n\nBU_: Controller Host\n{}\n{}{}{}",
                     link::kProtocolVersion, out.messages, out.comments, out.values, out.floats);
}

}  // namespace thimble::host
