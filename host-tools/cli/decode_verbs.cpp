// dbc and decode: the message database for other CAN tools, and their logs in plain text.
#include <fmt/format.h>

#include <array>
#include <fstream>
#include <iostream>
#include <map>
#include <type_traits>

#include "firmware/link/host_address.h"
#include "firmware/link/iso_tp.h"
#include "firmware/link/services.h"
#include "host-tools/can_tools/can_log.h"
#include "host-tools/can_tools/dbc.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/files/input_file.h"
#include "host-tools/files/output_file.h"

namespace thimble::host {
namespace {

namespace link = firmware::link;
using link::CanFrame;

constexpr std::uint32_t kServiceId = 0x18DA0000;  // then the address of the receiver and of the sender
constexpr std::uint32_t kNodes = 0x7F;            // the node's bits of a real-time frame's id

bool is_host(std::uint8_t address) {
  return address >= link::kTesterAddress && address <= link::kLastHostAddress;
}

std::string hex(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) text += fmt::format("{:02X}", byte);
  return text;
}

std::string_view service_name(std::uint8_t code) {
  using link::Service;
  switch (static_cast<Service>(code)) {
    case Service::kSession:
      return "session";
    case Service::kReset:
      return "reset";
    case Service::kClearFaults:
      return "clear_faults";
    case Service::kReadFaults:
      return "read_faults";
    case Service::kReadData:
      return "read_data";
    case Service::kAuthentication:
      return "authentication";
    case Service::kWriteData:
      return "write_data";
    case Service::kRoutine:
      return "routine";
    case Service::kRequestDownload:
      return "request_download";
    case Service::kTransferData:
      return "transfer_data";
    case Service::kTransferExit:
      return "transfer_exit";
    case Service::kTesterPresent:
      return "tester_present";
  }
  return "unknown";
}

// A record of messages.def that one answer of read_data brings; empty where it brings something else.
Json record_json(std::span<const std::uint8_t> pdu) {
  Json json = Json::object();
  const std::uint16_t did = static_cast<std::uint16_t>(pdu[1] << 8U | pdu[2]);
  link::visit_messages([&](auto message) {
    using Message = decltype(message);
    if constexpr (!Message::kIsFrame) {
      if (Message::kId == did && pdu.size() == 3 + link::wire_size<Message>() &&
          link::decode(pdu.subspan(3), message))
        json = {{"record", Message::kName}, {"fields", host::to_json(message)}};
    }
  });
  return json;
}

Json pdu_json(std::span<const std::uint8_t> pdu, bool request) {
  Json json;
  json["message"] = request ? "Request" : "Response";
  const bool refused = !request && pdu[0] == link::kNegative && pdu.size() >= 3;
  const std::uint8_t code = refused   ? pdu[1]
                            : request ? pdu[0]
                                      : static_cast<std::uint8_t>(pdu[0] - link::kPositive);
  json["service"] = service_name(code);
  if (refused) json["refused"] = link::name(static_cast<link::Nrc>(pdu[2]));
  json["bytes"] = pdu.size();
  json["pdu"] = hex(pdu);
  if (!request && !refused && code == static_cast<std::uint8_t>(link::Service::kReadData) && pdu.size() > 3)
    json.update(record_json(pdu));
  return json;
}

// Decodes frames, one JSON object each; empty for a frame that is a part of a longer message.
class Decoder {
 public:
  Json operator()(const LoggedFrame& logged) {
    Json said;
    if (logged.error) {
      said = {{"message", "ErrorFrame"}};
    } else if (logged.frame.extended) {
      said = address_frame(logged.frame);
      if (said.empty()) said = service(logged);
    } else {
      said = real_time(logged.frame);
    }
    if (said.empty()) return said;
    Json json;
    json["schema"] = kJsonSchema;
    json["time_s"] = logged.time_s;
    json["interface"] = logged.interface;
    json.update(said);
    return json;
  }
  // Incomplete PDUs, and frames with an unknown identifier.
  [[nodiscard]] unsigned broken() const { return broken_; }
  [[nodiscard]] unsigned foreign() const { return foreign_; }

 private:
  Json real_time(const CanFrame& frame) {
    Json json;
    link::visit_messages([&](auto message) {
      using Message = decltype(message);
      if constexpr (Message::kIsFrame) {
        const auto node = static_cast<std::uint8_t>(frame.id & kNodes);
        bool mine = frame.id == Message::kId;
        if constexpr (Message::kPerNode) mine = node != 0 && (frame.id & ~kNodes) == Message::kId;
        // An emergency stop counts with and without data, and as a remote frame.
        constexpr bool kAnyFrame = std::is_same_v<Message, link::EmergencyStop>;
        const bool whole = !frame.remote && link::decode(frame.bytes(), message);
        if (!mine || (!whole && !kAnyFrame)) return;
        json["message"] = Message::kName;
        if (Message::kPerNode) json["node"] = node;
        json.update(host::to_json(message));
      }
    });
    if (json.empty()) ++foreign_;
    return json;
  }

