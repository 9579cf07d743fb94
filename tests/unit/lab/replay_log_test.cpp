// Logs and their use: the CSV log, the log of a HAPI DeviceLog, the spectrum.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <sstream>

#include "board/sim/hand_path_file.h"
#include "host-tools/error.h"
#include "host-tools/lab/device_log.h"
#include "host-tools/lab/plot.h"
#include "host-tools/lab/run_log.h"
#include "host-tools/lab/spectrum.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {
namespace {

using testing::HasSubstr;

std::vector<double> sine(std::size_t samples, double rate_Hz, double frequency_Hz, double amplitude) {
  std::vector<double> values(samples);
  for (std::size_t i = 0; i < samples; ++i)
    values[i] = amplitude * std::sin(2 * std::numbers::pi * frequency_Hz * static_cast<double>(i) / rate_Hz);
  return values;
}

TEST(Spectrum, ASineHasItsAmplitudeAtItsFrequency) {
  constexpr double kRate_Hz = 4000;
  for (const std::size_t samples : {std::size_t{1000}, std::size_t{8192}, std::size_t{40'001}}) {
    const double bin_Hz = host::amplitude_spectrum(sine(samples, kRate_Hz, 1, 1), kRate_Hz).bin_Hz;
    const double frequency_Hz = 40 * bin_Hz;
    std::vector<double> values = sine(samples, kRate_Hz, frequency_Hz, 0.7);
    const std::vector<double> other = sine(samples, kRate_Hz, 100 * bin_Hz, 0.02);
    for (std::size_t i = 0; i < samples; ++i) values[i] += other[i] + 3.0;  // and a mean
    const host::Spectrum spectrum = host::amplitude_spectrum(values, kRate_Hz);
    const auto peak = std::ranges::max_element(spectrum.amplitude);
    EXPECT_EQ(peak - spectrum.amplitude.begin(), 40);
    EXPECT_NEAR(*peak, 0.7, 0.7e-3) << samples;
    EXPECT_NEAR(spectrum.amplitude[100], 0.02, 0.02e-2);
    EXPECT_LT(spectrum.amplitude[70], 1e-4) << "nothing between them";
    EXPECT_LT(spectrum.amplitude[0], 1e-3) << "the mean is taken off";
    EXPECT_NEAR(static_cast<double>(spectrum.amplitude.size() - 1) * spectrum.bin_Hz, kRate_Hz / 2, 1e-9);
  }
  // Between two bins a Hann window shows 85 % of it, and never more than it is.
  const host::Spectrum between = host::amplitude_spectrum(sine(8000, kRate_Hz, 100.25, 1.0), kRate_Hz);
  const double most = *std::ranges::max_element(between.amplitude);
  EXPECT_GT(most, 0.84);
  EXPECT_LT(most, 1.001);
  EXPECT_TRUE(host::amplitude_spectrum(std::vector<double>{1, 2, 3}, 1).amplitude.empty());
}

TEST(Spectrum, WhiteNoiseHasItsPowerInAllBins) {
  Random random(3);
  std::vector<double> noise(200'000);
  for (double& value : noise) value = random.gaussian();
  const host::Spectrum spectrum = host::amplitude_spectrum(noise, 1000);
  double power = 0;  // sines of these amplitudes have half their squares; a Hann window is 1.5 bins wide
  for (const double amplitude : spectrum.amplitude) power += amplitude * amplitude / 2 / 1.5;
  EXPECT_NEAR(figure("power of noise of 1, from its spectrum", power, "0.98 to 1.02"), 1.0, 0.02);
}

TEST(RunLog, WhatWasWrittenComesBack) {
  std::vector<board::LogRow> rows;
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    board::LogRow row;
    row.time_s = 0.25e-3 * i;
    row.arm = i % 2;
    row.tip_m = random.in_box({0.1, 0.1, 0.1});
    row.proxy_m = random.in_box({0.1, 0.1, 0.1});
    row.force_N = random.in_box({5, 5, 5});
    row.contacts = i % 4;
    rows.push_back(row);
  }
  std::ostringstream out;
  host::write_log_header(out, {});
  for (const board::LogRow& row : rows) host::write_log_row(out, row, {});
  const TemporaryFolder folder;
  const std::vector<board::LogRow> read = host::read_run_log(folder.write("log.csv", out.str()));
  ASSERT_EQ(read.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_NEAR(read[i].time_s, rows[i].time_s, 1e-9);
    EXPECT_EQ(read[i].arm, rows[i].arm);
    EXPECT_LT((read[i].tip_m - rows[i].tip_m).norm(), 1e-9);
    EXPECT_LT((read[i].proxy_m - rows[i].proxy_m).norm(), 1e-9);
    EXPECT_LT((read[i].force_N - rows[i].force_N).norm(), 1e-7);
    EXPECT_EQ(read[i].contacts, rows[i].contacts);
  }

  const auto refusal = [&](const std::string& text) {
    try {
      static_cast<void>(host::read_run_log(folder.write("bad.csv", text)));
    } catch (const host::Error& error) {
      EXPECT_EQ(error.name, "bad-log");
      EXPECT_EQ(error.code, host::ExitCode::kBadInput);
      return error.cause;
    }
    return std::string("nothing");
  };
  const std::string header = out.str().substr(0, out.str().find('\n') + 1);
  EXPECT_THAT(refusal(""), HasSubstr("it is empty"));
  EXPECT_THAT(refusal("time_s,arm\n"), HasSubstr("bad.csv:1: the header does not begin with"));
  EXPECT_THAT(refusal(header + "0,0,0,0,0,0,0,0,0,0,0\n"), HasSubstr("bad.csv:2:"));
  EXPECT_THAT(refusal(header + "0,0,0,0,0,0,0,0,0,0,0,0,0\n"), HasSubstr("bad.csv:2:"));
  EXPECT_THAT(refusal(header + "0,0,0,0,0,0,0,0,nan,0,0,0\n"), HasSubstr("no row of 12 numbers"));
  EXPECT_THAT(refusal(header + "0,2,0,0,0,0,0,0,0,0,0,0\n"), HasSubstr("arm is neither 0 nor 1"));
  EXPECT_THAT(refusal(header + "1,0,0,0,0,0,0,0,0,0,0,0\n1,0,0,0,0,0,0,0,0,0,0,0\n"),
              HasSubstr("bad.csv:3: time_s does not rise"));
}

// Of a path that is read, times, differences and speeds are finite: -1e308 to 1e308 s was one tick, and no error.
TEST(HandPathFile, RefusesTimesAndPlacesThatOverflow) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& rows) {
    try {
      static_cast<void>(board::read_hand_path(folder.write("hand.csv", "time_s,x_m,y_m,z_m\n" + rows)));
    } catch (const board::HandPathError& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  EXPECT_EQ(refusal("-1e6,1e3,0,0\n0,-1e3,0,0\n1e-9,0,0,0\n1e6,0,0,0\n"), "nothing");
  EXPECT_THAT(refusal("-1e308,0,0,0\n1e308,0,0,0\n"),
              HasSubstr("hand.csv:2: time_s is not within 1000000 of 0"));
  EXPECT_THAT(refusal("0,0,0,0\n1,0,-1e308,0\n"), HasSubstr("hand.csv:3: y_m is not within 1000 of 0"));
  EXPECT_THAT(refusal("0,0,0,0\n1e-320,0,0,0\n"), HasSubstr("hand.csv:3: time_s rises by less than 1 ns"));
}

// As HAPI writes it: log.open; names, each with its NUL; a NUL; then the values as they lie in memory.
class HapiBinary {
 public:
  HapiBinary& name(const std::string& text) {
    bytes_ += text + '\0';
    return *this;
  }
  HapiBinary& end() {
    bytes_ += '\0';
    return *this;
  }
  template <class Value>
  HapiBinary& put(Value value) {
    char raw[sizeof(Value)];
    std::memcpy(raw, &value, sizeof value);
    bytes_.append(raw, sizeof raw);
    return *this;
  }
  HapiBinary& put(double x, double y, double z) { return put(x).put(y).put(z); }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

std::string hapi_binary(int rows) {
  HapiBinary log;
  log.name("TIME").name("POSITION").name("ORIENTATION").name("FORCE").name("BUTTONS").end();
  for (int i = 0; i < rows; ++i)
    log.put(0.01 * i)
        .put(0.1, 0.2 + i, 0.3)
        .put(0.0, 0.0, 1.0)
        .put(0.5)
        .put(1.0, 2.0, 3.0)
        .put(std::int32_t{1});
  return log.bytes();
}

TEST(DeviceLog, TextAsInHapisManual) {
  const std::string text =
      "TIME POSITION ORIENTATION\n"
      "0 0.1 0.2 0.3 0 0 1 0.5\n"
      "0.01 0.1 0.22 0.3 0 0 1 0.51\n"
      "0.01 0.1 0.22 0.3 0 0 1 0.51\n"
      "0.02 0.1 0.22 0.3 0 0 1 0.51\n";
  const host::DeviceLog log = host::parse_device_log(text, "log", false);
  EXPECT_FALSE(log.binary);
  EXPECT_FALSE(log.has_force);
  EXPECT_EQ(log.columns, (std::vector<std::string>{"TIME", "POSITION", "ORIENTATION"}));
  EXPECT_EQ(log.repeated, 1U);
  ASSERT_EQ(log.samples.size(), 3U);
  EXPECT_EQ(log.samples[2].time_s, 0.02);
  EXPECT_EQ(log.samples[1].position_m, Eigen::Vector3d(0.1, -0.3, 0.22)) << "y up, z to the user";
  EXPECT_EQ(host::parse_device_log(text, "log", true).samples[1].position_m, Eigen::Vector3d(0.1, 0.22, 0.3));
}

TEST(DeviceLog, Binary) {
  const host::DeviceLog log = host::parse_device_log(hapi_binary(5), "log", false);
  EXPECT_TRUE(log.binary);
  ASSERT_EQ(log.samples.size(), 5U);
  EXPECT_EQ(log.samples[4].time_s, 0.04);
  EXPECT_EQ(log.samples[4].position_m, Eigen::Vector3d(0.1, -0.3, 4.2));
  EXPECT_EQ(log.samples[4].force_N, Eigen::Vector3d(1, -3, 2));
  // TIMESTAMP counts from an epoch.
  HapiBinary stamped;
  stamped.name("TIMESTAMP").name("RAW_POSITION").end();
  stamped.put(1e9).put(1.0, 2.0, 3.0).put(1e9 + 0.5).put(1.0, 2.0, 3.0);
  const host::DeviceLog since = host::parse_device_log(stamped.bytes(), "log", true);
  EXPECT_TRUE(since.raw);
  EXPECT_EQ(since.samples[1].time_s, 0.5);
}

TEST(DeviceLog, WhatIsNoneIsRefused) {
  const auto refusal = [](const std::string& bytes) {
    try {
      static_cast<void>(host::parse_device_log(bytes, "log", false));
    } catch (const host::Error& error) {
      EXPECT_EQ(error.name, "bad-device-log");
      EXPECT_EQ(error.code, host::ExitCode::kBadInput);
      return error.cause;
    }
    return std::string("nothing");
  };
  EXPECT_THAT(refusal(""), HasSubstr("it is empty"));
  EXPECT_THAT(refusal("TIME POSITION\n"), HasSubstr("no row of values"));
  EXPECT_THAT(refusal("TIME PLACE\n"), HasSubstr("log:1: 'PLACE' is nothing that a DeviceLog has"));
  EXPECT_THAT(refusal("TIME TIME\n"), HasSubstr("twice"));
  EXPECT_THAT(refusal("POSITION\n0 0 0\n"), HasSubstr("no TIME"));
  EXPECT_THAT(refusal("TIME FORCE\n0 0 0 0\n"), HasSubstr("no POSITION"));
  EXPECT_THAT(refusal("TIME POSITION\n0 0 0\n"), HasSubstr("log:2: the row ends before its POSITION"));
  EXPECT_THAT(refusal("TIME POSITION\n0 0 0 0 0\n"), HasSubstr("more numbers"));
  EXPECT_THAT(refusal("TIME POSITION\n0 0 zero 0\n"), HasSubstr("'zero' is no number, in POSITION"));
  EXPECT_THAT(refusal("TIME POSITION\n0 0 nan 0\n"), HasSubstr("not finite"));
  // Cut anywhere, and with any byte changed: an Error or fewer rows.
  const std::string whole = hapi_binary(5);
  Random random(5);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    try {
      EXPECT_LT(host::parse_device_log(whole.substr(0, size), "log", false).samples.size(), 5U);
    } catch (const host::Error& error) {
      EXPECT_EQ(error.name, "bad-device-log");
    }
  }
  for (int i = 0; i < 20'000; ++i) {
    std::string spoilt = i % 2 == 0 ? whole : "TIME POSITION FORCE\n0 1 2 3 4 5 6\n1 -1e5 .5 3 4 5 6\n";
    for (std::uint64_t k = random.below(3) + 1; k > 0; --k)
      spoilt[random.below(spoilt.size())] = static_cast<char>(random.bits());
    try {
      static_cast<void>(host::parse_device_log(spoilt, "log", false));
    } catch (const host::Error& error) {
      EXPECT_EQ(error.name, "bad-device-log");
    }
  }
}

}  // namespace
}  // namespace thimble::test
