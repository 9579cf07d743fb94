#include "host-tools/lab/run_log.h"

#include <array>
#include <cstdio>
#include <string>

namespace thimble::host {

void write_log_header(std::ostream& out, const SceneColumns& scene) {
  out << kLogHeader;
  for (const SceneField& field : scene.fields())
    for (const std::string& column : field.columns) out << ',' << column;
  out << '\n';
}

void write_log_row(std::ostream& out, const board::LogRow& row, const SceneColumns& scene) {
  std::array<char, 320> line{};
  const int size = std::snprintf(
      line.data(), line.size(), "%.9g,%d,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%d", row.time_s,
      row.arm, row.tip_m.x(), row.tip_m.y(), row.tip_m.z(), row.proxy_m.x(), row.proxy_m.y(), row.proxy_m.z(),
      row.force_N.x(), row.force_N.y(), row.force_N.z(), row.contacts);
  out.write(line.data(), size);
  for (const double value : scene.values(row)) {
    out.put(',');
    out.write(line.data(), std::snprintf(line.data(), line.size(), "%.9g", value));
  }
  out.put('\n');
}

}  // namespace thimble::host