  // The frames by which hosts get their addresses (link/host_address.h).
  static Json address_frame(const CanFrame& frame) {
    const auto node = static_cast<std::uint8_t>(frame.id);
    link::HostClaim claim;
    link::HostGrant grant;
    if (link::from_frame(frame, node, claim)) {
      const bool release = claim.action == link::ClaimAction::kRelease;
      return {{"message", release ? "HostRelease" : "HostClaim"}, {"node", node}, {"key", claim.key}};
    }
    if (link::from_frame(frame, node, grant))
      return {{"message", "HostGrant"}, {"node", node}, {"key", grant.key}, {"host", grant.address}};
    return {};
  }

  Json service(const LoggedFrame& logged) {
    const CanFrame& frame = logged.frame;
    const auto to = static_cast<std::uint8_t>(frame.id >> 8U);
    const auto from = static_cast<std::uint8_t>(frame.id);
    const bool request = is_host(from);
    if ((frame.id & 0x1FFF0000U) != kServiceId || (!request && !is_host(to)) || frame.remote) {
      ++foreign_;
      return {};
    }
    constexpr link::IsoTpConfig kConfig;
    link::IsoTpReceiver& receiver = receivers_[{logged.interface, frame.id}];
    receiver.on_frame(frame, kConfig, 0);
    CanFrame flow_control;  // the receiver sends it
    (void)receiver.next_flow_control(flow_control, kConfig);
    if (receiver.take_error() != link::IsoTpError::kNone) ++broken_;
    if (receiver.received().empty()) return {};
    Json json = pdu_json(receiver.received(), request);
    json["node"] = request ? to : from;
    json["host"] = request ? from : to;
    receiver.release();
    return json;
  }

  std::map<std::pair<std::string, std::uint32_t>, link::IsoTpReceiver> receivers_;
  unsigned broken_ = 0;
  unsigned foreign_ = 0;
};

// "12.000123 can0 Pose node=1 x_m=0.01 ..."
void print_text(const Json& said) {
  std::string text = fmt::format("{:.6f} {} {}", said["time_s"].get<double>(),
                                 said["interface"].get<std::string>(), said["message"].get<std::string>());
  for (const auto& [key, value] : said.items()) {
    if (key == "schema" || key == "time_s" || key == "interface" || key == "message") continue;
    text += fmt::format(" {}={}", key, value.is_string() ? value.get<std::string>() : value.dump());
  }
  say("{}\n", text);
}

}  // namespace

void write_dbc(unsigned node, const std::filesystem::path& output) {
  const std::string text = dbc(static_cast<std::uint8_t>(node));
  if (output.empty()) {
    say("{}", text);
    return;
  }
  OutputFile file(output);
  file.stream() << text;
  file.commit();
}

void decode(const Common& common, const std::filesystem::path& log) {
  std::ifstream file;
  if (log != "-") file = open_input(log);
  std::istream& in = log == "-" ? std::cin : file;
  Decoder decoder;
  std::size_t number = 0;
  std::array<char, 4096> buffer{};  // ten times the longest frame
  for (; in.getline(buffer.data(), buffer.size()); ++number) {
    const std::string line = buffer.data();
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const std::optional<LoggedFrame> logged = parse_log_line(line);
    if (!logged) {
      throw Error(ExitCode::kBadInput, "bad-log",
                  fmt::format("{}:{}: '{}' is no line of a candump log", log.string(), number + 1,
                              line.substr(0, 60)),
                  "log with `candump -L can0 > FILE` or `candump -l can0`");
    }
    const Json said = decoder(*logged);
    if (said.empty()) continue;
    if (common.json) {
      print_line(said);
    } else {
      print_text(said);
    }
  }
  if (!in.eof())
    throw Error(ExitCode::kBadInput, "bad-log",
                fmt::format("{}:{}: the line is longer than {} characters", log.string(), number + 1,
                            buffer.size() - 1),
                "log with `candump -L can0 > FILE` or `candump -l can0`");
  if (decoder.broken() + decoder.foreign() != 0) {
    say(stderr, "thimble: {} PDUs are not whole, {} frames are not Thimble's\n", decoder.broken(),
        decoder.foreign());
  }
}

}  // namespace thimble::host
