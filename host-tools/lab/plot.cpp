#include "host-tools/lab/plot.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "host-tools/error.h"
#include "host-tools/files/output_file.h"
#include "host-tools/files/removed_on_signal.h"

extern char** environ;

namespace thimble::host {
namespace {

constexpr std::size_t kCurveColumns =
    2000;  // of the picture over time: in each the least and the greatest value is drawn
constexpr std::size_t kPoints = 5000;  // of the picture over depth
constexpr int kWidth = 1000, kPanelHeight = 400;

// In single quotes: in double quotes gnuplot would execute text between backquotes.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'') result += '\'';
    if (static_cast<unsigned char>(c) >= ' ') result += c;
  }
  return result + "'";
}

// Keeps the least and the greatest value for each column of the picture.
void put_curve(std::string& script, std::span<const board::LogRow> rows, double begin_s,
               const std::function<double(const board::LogRow&)>& value) {
  const std::size_t each = std::max<std::size_t>(1, rows.size() / kCurveColumns);
  for (std::size_t from = 0; from < rows.size(); from += each) {
    const auto part = rows.subspan(from, std::min(each, rows.size() - from));
    const auto [least, greatest] =
        std::ranges::minmax_element(part, {}, [&](const board::LogRow& row) { return value(row); });
    const auto put = [&](const board::LogRow& row) {
      script += fmt::format("{:.7g} {:.6g}\n", row.time_s - begin_s, value(row));
    };
    if (least == greatest) {
      put(*least);
    } else {
      put(least < greatest ? *least : *greatest);
      put(least < greatest ? *greatest : *least);
    }
  }
}

// Runs gnuplot with a script, which names the file of the picture.
void run_gnuplot(const std::string& script, const std::filesystem::path& folder) {
  const std::filesystem::path script_file = folder / "script";
  const std::filesystem::path words_file = folder / "words";
  std::ofstream(script_file, std::ios::binary) << script;
  std::array<std::string, 2> words = {"gnuplot", script_file.string()};
  std::array<char*, 3> arguments = {words[0].data(), words[1].data(), nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, words_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                   0600);
  pid_t child = 0;
  const int failed = posix_spawnp(&child, "gnuplot", &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) {
    throw Error(ExitCode::kNotFound, "no-gnuplot", "gnuplot, which draws the picture, is not there",
                "install it: sudo apt-get install gnuplot-nox");
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  std::ifstream in(words_file);
  std::string said;
  for (std::string line; std::getline(in, line) && said.size() < 300;)
    if (!line.empty()) said += (said.empty() ? "" : " ") + line;
  throw Error(ExitCode::kRefused, "plot-failed", "gnuplot failed: " + said,
              "check that gnuplot works: gnuplot --version");
}

class WorkFolder {
 public:
  WorkFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "thimble-plot-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr)
      throw Error(ExitCode::kPermission, "permission", "cannot make a folder in " + name,
                  "set TMPDIR to one that is yours");
    path_ = name;
    removed_.emplace(path_);
    for (std::size_t i = 0; i < kFiles.size(); ++i) files_[i].emplace(path_ / kFiles[i]);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  ~WorkFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  static constexpr std::array<const char*, 4> kFiles = {"script", "words", "picture.svg", "picture.png"};
  std::filesystem::path path_;
  std::optional<RemovedOnSignal> removed_;
  std::array<std::optional<RemovedOnSignal>, kFiles.size()> files_;
};

Spectrum force_spectrum(std::span<const board::LogRow> rows, double rate_Hz) {
  Spectrum sum;
  std::vector<double> samples(rows.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::transform(rows, samples.begin(),
                           [axis](const board::LogRow& row) { return row.force_N[axis]; });
    const Spectrum one = amplitude_spectrum(samples, rate_Hz);
    if (axis == 0) {
      sum = one;
      for (double& value : sum.amplitude) value *= value;
    } else {
      for (std::size_t i = 0; i < one.amplitude.size(); ++i)
        sum.amplitude[i] += one.amplitude[i] * one.amplitude[i];
    }
  }
  for (double& value : sum.amplitude) value = std::sqrt(value);
  return sum;
}

void put_time_panel(std::string& script, std::span<const board::LogRow> rows) {
  const double begin_s = rows.front().time_s;
  constexpr std::array<const char*, 3> kNames = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    script += fmt::format("$force_{} << EOD\n", kNames[static_cast<std::size_t>(axis)]);
    put_curve(script, rows, begin_s, [axis](const board::LogRow& row) { return row.force_N[axis]; });
    script += "EOD\n";
  }
  script += "$force << EOD\n";
  put_curve(script, rows, begin_s, [](const board::LogRow& row) { return row.force_N.norm(); });
  script +=
      "EOD\nset xlabel 'time in s'\nset ylabel 'force in N'\n"
      "plot $force_x using 1:2 with lines title 'x', $force_y using 1:2 with lines title 'y', "
      "$force_z using 1:2 with lines title 'z', $force using 1:2 with lines lc rgb 'black' title 'size'\n";
}

