// thimble doctor: its findings for each state of an interface, a port and a limit; and that it reads the real
// facts.
#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "host-tools/can_tools/doctor_findings.h"

namespace thimble::test {
namespace {

using host::BusState;
using host::CanController;
using host::CanInterface;
using host::DeviceFile;
using host::DeviceKind;
using host::ExitCode;
using host::Facts;
using host::Finding;
using host::FindingState;
using host::judge;
using host::Wish;

// An interface with which nothing is wrong.
CanInterface good() {
  CanInterface can{"can0", true, true, 1000, CanController{}};
  can.controller->bit_rate = 500000;
  can.controller->sample_point = 875;
  can.controller->data_bit_rate = 2000000;
  can.controller->restart_ms = 100;
  return can;
}

Facts facts_of(const CanInterface& interface) { return {true, {interface}, {}, {std::nullopt, 99}}; }
const Wish kCan0{"can0", false, "", false};

const Finding* find(const std::vector<Finding>& findings, const std::string& name) {
  const auto at = std::ranges::find(findings, name, &Finding::name);
  return at == findings.end() ? nullptr : &*at;
}

// The one thing that is not in order.
Finding trouble(const std::vector<Finding>& findings) {
  const auto bad = [](const Finding& finding) { return finding.state != FindingState::kOk; };
  EXPECT_EQ(std::ranges::count_if(findings, bad), 1);
  const auto at = std::ranges::find_if(findings, bad);
  if (at == findings.end()) return {};
  EXPECT_FALSE(at->cause.empty());
  EXPECT_FALSE(at->remedy.empty());
  EXPECT_EQ(at->state == FindingState::kFailure, at->code != ExitCode::kOk);
  return *at;
}

TEST(Doctor, NothingIsWrong) {
  for (const Wish& wish : {Wish{}, kCan0, Wish{"can0", true, "", true}}) {
    const auto findings = judge(facts_of(good()), wish);
    for (const Finding& finding : findings) {
      EXPECT_EQ(finding.state, FindingState::kOk) << finding.name << ": " << finding.cause;
      EXPECT_EQ(finding.remedy, "");
    }
    EXPECT_EQ(find(findings, "bit-rate")->cause, "500 kbit/s, sampled at 87.5 %, FD data 2 Mbit/s");
  }
}

TEST(Doctor, NoInterface) {
  const Facts none{true, {}, {}, {std::nullopt, 99}};
  for (const Finding& finding : judge(none, {})) EXPECT_EQ(finding.state, FindingState::kOk);
  const Finding finding = trouble(judge(none, kCan0));
  EXPECT_EQ(finding.name, "no-interface");
  EXPECT_EQ(finding.code, ExitCode::kNotFound);
}

TEST(Doctor, DownIsAFailureOfTheNamedOneOnly) {
  CanInterface can = good();
  can.up = false;
  const Finding named = trouble(judge(facts_of(can), kCan0));
  EXPECT_EQ(named.name, "interface-down");
  EXPECT_EQ(named.code, ExitCode::kLinkLost);
  EXPECT_NE(named.remedy.find(
                "sudo ip link set can0 up type can bitrate 500000 dbitrate 2000000 fd on restart-ms 100"),
            std::string::npos);
  EXPECT_EQ(trouble(judge(facts_of(can), {})).state, FindingState::kWarning);
  can.controller.reset();
  EXPECT_EQ(trouble(judge(facts_of(can), kCan0)).remedy, "sudo ip link set can0 up");
}

TEST(Doctor, TheStatesOfTheBus) {
  struct Case {
    BusState state;
    const char* name;
    FindingState finding;
  };
  for (const Case& expected : {Case{BusState::kErrorWarning, "bus", FindingState::kWarning},
                               Case{BusState::kErrorPassive, "bus", FindingState::kWarning},
                               Case{BusState::kBusOff, "bus-off", FindingState::kFailure},
                               Case{BusState::kStopped, "bus", FindingState::kWarning},
                               Case{BusState::kSleeping, "bus", FindingState::kWarning}}) {
    CanInterface can = good();
    can.controller->state = expected.state;
    can.controller->transmit_errors = 136;
    const Finding finding = trouble(judge(facts_of(can), {}));
    EXPECT_EQ(finding.name, expected.name);
    EXPECT_EQ(finding.state, expected.finding);
    if (finding.state == FindingState::kFailure) {
      EXPECT_EQ(finding.code, ExitCode::kLinkLost);
    } else {
      EXPECT_NE(finding.cause.find("136 transmit"), std::string::npos) << finding.cause;
    }
  }
}

TEST(Doctor, WhatAnInterfaceCanBeSetTo) {
  CanInterface classic = good();
  classic.fd = false;
  const Finding fd = trouble(judge(facts_of(classic), {"can0", true, "", false}));
  EXPECT_EQ(fd.name, "classic-interface");
  EXPECT_EQ(fd.code, ExitCode::kUsage);
  for (const Finding& finding : judge(facts_of(classic), kCan0)) EXPECT_EQ(finding.state, FindingState::kOk);

  CanInterface short_queue = good();
  short_queue.queue_frames = 10;
  EXPECT_EQ(trouble(judge(facts_of(short_queue), kCan0)).remedy, "sudo ip link set can0 txqueuelen 1000");

  CanInterface never_back = good();
  never_back.controller->restart_ms = 0;
  EXPECT_NE(trouble(judge(facts_of(never_back), kCan0)).remedy.find("type can restart-ms 100"),
            std::string::npos);

  CanInterface mute = good();
  mute.controller->listen_only = true;
  EXPECT_EQ(trouble(judge(facts_of(mute), kCan0)).code, ExitCode::kLinkLost);
}

TEST(Doctor, OnlyTheNamedInterfaceCounts) {
  Facts facts = facts_of(good());
  CanInterface other = good();
  other.name = "can1";
  other.controller->state = BusState::kBusOff;
  facts.interfaces.push_back(other);
  for (const Finding& finding : judge(facts, kCan0)) EXPECT_EQ(finding.state, FindingState::kOk);
  EXPECT_EQ(trouble(judge(facts, {})).subject, "can1");
}

TEST(Doctor, AKernelWithoutCanSockets) {
  Facts facts = facts_of(good());
  facts.can_sockets = false;
  EXPECT_EQ(trouble(judge(facts, {})).name, "no-socketcan");
  facts.interfaces.clear();  // nor anything that would need them
  for (const Finding& finding : judge(facts, {})) EXPECT_EQ(finding.state, FindingState::kOk);
}

TEST(Doctor, PortsAndTheirGroups) {
  Facts facts{
      true, {}, {{DeviceKind::kSerial, "/dev/ttyACM0", true, false, "dialout", false}}, {std::nullopt, 99}};
  DeviceFile& port = facts.devices.front();
  const Wish named{"", false, "/dev/ttyACM0", false};
  EXPECT_EQ(trouble(judge(facts, {})).state, FindingState::kWarning);
  Finding finding = trouble(judge(facts, named));
  EXPECT_EQ(finding.code, ExitCode::kPermission);
  EXPECT_NE(finding.remedy.find("sudo usermod -aG dialout \"$USER\""), std::string::npos);
  port.member_by_now = true;
  EXPECT_NE(trouble(judge(facts, named)).remedy.find("newgrp dialout"), std::string::npos);
  port.group.clear();
  EXPECT_NE(trouble(judge(facts, named)).cause.find("root only"), std::string::npos);
  port.exists = false;
  EXPECT_EQ(trouble(judge(facts, named)).code, ExitCode::kNotFound);
  facts.devices = {{DeviceKind::kGpio, "/dev/gpiochip0", true, false, "", false}};
  EXPECT_NE(trouble(judge(facts, {})).remedy.find("thimble-board"), std::string::npos);
}

TEST(Doctor, LimitsMatterOnABoard) {
  const Facts facts{true, {}, {}, {8192 * 1024, 0}};
  for (const Finding& finding : judge(facts, {})) EXPECT_EQ(finding.state, FindingState::kOk);
  const auto findings = judge(facts, {"", false, "", true});
  for (const char* name : {"rtprio", "memlock"}) {
    EXPECT_EQ(find(findings, name)->state, FindingState::kWarning);
    EXPECT_NE(find(findings, name)->remedy.find("/etc/security/limits.d"), std::string::npos);
  }
}

TEST(Doctor, ReadsThisMachine) {
  for (const CanInterface& interface : host::read_can_interfaces()) EXPECT_FALSE(interface.name.empty());
  EXPECT_LE(host::read_privileges().priority, 99U);
  EXPECT_FALSE(host::read_device(DeviceKind::kSerial, "/dev/no-such-port").exists);

  int controller = -1, port = -1;
  std::array<char, 256> name{};
  ASSERT_EQ(openpty(&controller, &port, name.data(), nullptr, nullptr), 0);
  const DeviceFile device = host::read_device(DeviceKind::kSerial, name.data());
  EXPECT_TRUE(device.exists);
  EXPECT_TRUE(device.usable);
  close(controller);
  close(port);
}

}  // namespace
}  // namespace thimble::test
