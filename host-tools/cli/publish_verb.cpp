// publish: the telemetry of a device to an MQTT broker, for a lab's dashboard.
#include <algorithm>
#include <charconv>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>

#include "host-tools/cli/interrupt.h"
#include "host-tools/cli/mqtt_publisher.h"
#include "host-tools/cli/open_remote.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/telemetry_json.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/client/device.h"
#include "host-tools/files/input_file.h"

namespace thimble::host {
namespace {

constexpr link::Micros kDeviceSilence_us =
    3'000'000;  // without telemetry for this time the device counts as lost
constexpr link::Micros kPublishSlice_us = 100'000;

double utc_now_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

// "host", "host:port", "[IPv6]" or "[IPv6]:port".
MqttBroker broker_of(const PublishChoice& choice) {
  MqttBroker broker;
  std::string_view host = choice.broker;
  std::string_view port;  // with its colon
  if (const std::size_t closed = host.find(']'); host.starts_with('[') && closed != std::string_view::npos) {
    port = host.substr(closed + 1);
    host = host.substr(1, closed - 1);
  } else if (const std::size_t colon = host.find(':');
             colon != std::string_view::npos && colon == host.rfind(':')) {  // several: IPv6, without a port
    port = host.substr(colon);
    host = host.substr(0, colon);
  }
  bool good = !host.empty() && host.find_first_of("[]") == std::string_view::npos;
  if (good && !port.empty()) {
    const char* const end = port.data() + port.size();
    const auto read = std::from_chars(port.data() + 1, end, broker.port);
    good = port.front() == ':' && read.ec == std::errc() && read.ptr == end && broker.port != 0;
  }
  if (!good)
    throw Error(ExitCode::kUsage, "bad-broker", "'" + choice.broker + "' is no address of a broker",
                "give --broker HOST, HOST:PORT or [IPv6]:PORT");
  broker.host = host;
  broker.user = choice.user;
  broker.ca_file = choice.ca_file.string();
  if (!choice.password_file.empty()) {
    broker.password = read_input(choice.password_file);
    while (broker.password.ends_with('\n') || broker.password.ends_with('\r')) broker.password.pop_back();
  }
  return broker;
}

// What the state topic says of the device.
class PublishedState {
 public:
  explicit PublishedState(Device& device) {
    about_["schema"] = kJsonSchema;
    about_["state"] = "online";
    about_["since_utc_s"] = utc_now_s();
    about_["arm"] = device.text(link::kDidArmName);
    about_["board"] = device.text(link::kDidBoardName);
    about_["firmware"] = device.text(link::kDidFirmwareVersion);
    about_["serial_number"] = device.text(link::kDidSerialNumber);
    about_["scene"] = device.text(link::kDidSceneName);
    about_["mode"] = link::name(device.state().mode);
  }
  // The text to publish if something has changed.
  std::optional<std::string> take(const link::Status& status, Device& device) {
    const std::string mode(link::name(status.mode));
    if (mode == about_["mode"].get<std::string>()) return std::nullopt;
    about_["mode"] = mode;
    about_["scene"] = device.text(link::kDidSceneName);
    return text();
  }
  [[nodiscard]] std::string text() const {
    return about_.dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  static std::string offline() { return Json{{"schema", kJsonSchema}, {"state", "offline"}}.dump(); }

 private:
  Json about_;
};

}  // namespace

void publish(const Common& common, const Remote& remote, const PublishChoice& choice) {
  const MqttBroker broker = broker_of(choice);
  Device device = open_device(common, remote);
  const std::uint8_t node = device.info().node;
  const std::string topic =
      choice.topic.empty() ? "thimble/" + device.text(link::kDidSerialNumber) : choice.topic;
  PublishedState state(device);
  MqttPublisher publisher(broker, topic, PublishedState::offline());
  publisher.set_state(state.text());
  heed_interrupts();
  if (!common.json) say(stderr, "publishing on {} at {}: Ctrl-C ends it\n", topic, choice.broker);

  const link::Micros start_us = now_us();
  const link::Micros end_us =
      choice.seconds > 0 ? start_us + static_cast<link::Micros>(choice.seconds * 1e6) : ~link::Micros{0};
  link::Micros heard_us = start_us;
  while (interrupted == 0 && now_us() < end_us) {
    const std::optional<link::CanFrame> frame =
        device.telemetry(std::min(end_us, now_us() + kPublishSlice_us));
    if (!frame) {
      if (now_us() - heard_us > kDeviceSilence_us)
        throw Error(ExitCode::kLinkLost, "no-telemetry", "the device has been silent for 3 s",
                    "check that it still runs");
      continue;
    }
    heard_us = now_us();
    link::visit_messages([&](auto message) {
      using Message = decltype(message);
      if constexpr (Message::kIsFrame) {
        if (!link::from_frame(*frame, node, message)) return;
        Json json = telemetry_json(node, message);
        json["utc_s"] = utc_now_s();
        publisher.publish(json.dump(-1, ' ', false, Json::error_handler_t::replace));
        if constexpr (std::is_same_v<Message, link::Status>) {
          if (const auto changed = state.take(message, device)) publisher.set_state(*changed);
        }
      }
    });
  }
  if (common.json) {
    Json json = document("publish");
    json["topic"] = topic;
    json["published"] = publisher.published();
    json["dropped"] = publisher.dropped();
    json["connections"] = publisher.connections();
    print(json);
  } else {
    say("{}: {} messages, {} dropped without a broker, {} connections\n", topic, publisher.published(),
        publisher.dropped(), publisher.connections());
  }
}

}  // namespace thimble::host
