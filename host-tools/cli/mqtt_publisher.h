// Messages to an MQTT broker (libmosquitto). Who calls it: `thimble publish`. A thread of libmosquitto keeps the connection, and makes it again when
// the broker comes back; until then messages are dropped, because a live stream of old values is of no use.
//
// Two topics: `topic` for the stream, and `topic`/state, which the broker retains. The last state is what another client gets who subscribes
// later; the broker itself sets it to kOffline when this program or its connection is lost.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

struct mosquitto;

namespace thimble::host {

struct MqttBroker {
  std::string host;
  std::uint16_t port = 1883;
  std::string user;      // empty: none
  std::string password;  // with a user
  std::string
      ca_file;  // certificates that the broker's has to be signed by; empty: the connection is not encrypted
};

class MqttPublisher {
 public:
  // Connects. Error: kLinkLost "no-broker"; kPermission "broker-refused"; kUsage, kBadInput for what libmosquitto does not accept.
  MqttPublisher(const MqttBroker& broker, std::string topic, const std::string& offline);
  MqttPublisher(const MqttPublisher&) = delete;
  MqttPublisher& operator=(const MqttPublisher&) = delete;
  ~MqttPublisher();  // tells that it is offline and disconnects; waits 2 s at most for the broker

  void publish(const std::string& message);    // at most once
  void set_state(const std::string& message);  // retained, again after each connection

  [[nodiscard]] std::uint64_t published() const { return published_; }
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }  // while there was no broker
  [[nodiscard]] unsigned connections() const { return connections_; }

 private:
  void connected(int code);
  void send_state();

  struct Free {
    void operator()(mosquitto* client) const;
  };
  std::string topic_;
  std::string offline_;
  std::unique_ptr<mosquitto, Free> client_;
  std::mutex mutex_;
  std::string state_;  // under mutex_
  std::atomic<int> refused_ = 0;
  std::atomic<unsigned> connections_ = 0;
  std::atomic<bool> disconnected_ = false;  // as asked for
  std::uint64_t published_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace thimble::host
