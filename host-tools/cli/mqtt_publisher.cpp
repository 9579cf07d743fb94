#include "host-tools/cli/mqtt_publisher.h"

#include <mosquitto.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

#include "host-tools/error.h"

namespace thimble::host {
namespace {

constexpr int kKeepAlive_s = 10;
constexpr auto kConnect = std::chrono::seconds(5);
constexpr auto kDisconnect = std::chrono::seconds(2);  // a broker that has died does not keep the caller

std::string address(const MqttBroker& broker) { return broker.host + ":" + std::to_string(broker.port); }

std::string text_of(int code) {
  return code == MOSQ_ERR_ERRNO ? std::strerror(errno) : mosquitto_strerror(code);
}

void demand(int code, ExitCode exit_code, const char* name, const std::string& what, const char* remedy) {
  if (code != MOSQ_ERR_SUCCESS) throw Error(exit_code, name, what + ": " + text_of(code), remedy);
}

template <class Condition>
void wait_for(Condition condition, std::chrono::seconds longest) {
  const auto end = std::chrono::steady_clock::now() + longest;
  while (!condition() && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
}

}  // namespace

void MqttPublisher::Free::operator()(mosquitto* client) const {
  mosquitto_destroy(client);
  mosquitto_lib_cleanup();
}

MqttPublisher::MqttPublisher(const MqttBroker& broker, std::string topic, const std::string& offline)
    : topic_(std::move(topic)), offline_(offline) {
  mosquitto_lib_init();
  client_.reset(mosquitto_new(nullptr, true, this));
  mosquitto* const client = client_.get();
  if (client == nullptr)
    throw Error(ExitCode::kRefused, "no-memory", "libmosquitto has no memory", "free some");
  const std::string state_topic = topic_ + "/state";
  demand(mosquitto_will_set(client, state_topic.c_str(), static_cast<int>(offline.size()), offline.data(), 1,
                            true),
         ExitCode::kUsage, "bad-topic", "the topic '" + topic_ + "'", "give a topic without + and #");
  if (!broker.user.empty())
    demand(mosquitto_username_pw_set(client, broker.user.c_str(), broker.password.c_str()), ExitCode::kUsage,
           "bad-user", "the user '" + broker.user + "'", "give another name");
  if (!broker.ca_file.empty())
    demand(mosquitto_tls_set(client, broker.ca_file.c_str(), nullptr, nullptr, nullptr, nullptr),
           ExitCode::kBadInput, "bad-certificate", "the certificates of '" + broker.ca_file + "'",
           "give a file of PEM certificates");
  mosquitto_reconnect_delay_set(client, 1, 10, true);
  mosquitto_connect_callback_set(
      client, [](mosquitto*, void* self, int code) { static_cast<MqttPublisher*>(self)->connected(code); });
  mosquitto_disconnect_callback_set(client, [](mosquitto*, void* self, int code) {
    if (code == 0) static_cast<MqttPublisher*>(self)->disconnected_ = true;
  });
  demand(mosquitto_connect(client, broker.host.c_str(), broker.port, kKeepAlive_s), ExitCode::kLinkLost,
         "no-broker", "no connection to the broker at " + address(broker),
         "start it (apt-get install mosquitto), or give another --broker");
  demand(mosquitto_loop_start(client), ExitCode::kRefused, "no-thread", "no thread for the broker",
         "free resources of this machine");
  wait_for([this] { return connections_ != 0 || refused_ != 0; }, kConnect);
  if (connections_ != 0) return;
  mosquitto_loop_stop(client, true);
  if (refused_ != 0)
    throw Error(ExitCode::kPermission, "broker-refused",
                "the broker at " + address(broker) + " refused: " + mosquitto_connack_string(refused_),
                "give --user and --password-file as the broker expects them");
  throw Error(ExitCode::kLinkLost, "no-broker", "the broker at " + address(broker) + " does not answer",
              "check the address and the port");
}

MqttPublisher::~MqttPublisher() {
  if (client_ == nullptr || connections_ == 0) return;
  set_state(offline_);
  if (mosquitto_disconnect(client_.get()) == MOSQ_ERR_SUCCESS)  // after what is queued
    wait_for([this] { return disconnected_.load(); }, kDisconnect);
  mosquitto_loop_stop(client_.get(), true);
}

void MqttPublisher::publish(const std::string& message) {
  const int code = mosquitto_publish(client_.get(), nullptr, topic_.c_str(), static_cast<int>(message.size()),
                                     message.data(), 0, false);
  ++(code == MOSQ_ERR_SUCCESS ? published_ : dropped_);
}

void MqttPublisher::set_state(const std::string& message) {
  {
    const std::lock_guard lock(mutex_);
    state_ = message;
  }
  send_state();
}

// By the thread of libmosquitto.
void MqttPublisher::connected(int code) {
  if (code != 0) {
    refused_ = code;
    return;
  }
  ++connections_;
  send_state();
}

void MqttPublisher::send_state() {
  const std::lock_guard lock(mutex_);
  if (state_.empty()) return;
  const std::string topic = topic_ + "/state";
  // Without a connection it is sent by connected().
  static_cast<void>(mosquitto_publish(client_.get(), nullptr, topic.c_str(), static_cast<int>(state_.size()),
                                      state_.data(), 1, true));
}

}  // namespace thimble::host