void put_depth_panel(std::string& script, std::span<const board::LogRow> rows) {
  script += "$depth << EOD\n";
  const std::size_t each = rows.size() / kPoints + 1;
  for (std::size_t i = 0; i < rows.size(); i += each)
    script += fmt::format("{:.6g} {:.6g}\n", 1e3 * (rows[i].proxy_m - rows[i].tip_m).norm(),
                          rows[i].force_N.norm());
  script +=
      "EOD\nset xlabel 'depth (from the tip to the god object) in mm'\nset ylabel 'force in N'\n"
      "plot $depth using 1:2 with points pt 7 ps 0.2 notitle\n";
}

// Notes the greatest amplitude in `result`.
void put_spectrum_panel(std::string& script, std::span<const board::LogRow> rows, PlotResult& result) {
  const Spectrum spectrum = force_spectrum(rows, result.rate_Hz);
  script += "$spectrum << EOD\n";
  for (std::size_t i = 1; i < spectrum.amplitude.size(); ++i) {
    const double frequency_Hz = static_cast<double>(i) * spectrum.bin_Hz;
    if (spectrum.amplitude[i] > result.peak_amplitude_N) {
      result.peak_amplitude_N = spectrum.amplitude[i];
      result.peak_Hz = frequency_Hz;
    }
    // The axis is logarithmic: no 0.
    script += fmt::format("{:.6g} {:.6g}\n", frequency_Hz, std::max(spectrum.amplitude[i], 1e-9));
  }
  script += fmt::format(
      "EOD\nset xlabel 'frequency in Hz ({:.3g} Hz a bin, Hann window, mean of {})'\nset ylabel 'amplitude "
      "in N'\n"
      "set logscale xy\nset format y '%g'\nplot $spectrum using 1:2 with lines notitle\n",
      spectrum.bin_Hz, spectrum.segments);
}

}  // namespace

PlotResult plot(std::span<const board::LogRow> rows, const PlotChoices& choices,
                const std::filesystem::path& output) {
  const std::string extension = output.extension().string();
  if (extension != ".svg" && extension != ".png") {
    throw Error(ExitCode::kUsage, "bad-output", output.string() + " ends in neither .svg nor .png",
                "name the picture's kind by its end");
  }
  if (rows.size() < 8) {
    throw Error(ExitCode::kBadInput, "too-short",
                fmt::format("there are {} rows of this arm; a picture has 8 at least", rows.size()),
                "record for longer, or choose the other arm");
  }
  PlotResult result;
  result.seconds = rows.back().time_s - rows.front().time_s;
  result.rate_Hz = static_cast<double>(rows.size() - 1) / result.seconds;
  for (const board::LogRow& row : rows) {
    result.peak_force_N = std::max(result.peak_force_N, row.force_N.norm());
    result.deepest_m = std::max(result.deepest_m, (row.proxy_m - row.tip_m).norm());
  }

  const WorkFolder folder;
  const std::filesystem::path drawn = folder.path() / ("picture" + extension);
  const int panels =
      static_cast<int>(choices.time) + static_cast<int>(choices.depth) + static_cast<int>(choices.spectrum);
  std::string script = fmt::format(
      "set terminal {} size {},{}\nset output {}\nset encoding utf8\nset grid\nset key top right\n"
      "set multiplot layout {},1 title {} noenhanced\n",
      extension == ".svg" ? "svg background rgb 'white'" : "png", kWidth, panels * kPanelHeight,
      quoted(drawn.string()), panels, quoted(choices.title));
  if (choices.time) put_time_panel(script, rows);
  if (choices.depth) put_depth_panel(script, rows);
  if (choices.spectrum) put_spectrum_panel(script, rows, result);
  script += "unset multiplot\nset output\n";
  run_gnuplot(script, folder.path());

  std::ifstream in(drawn, std::ios::binary);
  OutputFile file(output);
  file.stream() << in.rdbuf();
  if (!in)
    throw Error(ExitCode::kRefused, "plot-failed", "gnuplot drew nothing",
                "check that gnuplot works: gnuplot --version");
  file.commit();
  return result;
}

}  // namespace thimble::host
