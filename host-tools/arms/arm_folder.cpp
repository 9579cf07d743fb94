#include "host-tools/arms/arm_folder.h"

#include <algorithm>

namespace thimble::host {

namespace fs = std::filesystem;

std::vector<fs::path> arm_files() {
  std::vector<fs::path> files;
  std::error_code none;
  const fs::path program = fs::read_symlink("/proc/self/exe", none).parent_path();
  for (const fs::path& folder : {program / "../share/thimble/arms", program / "../../../arms"}) {
    if (program.empty() || !files.empty()) break;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, none))
      if (entry.path().filename().string().ends_with(kArmSuffix))
        files.push_back(fs::weakly_canonical(entry.path(), none));
  }
  std::ranges::sort(files);
  return files;
}

fs::path arm_path(const std::string& name_or_path) {
  for (const fs::path& file : arm_files())
    if (file.filename() == name_or_path + kArmSuffix) return file;
  return name_or_path;
}

}  // namespace thimble::host
